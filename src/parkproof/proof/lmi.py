"""Gains of homogeneous control by convex optimisation: the shortest proven time of Step 2.

In X = P⁻¹ and y = kP⁻¹, for given β and ρ, all that Step 2 needs is linear matrix inequalities:
that V falls at the rate β at every vertex of the gains' intervals (proof in
`parkproof.proof.checker.ellipsoid`), that |τ| stays within its limit, and that the starts lie in
V ≤ 1. Line searches around them find the largest β, and the time is V/β ≤ 1/β.

A floating-point solver proves nothing. So its numbers are rounded to eight digits and proved in
exact arithmetic, and what is returned is what was proved of the rounded ones.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.proof.homogeneous_rate import (
    PAIRS,
    H,
    Interval,
    Six,
    Three,
    digits,
    golden,
    proven_rate,
)
from parkproof.validate import finite, increasing, not_negative, positive

Floats = NDArray[np.float64]
_UNKNOWNS = 9
"""Six of X and three of y; one more for the margin."""

_RHOS = np.geomspace(0.02, 20.0, 10)
"""ρ over the rate without disturbance, where the search for ρ begins."""

_GOLDEN_STEPS = 12
"""Steps of the search for ρ: its interval shrinks to 1/300."""


class HomogeneousGains(NamedTuple):
    """Gains of Step 2 under homogeneous control, with what was proved of them.

    Attributes
    ----------
    ellipsoid : six floats
        P11, P12, P13, P22, P23, P33.
    feedback : three floats
        k.
    rate : float
        β: V falls at least that fast, whatever gains and disturbance do inside their bounds.
    rho : pair of floats
        ρ of the matrix inequality at both ends of γ's interval; 0 without disturbance.
    level : float
        V nowhere exceeds it at the starts.
    """

    ellipsoid: Six
    feedback: Three
    rate: float
    rho: Interval
    level: float

    @property
    def settling_time(self) -> float:
        """Time in s within which every start is brought to zero, ``level / rate``."""
        return self.level / self.rate


def homogeneous_gains(
    *,
    b1: Interval,
    b2: Interval = (1.0, 1.0),
    gamma: Interval = (1.0, 1.0),
    disturbance: float = 0.0,
    tau_max: float,
    starts: Sequence[Three],
    state_max: Three = (math.inf, math.inf, math.inf),
) -> HomogeneousGains | None:
    """Find gains of homogeneous control with the shortest proven time from given starts.

    For ẋ1 = b1·x2, ẋ2 = b2·u1, u̇1 = γτ + φ, each gain varying as it may in its interval.

    Parameters
    ----------
    b1, b2, gamma : pairs of floats
        Intervals of the gains, positive; b1 is α2·|u0|.
    disturbance : float
        Bound of |φ|.
    tau_max : float
        Bound of |τ|, kept at every state.
    starts : sequence of three floats each
        States (x1, x2, u1); with them, all states of their convex hull, and their negatives.
    state_max : three floats
        Bounds of |x1|, |x2| and |u1| on the way, infinite where there are none.

    Returns
    -------
    HomogeneousGains or None
        None if no gains were found.

    Raises
    ------
    InputError
        If bounds are no bounds, there is no start, or the disturbance is not dominated.

    Examples
    --------
    >>> found = homogeneous_gains(b1=(0.5, 1.5), tau_max=20.0, starts=[(1.0, 0.0, 0.0)])
    >>> found.settling_time < 6.3
    True
    """
    require("clarabel", "scipy", "flint", extra="proof", purpose="the design of gains")
    intervals = (_positive("b1", b1), _positive("b2", b2), _positive("gamma", gamma))
    phi, limit = not_negative("disturbance", disturbance), positive("tau_max", tau_max)
    weakest = intervals[2][0]
    if phi >= weakest * limit:
        raise InputError(
            f"disturbance = {phi:g} with gamma = {list(gamma)} and tau_max = {limit:g}: the "
            f"weakest input {weakest * limit:g} does not dominate the disturbance; write tau_max "
            f"above {phi / weakest:g}"
        )
    points = [np.array([finite("starts", x) for x in start]) for start in starts]
    points = [point for point in points if point.any()]
    if not points:
        raise InputError("starts: no start away from the goal; give at least one (x1, x2, u1)")
    sizes = np.array([float(size) for size in state_max])
    if any(np.any(np.abs(point) >= sizes) for point in points):
        raise InputError(
            f"state_max = {list(state_max)}: a start lies outside; give starts inside these bounds"
        )
    # the solver keeps its bounds to about 1e-8: what it misses them by must not break the proof
    for margin in (1e-6, 1e-4, 1e-2):
        problem = _Inequalities(
            intervals, phi, limit * (1.0 - margin), points, sizes * (1.0 - margin)
        )
        solved = problem.fastest()
        found = None if solved is None else _proved(solved, intervals, phi, limit, points, sizes)
        if solved is None or found is not None:
            return found
    return None


def _positive(name: str, interval: Interval) -> Interval:
    """Check an interval of positive numbers."""
    low, high = increasing(name, interval)
    return positive(name, low), high


class _Solution(NamedTuple):
    """X and y that satisfy the inequalities with a ρ at each end of γ, and the rate they reach."""

    rate: float
    rho: Interval
    X: Floats
    y: Floats


class _Inequalities:
    """The linear matrix inequalities, assembled once for all β and ρ.

    Each row of an array below holds the coefficients of a matrix's triangle in the nine unknowns.
    """

    def __init__(
        self,
        intervals: Sequence[Interval],
        phi: float,
        tau_max: float,
        starts: Sequence[Floats],
        sizes: Floats,
    ) -> None:
        X, y = _unknowns()
        self._phi = phi
        self._loops = []
        for gamma in intervals[2]:
            for b1, b2 in itertools.product(*intervals[:2]):
                A = np.array([[0.0, b1, 0.0], [0.0, 0.0, b2], [0.0, 0.0, 0.0]])
                half = A @ X
                half[:, 2, :] += gamma * y
                self._loops.append(half + half.transpose(0, 2, 1))
        self._weighted = H @ X + X @ H
        self._X = X
        # what does not depend on β and ρ: |τ| ≤ tau_max, the starts, the states' bounds
        bordered = np.zeros((_UNKNOWNS, 4, 4))
        bordered[:, :3, :3] = X
        input_block = bordered.copy()
        input_block[:, 3, :3] = input_block[:, :3, 3] = y
        self._fixed = [(input_block, tau_max**2 * np.diag([0.0, 0.0, 0.0, 1.0]))]
        for start in starts:
            constant = np.diag([0.0, 0.0, 0.0, 1.0])
            constant[3, :3] = constant[:3, 3] = start
            self._fixed.append((bordered, constant))
        for i in range(3):
            if math.isfinite(sizes[i]):
                self._fixed.append((-X[:, i : i + 1, i : i + 1], np.array([[sizes[i] ** 2]])))

    def fastest(self) -> _Solution | None:
        """Search the two ρ for the largest rate: the first by golden section, the second within."""
        undisturbed = self._fastest_at((0.0, 0.0), 0.0, 1e-3 if self._phi else 1e-6)
        if undisturbed is None or self._phi == 0.0:
            return undisturbed
        best = None
        for rho in (float(ratio) * undisturbed.rate for ratio in _RHOS):
            best = self._fastest_at((rho, rho), best.rate if best else 0.0, 1e-3) or best
        if best is None:
            return None
        found = [best]

        def rate(log_rho: float) -> float:
            solution = self._fastest_with(math.exp(log_rho), found[-1].rho[1])
            if solution is not None and solution.rate > found[-1].rate:
                found.append(solution)
            return solution.rate if solution else 0.0

        near, step = math.log(best.rho[0]), math.log(_RHOS[1] / _RHOS[0])
        golden(rate, near - step, near + step, _GOLDEN_STEPS)
        return self._fastest_at(found[-1].rho, found[-1].rate, 1e-6) or found[-1]

    def _fastest_with(self, low: float, high: float) -> _Solution | None:
        """The largest rate with a ρ at the low end of γ; that at its high end is improved twice."""
        best = self._fastest_at((low, high), 0.0, 1e-4)
        for _ in range(2):
            if best is not None:
                best = self._fastest_at((low, self._best_high(best)), best.rate, 1e-4) or best
        return best

    def _best_high(self, solution: _Solution) -> float:
        """The ρ with which X and y reach the largest rate at the high end of γ."""
        values = np.concatenate([[solution.X[pair] for pair in PAIRS], solution.y])
        loops = self._loops[len(self._loops) // 2 :]

        def rate(log_rho: float) -> float:
            return self._reached(values, solution.X, loops, math.exp(log_rho))

        near = math.log(solution.rho[1])
        return math.exp(golden(rate, near - 2.0, near + 2.0, 20))

    def _fastest_at(self, rho: Interval, above: float, tolerance: float) -> _Solution | None:
        """The largest rate for a ρ by bisection; None unless it is above a given one."""
        best = self._solve(above * (1.0 + 1e-4) + 1e-9, rho)
        if best is None:
            return None
        high = math.inf
        while high > best.rate * (1.0 + tolerance):
            middle = min(2.0 * best.rate, 0.5 * (best.rate + high))
            better = self._solve(middle, rho)
            if better is None:
                high = middle
            else:
                best = better
        return best

    def _solve(self, rate: float, rho: Interval) -> _Solution | None:
        """Solve for a rate and ρ with the largest margin; None if there is no solution."""
        import clarabel
        from scipy.sparse import csc_matrix

        half = len(self._loops) // 2
        blocks = []
        for weight, loops in zip(rho, (self._loops[:half], self._loops[half:]), strict=True):
            shared, pushed = rate * self._weighted + weight * self._X, self._pushed(weight)
            blocks += [(-(loop + shared), -pushed, 1.0) for loop in loops]
        blocks += [(block, constant, 0.0) for block, constant in self._fixed]
        rows, right, cones = [], [], []
        for block, constant, margin in blocks:
            n = constant.shape[0]
            rows.append(np.column_stack([-_triangle(block), margin * _triangle(np.eye(n)[None])]))
            right.append(_triangle(constant[None])[:, 0])
            cones.append(clarabel.PSDTriangleConeT(n))
        rows.append(np.eye(1, _UNKNOWNS + 1, _UNKNOWNS))  # the margin is at most 1
        right.append(np.ones(1))
        cones.append(clarabel.NonnegativeConeT(1))
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        size = _UNKNOWNS + 1
        solver = clarabel.DefaultSolver(
            csc_matrix((size, size)),
            -np.eye(size)[-1],
            csc_matrix(np.vstack(rows)),
            np.concatenate(right),
            cones,
            settings,
        )
        values = np.array(solver.solve().x)
        if not np.all(np.isfinite(values)):
            return None
        X = np.tensordot(values[:_UNKNOWNS], self._X, 1)
        reached = min(
            self._reached(values[:_UNKNOWNS], X, loops, weight)
            for weight, loops in zip(rho, (self._loops[:half], self._loops[half:]), strict=True)
        )
        return _Solution(reached, rho, X, values[6:9]) if reached >= rate else None

    def _pushed(self, rho: float) -> Floats:
        """(φ^M²/ρ)bb', which is 0 without disturbance."""
        return np.diag([0.0, 0.0, self._phi**2 / rho if rho > 0.0 else 0.0])

    def _reached(self, values: Floats, X: Floats, loops: Sequence[Floats], rho: float) -> float:
        """The largest rate that the inequality allows at some vertices for given X, y and ρ."""
        weighted = H @ X + X @ H
        if min(np.linalg.eigvalsh(weighted)[0], np.linalg.eigvalsh(X)[0]) <= 0.0:
            return -math.inf
        root = np.linalg.inv(np.linalg.cholesky(weighted))
        added = self._pushed(rho) + rho * X
        sums = (np.tensordot(values, loop, 1) + added for loop in loops)
        return min(-float(np.linalg.eigvalsh(root @ total @ root.T)[-1]) for total in sums)


def _unknowns() -> tuple[Floats, Floats]:
    """X (9, 3, 3) and y (9, 3) as linear functions of the nine unknowns."""
    X, y = np.zeros((_UNKNOWNS, 3, 3)), np.zeros((_UNKNOWNS, 3))
    for n, (i, j) in enumerate(PAIRS):
        X[n, i, j] = X[n, j, i] = 1.0
    y[6:] = np.eye(3)
    return X, y


def _triangle(matrices: Floats) -> Floats:
    """Columns of upper triangles as the solver wants them, off-diagonals times √2."""
    n = matrices.shape[1]
    entries = [(i, j) for j in range(n) for i in range(j + 1)]
    scales = [1.0 if i == j else math.sqrt(2.0) for i, j in entries]
    return np.array([s * matrices[:, i, j] for s, (i, j) in zip(scales, entries, strict=True)])


def _proved(
    solved: _Solution,
    intervals: tuple[Interval, Interval, Interval],
    phi: float,
    tau_max: float,
    starts: Sequence[Floats],
    sizes: Floats,
) -> HomogeneousGains | None:
    """Round a solution and prove it; None if the rounded numbers break a bound."""
    from flint import arb

    from parkproof.proof.checker.balls import up
    from parkproof.proof.checker.ellipsoid import Ellipsoid

    inverse = np.linalg.inv(solved.X)
    p11, p12, p13, p22, p23, p33 = (digits(float(inverse[pair])) for pair in PAIRS)
    k1, k2, k3 = (digits(float(x)) for x in solved.y @ inverse)
    P, k = (p11, p12, p13, p22, p23, p33), (k1, k2, k3)
    ellipsoid = Ellipsoid(P, k)
    level = max((ellipsoid.level([(x, x) for x in map(float, p)]) for p in starts), key=float)
    kept = ellipsoid.input_bound() <= arb(tau_max) and all(
        bound <= arb(size) for bound, size in zip(ellipsoid.sizes(level), sizes, strict=True)
    )
    b1, b2, gamma = intervals
    proved = proven_rate(P, k, b1=b1, b2=b2, gamma=gamma, disturbance=phi) if kept else None
    return HomogeneousGains(P, k, *proved, up(level)) if proved else None
