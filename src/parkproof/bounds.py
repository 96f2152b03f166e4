"""What the controller may know: bounds on camera, motor gains and disturbance, and limits.

The true values live in `parkproof.model.truth`, a different type that no law is ever given.
"""

from typing import cast

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.validate import finite, increasing, not_negative, positive

Interval = tuple[float, float]


def _two_intervals(name: str, given: object) -> tuple[Interval, Interval]:
    """One interval for both channels, or one for each."""
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise InputError(
            f"{name} = {given}: must be [low, high], or [[low, high], [low, high]] for two channels"
        )
    one, two = given
    if isinstance(one, tuple | list) and isinstance(two, tuple | list):
        return increasing(f"{name}[0]", one), increasing(f"{name}[1]", two)
    if isinstance(one, tuple | list) or isinstance(two, tuple | list):
        raise InputError(f"{name}: give an interval for both channels, or one for each, not a mix")
    both = increasing(name, (one, two))
    return both, both


class Bounds(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Known bounds of the uncertain plant (6): all that a law may use of it.

    Parameters
    ----------
    alpha : pair of floats, or pair of pairs
        Bounds 0 < α_i^min ≤ α_i ≤ α_i^max of the image scales (Assumption 1), or of the gain a of
        the image unicycle; one interval for both channels or one each.
    gamma : pair of floats, or pair of pairs
        Bounds 0 < γ_i^m ≤ γ_i(t) ≤ γ_i^M of the input gains. Default (1, 1).
    disturbance : float or pair of floats
        Bounds |φ_i(t)| ≤ φ_i^M of the disturbances. Default 0.
    b2 : pair of floats
        Range of b2 in ẋ2 = b2·u1, which is 1 for the paper's robot; an image unicycle's is measured
        by the tag. No law uses it, but certificates do.

    Attributes
    ----------
    alpha, gamma : tuple of 2 intervals
        As (low, high) for each channel.
    disturbance : tuple of 2 floats
        φ_1^M, φ_2^M.

    Raises
    ------
    InputError
        If a bound is not finite, crossed, or not positive (α, γ, b2) or negative (φ).

    Examples
    --------
    >>> bounds = Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5)
    >>> bounds.alpha[1], bounds.disturbance
    ((0.5, 1.5), (2.5, 2.5))
    """

    alpha: tuple[float | Interval, float | Interval] = (1.0, 1.0)
    gamma: tuple[float | Interval, float | Interval] = (1.0, 1.0)
    disturbance: float | Interval = 0.0
    b2: Interval = (1.0, 1.0)

    def __post_init__(self) -> None:
        for name in ("alpha", "gamma"):
            intervals = _two_intervals(name, getattr(self, name))
            for low, high in intervals:
                if low <= 0.0:
                    raise InputError(
                        f"{name} = [{low:g}, {high:g}]: the lower bound must be greater than 0; "
                        f"write for example {name} = [0.5, 1.5]"
                    )
            force_setattr(self, name, intervals)
        given = self.disturbance
        pair = tuple(given) if isinstance(given, tuple | list) else (given, given)
        force_setattr(self, "disturbance", tuple(not_negative("disturbance", x) for x in pair))
        low, high = increasing("b2", self.b2)
        force_setattr(self, "b2", (positive("b2", low, example=0.8), high))

    def alpha_of(self, channel: int) -> Interval:
        """Bounds of α in a channel (0 or 1)."""
        return cast(Interval, self.alpha[channel])  # normalised on construction

    def gamma_of(self, channel: int) -> Interval:
        """Bounds of γ in a channel (0 or 1)."""
        return cast(Interval, self.gamma[channel])  # normalised on construction

    def disturbance_of(self, channel: int) -> float:
        """Bound of |φ| in a channel (0 or 1)."""
        return cast(Interval, self.disturbance)[channel]  # normalised on construction


class Limits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the robot and the picture allow; a run that leaves them ends and says so.

    Parameters
    ----------
    tau : pair of floats, optional
        Largest |τ1|, |τ2|: the inputs of (6), not the accelerations of a torque-commanded robot.
    speed, turn_rate : float, optional
        Largest |v| and |ω|.
    view : four floats, optional
        (x_min, x_max, y_min, y_max): the part of the image plane in view, in the units of x0, x1.
    saturate : bool
        If true, commands beyond ``tau`` are clipped and the run goes on, outside every guarantee;
        if false (default) the run ends with the outcome "input limit".

    Raises
    ------
    InputError
        If a limit is not positive, or the view is crossed.

    Examples
    --------
    >>> Limits(tau=(20.0, 90.0), view=(-4.0, 4.0, -3.0, 3.0)).saturate
    False
    """

    tau: tuple[float, float] | None = None
    speed: float | None = None
    turn_rate: float | None = None
    view: tuple[float, float, float, float] | None = None
    saturate: bool = False

    def __post_init__(self) -> None:
        for name in ("speed", "turn_rate"):
            if (value := getattr(self, name)) is not None:
                force_setattr(self, name, positive(name, value))
        if self.tau is not None:
            force_setattr(
                self, "tau", tuple(positive("tau", value, example=20.0) for value in self.tau)
            )
        if self.saturate and self.tau is None:
            raise InputError(
                "saturate = true needs tau = [tau1, tau2] to say at which input to clip"
            )
        if self.view is not None:
            low_x, high_x, low_y, high_y = (finite("view", value) for value in self.view)
            if not (low_x < high_x and low_y < high_y):
                raise InputError(
                    f"view = {list(self.view)}: must be [x_min, x_max, y_min, y_max] with min < max"
                )

    @property
    def saturation(self) -> tuple[float, float] | None:
        """The limits of τ if inputs are to be clipped there, else None."""
        return self.tau if self.saturate else None
