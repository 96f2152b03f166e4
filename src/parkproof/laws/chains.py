"""Finite-time laws of chains of integrators: the nominal laws of Steps 1, 2 and 3.

For fixed positions, each nominal law is a function of the chain's last state u alone, of one form:

    ũ = −gain·⌈⌈u⌋^power + offset⌋^outer.

So a law of a channel is four numbers, a `ChannelLaw`; only ``offset`` depends on the positions. It
vanishes, and changes sign, on its *surface* u* = −⌈offset⌋^(1/power).
"""

from collections.abc import Callable, Sequence

from parkproof.errors import InputError
from parkproof.scalar import scalar, spow, spow_begun, spow_ended
from parkproof.validate import finite, positive

ChannelLaw = tuple[float, float, float, float]
"""(gain, power, offset, outer) of ũ = −gain·⌈⌈u⌋^power + offset⌋^outer; no control if gain = 0."""


@scalar
def ended_error(begun: float, u: float, power: float, offset: float) -> float:
    """Error of a channel's last state whose power has been begun, the second half of `chain_error`.

    Parameters
    ----------
    begun : float
        `parkproof.scalar.spow_begun` of u and power, or what `parkproof.scalar.spows_begun` gives.
    u : float
        Last state of the chain.
    power, offset : float
        Of the channel's law.

    Returns
    -------
    float
        The error.

    Examples
    --------
    >>> ended_error(9.0, 3.0, 2.0, -1.0)
    8.0
    """
    return spow_ended(begun, u, power) + offset


@scalar
def chain_error(u: float, power: float, offset: float) -> float:
    """Error ⌈u⌋^power + offset of a channel's last state, which its law takes to zero.

    Parameters
    ----------
    u : float
        Last state of the chain.
    power, offset : float
        Of the channel's law.

    Returns
    -------
    float
        The error.

    Examples
    --------
    >>> chain_error(3.0, 2.0, -1.0)
    8.0
    """
    return ended_error(spow_begun(u, power), u, power, offset)


@scalar
def nominal_input(u: float, gain: float, power: float, offset: float, outer: float) -> float:
    """Nominal input ũ = −gain·⌈⌈u⌋^power + offset⌋^outer of a channel.

    Parameters
    ----------
    u : float
        Last state of the chain.
    gain, power, offset, outer : float
        The channel's law.

    Returns
    -------
    float
        ũ.

    Examples
    --------
    >>> nominal_input(9.0, *one_chain(1.0, 1.0, 1 / 3))
    -2.0
    """
    return -gain * spow(chain_error(u, power, offset), outer)


@scalar
def surface_of(power: float, offset: float) -> float:
    """Surface u* = −⌈offset⌋^(1/power), on which a channel's nominal input vanishes.

    Parameters
    ----------
    power, offset : float
        Of the channel's law.

    Returns
    -------
    float
        u*.

    Examples
    --------
    >>> surface_of(1.0, -1.0)
    1.0
    """
    return -spow(offset, 1.0 / power)


@scalar
def one_chain(target: float, gain: float, q: float) -> ChannelLaw:
    """Law of Step 1, ũ = −λ⌈u − target⌋^q, for one integrator u̇ = ũ.

    Parameters
    ----------
    target : float
        Where u shall go: 1 in the paper.
    gain : float
        λ > 0.
    q : float
        Exponent in (0, 1).

    Returns
    -------
    tuple of 4 floats
        The channel's law.

    Examples
    --------
    >>> one_chain(1.0, 2.0, 0.5)
    (2.0, 1.0, -1.0, 0.5)
    """
    return gain, 1.0, -target, q


@scalar
def two_chain(x: float, K1: float, k3: float, inv_q: float, r: float) -> ChannelLaw:
    """Law of Step 3, ũ = −k̃3⌈⌈u⌋^(1/q) + k̃1^(1/q)·x⌋^(2q−1), for ẋ = u, u̇ = ũ.

    Parameters
    ----------
    x : float
        Position.
    K1 : float
        k̃1^(1/q).
    k3 : float
        k̃3 > 0.
    inv_q, r : float
        1/q and 2q − 1 for q in (1/2, 1).

    Returns
    -------
    tuple of 4 floats
        The channel's law.

    Examples
    --------
    >>> nominal_input(1.0, *two_chain(0.0, 1.7, 6.5, 9 / 7, 5 / 9))
    -6.5
    """
    return k3, inv_q, K1 * x, r


@scalar
def three_chain(
    x1: float,
    x2: float,
    L1: float,
    L2: float,
    l3: float,
    inv_q: float,
    inv_e: float,
    r: float,
) -> ChannelLaw:
    """Law of Step 2, τ̃2 = −l3⌈ξ2⌋^(3q1−2), for ẋ1 = α2 u0 x2, ẋ2 = u1, u̇1 = τ̃2.

    ξ1 = ⌈x2⌋^(1/q1) + l1^(1/q1)·x1 and ξ2 = ⌈u1⌋^(1/(2q1−1)) + l2^(1/(2q1−1))·ξ1.

    Parameters
    ----------
    x1, x2 : float
        Positions.
    L1, L2 : float
        l1^(1/q1) and l2^(1/(2q1−1)).
    l3 : float
        l3 > 0.
    inv_q, inv_e, r : float
        1/q1, 1/(2q1 − 1) and 3q1 − 2 for q1 in (2/3, 1).

    Returns
    -------
    tuple of 4 floats
        The channel's law.

    Examples
    --------
    >>> nominal_input(1.0, *three_chain(0.0, 0.0, 2.3, 9.5, 21.0, 11 / 9, 11 / 7, 5 / 11))
    -21.0
    """
    xi1 = spow(x2, inv_q) + L1 * x1
    return l3, inv_e, L2 * xi1, r


def power_integrator_law(gains: Sequence[float], *, q: float) -> Callable[[Sequence[float]], float]:
    """Make the nominal law of a chain of any length, by adding a power integrator.

    With weights w_i = i·q − (i − 1), ξ_0 = z_1 and
    ξ_i = ⌈z_{i+1}⌋^(1/w_i) + l_i^(1/w_i)·ξ_{i−1}, the law is ũ = −l_r⌈ξ_{r−1}⌋^(w_r): Step 1 for
    r = 1, Step 3 for r = 2, Step 2 for r = 3.

    Parameters
    ----------
    gains : sequence of r floats
        l_1 … l_r, positive; each large enough for those before it.
    q : float
        Exponent in ((r − 1)/r, 1).

    Returns
    -------
    callable
        Takes the state (z_1, …, z_r), returns ũ.

    Raises
    ------
    InputError
        If there are no gains, one is not positive, or q lies outside its interval.

    Examples
    --------
    >>> law = power_integrator_law([2.0, 4.2, 21.0], q=9 / 11)
    >>> law([0.0, 0.0, 1.0])
    -21.0
    """
    r = len(gains)
    if r == 0:
        raise InputError("gains = []: a chain has at least one integrator; give r positive gains")
    factors = [positive("gains", gain) for gain in gains]
    if not (r - 1) / r < finite("q", q) < 1.0:
        raise InputError(f"q = {q}: must lie in ({r - 1}/{r}, 1) for a chain of length {r}")
    weights = [i * q - (i - 1) for i in range(1, r + 1)]

    def law(state: Sequence[float]) -> float:
        if len(state) != r:
            raise InputError(f"state of {len(state)} numbers: the chain has {r}; give {r}")
        xi = state[0]
        for i in range(1, r):
            inverse = 1.0 / weights[i - 1]
            xi = spow(state[i], inverse) + factors[i - 1] ** inverse * xi
        return -factors[-1] * spow(xi, weights[-1])

    return law
