"""The delay from a command to its image, fitted to the headings that followed.

The heading in the image obeys ψ̇ = β ω (`parkproof.model.image_unicycle`), where ω follows the
command after a delay and through a first-order lag. Given these two, everything else is linear: how
far the robot turns for a command of either sign, the start of a dead-band, and how β varies with
the heading. So least squares search two numbers only.
"""

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.validate import positive

Array = NDArray[np.float64]
Pair = tuple[float, float]

LEAST_SAMPLES = 60
"""Fewer headings than this are no basis for a fit."""

LEAST_TURN = 0.02
"""A robot whose heading varies by less than this, in rad, counts as one that does not move."""

LEAST_SHARE = 0.05
"""So does one that turns by less than this share of what it is told."""

LEAST_EXPLAINED = 0.9
"""Share of the heading's variance that the fit must explain."""

LARGEST_ERROR = 0.02
"""If delay and lag together are less certain than this, in s, they count as not measured."""

STEP = 1e-3
"""Step in s of the derivatives."""

SIGNIFICANT = 1.96**2
"""In variances: what noise exceeds in 5 % of all cases."""

USUAL = {"difference": 0.3, "dead-band": 0.1, "square": 0.5, "cube": 0.5}
"""How large the unknowns beside the gain usually are, in rad, rad/s and their powers: the share by
which the gains of both directions differ, a dead-band, and how β varies with the heading."""


class DelayOutcome(enum.Enum):
    """What came of measuring a delay.

    Examples
    --------
    >>> DelayOutcome.NOT_MOVING.sentence
    'the robot did not turn as it was told: is it switched on, and is this its tag?'
    """

    MEASURED = "the delay was measured"
    NOT_SEEN = "the tag was seen in too few frames: is it in view, and lit?"
    NOT_TOLD = "the robot was not told to turn often enough"
    NOT_MOVING = "the robot did not turn as it was told: is it switched on, and is this its tag?"
    UNCLEAR = "the robot turned, but not in a way that follows from its commands"
    SILENT = "the robot did not answer"
    ENDED = "the camera ended before enough was seen"

    @property
    def sentence(self) -> str:
        """In words."""
        return self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class DelayFit:
    """A delay with how sure it is.

    Parameters
    ----------
    outcome : DelayOutcome
        Whether it was measured. If not, the numbers may be NaN.
    delay : float
        Time in s from a command to its effect at the time that the frames carry.
    delay_error : float
        95 % of such measurements are off by less than this, in s, if the robot is as the model
        says. A wide dead-band makes it too small.
    lag : float
        Time constant in s with which the robot follows after the delay.
    total_error : float
        As ``delay_error``, of `total`, which is known better: a short lag looks much like a delay.
    gain : float
        Turn of the heading in the image for a commanded turn; negative in a mirrored image.
    residual : float
        Root mean square in rad of what the fit does not explain.
    samples : int
        Headings that were used.

    Examples
    --------
    >>> DelayFit(outcome=DelayOutcome.NOT_SEEN).measured
    False
    """

    outcome: DelayOutcome
    delay: float = math.nan
    delay_error: float = math.nan
    lag: float = math.nan
    total_error: float = math.nan
    gain: float = math.nan
    residual: float = math.nan
    samples: int = 0

    @property
    def measured(self) -> bool:
        """Whether the delay may be used."""
        return self.outcome is DelayOutcome.MEASURED

    @property
    def total(self) -> float:
        """Delay and lag together in s: by how much a steady turn is seen too late."""
        return self.delay + self.lag


def fit_delay(
    command_times: Sequence[float] | Array,
    commands: Sequence[float] | Array,
    pose_times: Sequence[float] | Array,
    headings: Sequence[float] | Array,
    *,
    longest_delay: float = 0.5,
    longest_lag: float = 0.3,
) -> DelayFit:
    """Fit the delay, lag and gain between turn rates that were sent and headings that were seen.

    Parameters
    ----------
    command_times : array of m floats
        When commands were sent, in s, increasing. Before the first the robot is at rest.
    commands : array of m floats
        The turn rates ω that were sent, in rad/s, each held until the next.
    pose_times : array of n floats
        Times of the headings on the same clock, in s, increasing.
    headings : array of n floats
        Headings in the image, in rad; may wrap.
    longest_delay, longest_lag : float
        Where to search, in s.

    Returns
    -------
    DelayFit
        The fit, or why there is none.

    Raises
    ------
    InputError
        If the arrays do not fit together, hold what is no number, or times do not increase.

    Examples
    --------
    >>> t = np.arange(0.0, 15.0, 1 / 30)
    >>> omega = np.where(np.sin(4.0 * t) + np.sin(7.3 * t) > 0.0, 0.5, -0.5)
    >>> fine = np.arange(0.0, 15.0, 1e-3)
    >>> psi = np.cumsum(omega[np.searchsorted(t, fine, side="right") - 1]) * 1e-3
    >>> fit = fit_delay(t, omega, t, -0.8 * np.interp(t - 0.085, fine + 1e-3, psi))
    >>> f"{fit.delay:.3f}", f"{abs(fit.lag):.3f}", f"{fit.gain:.2f}"
    ('0.085', '0.000', '-0.80')
    """
    positive("longest_delay", longest_delay, example=0.5)
    positive("longest_lag", longest_lag, example=0.3)
    t, omega = _checked("command_times", command_times, "commands", commands)
    s, psi = _checked("pose_times", pose_times, "headings", headings)
    if s.size < LEAST_SAMPLES:
        return DelayFit(outcome=DelayOutcome.NOT_SEEN, samples=s.size)
    if t.size == 0 or np.count_nonzero(np.diff(np.sign(omega))) < 4:
        return DelayFit(outcome=DelayOutcome.NOT_TOLD, samples=s.size)
    psi = np.unwrap(psi)
    model = _Model(t, omega, s)
    asked = model.turn(0.0, 0.0)
    if np.ptp(psi) < max(LEAST_TURN, LEAST_SHARE * float(np.ptp(asked))):
        return DelayFit(outcome=DelayOutcome.NOT_MOVING, samples=s.size)
    longest = (longest_delay, longest_lag)
    found = _search(model, psi, longest)
    rest = model.residual(psi, *found)
    spread = 1.4826 * float(np.median(np.abs(rest)))
    kept = np.abs(rest) <= 6.0 * max(spread, 1e-5)  # a tag is sometimes seen where it is not
    if not np.all(kept):
        model, psi = _Model(t, omega, s[kept]), psi[kept]
        found = _search(model, psi, longest)
    found = _without_lag(model, psi, found, _noise(model, psi, found))
    return _judged(model, psi, found, longest)


def _judged(model: "_Model", psi: Array, found: Pair, longest: Pair) -> DelayFit:
    """How sure a fit is, and whether that will do."""
    total, lag = found
    rest = model.residual(psi, *found)
    residual = float(np.sqrt(np.mean(rest**2)))
    variance = _noise(model, psi, found)
    slopes = _slopes(model, psi, found)
    covariance = variance * np.linalg.pinv(slopes.T @ slopes)
    total_error = math.sqrt(max(SIGNIFICANT * float(covariance[0, 0]), 0.0))
    # The cost grows with a change of the lag more slowly than its square where that is near 0.
    lag_error = _reach(model, psi, found, SIGNIFICANT * variance, longest[1])
    explained = 1.0 - residual**2 / max(float(np.var(psi)), 1e-300)
    good = (
        explained >= LEAST_EXPLAINED
        and total_error <= LARGEST_ERROR
        and total - lag < longest[0] - STEP
    )
    return DelayFit(
        outcome=DelayOutcome.MEASURED if good else DelayOutcome.UNCLEAR,
        delay=total - lag,
        delay_error=math.hypot(total_error, lag_error),
        lag=lag,
        total_error=total_error,
        gain=model.gain(psi, *found),
        residual=residual,
        samples=psi.size,
    )


class _Model:
    """Headings as a linear function of a few unknowns, given the total delay and the lag in it."""

    linear = 6

    def __init__(self, t: Array, omega: Array, s: Array) -> None:
        self._s = s
        start = min(float(t[0]), float(s[0])) - 10.0
        self._t = np.concatenate(([start], t))
        # The turn, what the directions differ by, and the start of a dead-band.
        inputs = np.stack([omega, np.abs(omega), np.sign(omega)], axis=1)
        self._inputs = np.concatenate((np.zeros((1, 3)), inputs))
        held = np.diff(self._t)[:, None] * self._inputs[:-1]
        self._integrals = np.concatenate((np.zeros((1, 3)), np.cumsum(held, axis=0)))

    def turn(self, total: float, lag: float) -> Array:
        """The angle that is turned if the robot does as it is told."""
        angle: Array = self._lagged(total - lag, lag)[:, 0]
        return angle

    def residual(self, psi: Array, total: float, lag: float) -> Array:
        """What the best of all headings with this delay leaves unexplained."""
        return self._fit(psi, total, lag)[0]

    def gain(self, psi: Array, total: float, lag: float) -> float:
        """Turn of the heading for a commanded turn at the usual turn rate."""
        best = self._fit(psi, total, lag)[1]
        rates = np.abs(self._inputs[:, 0])
        return float(best[1] + best[3] / np.median(rates[rates > 0.0]))

    def _fit(self, psi: Array, total: float, lag: float) -> tuple[Array, Array]:
        """What is left unexplained, and the unknowns."""
        lagged = self._lagged(total - lag, lag)
        columns = np.column_stack((np.ones(psi.size), lagged - lagged.mean(axis=0)))
        # First how far it has turned, then the powers of that.
        angle = columns @ _least_squares(columns, psi)
        angle = angle - angle.mean()
        columns = np.column_stack((columns, angle**2, angle**3))
        best = _least_squares(columns, psi)
        rest: Array = psi - columns @ best
        return rest, best

    def _lagged(self, delay: float, lag: float) -> Array:
        """Integrals of the lagged inputs: as ẏ = (u − y)/T, ∫y = ∫u − T y."""
        s = self._s - delay
        place = np.maximum(np.searchsorted(self._t, s, side="right") - 1, 0)
        since = (s - self._t[place])[:, None]
        u = self._inputs[place]
        integral: Array = self._integrals[place] + u * since
        if lag < 1e-6:
            return integral
        fades = np.exp(-np.diff(self._t) / lag).tolist()
        states = np.empty_like(self._inputs)
        for column in range(self._inputs.shape[1]):
            y, at = 0.0, [0.0]
            for fade, held in zip(fades, self._inputs[:-1, column].tolist(), strict=True):
                y = held + (y - held) * fade
                at.append(y)
            states[:, column] = at
        y_now = u + (states[place] - u) * np.exp(-since / lag)
        angle: Array = integral - lag * y_now
        return angle


def _least_squares(columns: Array, values: Array) -> Array:
    """Least squares in which what is unusual costs as much as a milliradian of noise."""
    usual = np.array([1e3, 1e1, *USUAL.values()])[: columns.shape[1]]
    scaled = columns * usual
    square = scaled.T @ scaled + 1e-6 * np.eye(usual.size)
    best: Array = usual * np.linalg.solve(square, scaled.T @ values)
    return best


def _cost(model: _Model, psi: Array, total: float, lag: float) -> float:
    rest = model.residual(psi, total, lag)
    return float(rest @ rest)


def _search(model: _Model, psi: Array, longest: Pair) -> Pair:
    """Least squares over total delay and lag: the best of a grid, then Gauss-Newton steps."""
    grid = [
        (float(delay) + longest[1] * share, longest[1] * share)
        for delay in np.linspace(0.0, longest[0], 26)
        for share in (0.0, 0.1, 0.2, 0.4, 0.7, 1.0)
    ]
    costs = [_cost(model, psi, *at) for at in grid]
    best, least = grid[int(np.argmin(costs))], min(costs)
    damping = 1e-3
    while damping < 1e6:
        slopes = _slopes(model, psi, best)
        square = slopes.T @ slopes
        damped = square + damping * np.diag(np.diag(square)) + 1e-12 * np.eye(2)
        step = np.linalg.solve(damped, slopes.T @ model.residual(psi, *best))
        lag = min(max(best[1] - float(step[1]), 0.0), longest[1])
        tried = (min(max(best[0] - float(step[0]), lag), longest[0] + lag), lag)
        reached = _cost(model, psi, *tried)
        if reached >= least:
            damping *= 10.0
            continue
        moved = max(abs(tried[0] - best[0]), abs(tried[1] - best[1]))
        best, least, damping = tried, reached, 0.1 * damping
        if moved < 1e-6:
            break
    return best


def _without_lag(model: _Model, psi: Array, found: Pair, variance: float) -> Pair:
    """The same without a lag, where one explains no more than noise does."""
    delays = found[0] + 1e-3 * np.linspace(-10.0, 10.0, 41)
    costs = [_cost(model, psi, float(delay), 0.0) for delay in delays]
    if min(costs) > _cost(model, psi, *found) + SIGNIFICANT * variance:
        return found
    return float(delays[int(np.argmin(costs))]), 0.0


def _noise(model: _Model, psi: Array, found: Pair) -> float:
    """Variance of one heading, as if they erred independently."""
    rest = model.residual(psi, *found)
    # Neighbours err alike: there is less to learn from them than from as many that do not.
    alike = float(rest[1:] @ rest[:-1]) / max(float(rest @ rest), 1e-300)
    alike = min(max(alike, 0.0), 0.95)
    freedom = max(psi.size - model.linear - 2, 1)
    return float(rest @ rest) / freedom * (1.0 + alike) / (1.0 - alike)


def _reach(model: _Model, psi: Array, found: Pair, more: float, longest_lag: float) -> float:
    """How far the lag can be off, at the best total delay, before the cost has grown by so much."""
    total, lag = found
    allowed = _cost(model, psi, *found) + more
    largest = 0.0
    for end in (max(lag - 0.5 * longest_lag, 0.0), min(lag + 0.5 * longest_lag, total)):
        inside, outside = lag, end
        if _cost(model, psi, total, end) <= allowed:
            inside = end
        for _ in range(8):
            middle = 0.5 * (inside + outside)
            if _cost(model, psi, total, middle) <= allowed:
                inside = middle
            else:
                outside = middle
        largest = max(largest, abs(inside - lag))
    return largest


def _slopes(model: _Model, psi: Array, at: Pair) -> Array:
    """Derivatives of the residual by total delay and lag."""
    total, lag = at
    low = max(lag - STEP, 0.0)  # there is no lag below 0
    return np.stack(
        [
            (model.residual(psi, total + STEP, lag) - model.residual(psi, total - STEP, lag))
            / (2.0 * STEP),
            (model.residual(psi, total, lag + STEP) - model.residual(psi, total, low))
            / (lag + STEP - low),
        ],
        axis=1,
    )


def _checked(
    time_name: str, times: Sequence[float] | Array, name: str, values: Sequence[float] | Array
) -> tuple[Array, Array]:
    """Two arrays that belong together, without what is no number."""
    t = np.asarray(times, dtype=np.float64)
    x = np.asarray(values, dtype=np.float64)
    if t.ndim != 1 or t.shape != x.shape:
        raise InputError(
            f"{time_name} and {name} have shapes {t.shape} and {x.shape}: must be two lists of the "
            "same length"
        )
    if not (np.all(np.isfinite(t)) and np.all(np.isfinite(x))):
        raise InputError(f"{time_name} and {name} must be finite numbers; leave out the others")
    if np.any(np.diff(t) <= 0.0):
        at = int(np.argmax(np.diff(t) <= 0.0))
        raise InputError(
            f"{time_name}[{at + 1}] = {t[at + 1]:g} follows {t[at]:g}: times must increase; sort "
            "them"
        )
    return t, x
