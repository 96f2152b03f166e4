"""What gains of the homogeneous law must satisfy in Step 2, in place of (15)-(17)."""

from dataclasses import dataclass

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.laws.gains import Gains
from parkproof.proof.homogeneous_rate import Interval, proven_rate


@dataclass(frozen=True)
class HomogeneousConditions:
    """The conditions on Step 2 of the homogeneous law, judged for given bounds.

    Parameters
    ----------
    b1, b2, gamma : pairs of floats
        Intervals of the gains in ẋ1 = b1·x2, ẋ2 = b2·u1, u̇1 = γ·τ2 + φ.
    disturbance : float
        Bound of |φ|.
    rate : float or None
        β with V̇ ≤ −β proved by the matrix inequality, so that V reaches 0 within V(start)/β; None
        if none was proved.
    rho : pair of floats or None
        The inequality's ρ at both ends of γ's interval.
    largest_tau : float
        Bound of |τ2| at every state.

    Examples
    --------
    >>> one = (1.0, 1.0)
    >>> weak = HomogeneousConditions(one, one, one, 3.0, None, None, 2.0)
    >>> weak.dominated, weak.holds
    (False, False)
    """

    b1: Interval
    b2: Interval
    gamma: Interval
    disturbance: float
    rate: float | None
    rho: Interval | None
    largest_tau: float

    @property
    def dominated(self) -> bool:
        """Whether the largest input exceeds the disturbance even with the weakest γ."""
        return self.gamma[0] * self.largest_tau > self.disturbance

    @property
    def holds(self) -> bool:
        """Whether a rate is proved; without domination none could be."""
        return self.rate is not None and self.dominated


def homogeneous_conditions(
    gains: Gains, bounds: Bounds, *, tolerance: float
) -> HomogeneousConditions:
    """Judge the homogeneous law's gains of Step 2 for what the controller may know.

    Parameters
    ----------
    gains : Gains
        With ellipsoid and feedback.
    bounds : Bounds
        What the controller may know.
    tolerance : float
        At which Step 1 ends: b1 = α2·|u0|, and |u0| is that close to the run-up speed.

    Returns
    -------
    HomogeneousConditions
        The conditions, proved in exact rationals where they hold.

    Raises
    ------
    InputError
        If the gains are not the homogeneous law's, the tolerance of Step 1 is not below the run-up
        speed, or the extra "proof" is not installed.

    Examples
    --------
    >>> gains = Gains(ellipsoid=(2.0, 1.5, 0.25, 2.0, 0.5, 0.25), feedback=(-8.0, -8.0, -4.0))
    >>> found = homogeneous_conditions(gains, Bounds(disturbance=0.1), tolerance=1e-3)
    >>> found.holds, round(found.largest_tau, 2)
    (True, 9.24)
    """
    require("flint", extra="proof", purpose="the matrix inequality of the homogeneous law's Step 2")
    from parkproof.proof.checker.balls import up
    from parkproof.proof.checker.ellipsoid import Ellipsoid

    gains.check_law("homogeneous")
    ellipsoid, feedback = gains.ellipsoid, gains.feedback
    if ellipsoid is None or feedback is None:
        raise InputError("ellipsoid and feedback are missing; write those that a design gives")
    slow, fast = gains.runup_speed - tolerance, gains.runup_speed + tolerance
    if not slow > 0.0:
        raise InputError(
            f"tolerance[0] = {tolerance:g}: must be below runup_speed = {gains.runup_speed:g}, or "
            f"Step 2 may begin at rest; write for example {0.1 * gains.runup_speed:g}"
        )
    (low, high), b2 = bounds.alpha_of(1), bounds.b2
    b1, gamma, phi = (low * slow, high * fast), bounds.gamma_of(1), bounds.disturbance_of(1)
    found = proven_rate(ellipsoid, feedback, b1=b1, b2=b2, gamma=gamma, disturbance=phi)
    rate, rho = (None, None) if found is None else found
    largest = up(Ellipsoid(ellipsoid, feedback).input_bound())
    return HomogeneousConditions(b1, b2, gamma, phi, rate, rho, largest)
