"""Finite-time laws of chains of integrators: the nominal laws of Steps 1, 2 and 3.

Each law of a channel has two parts: the nominal input ũ, and the *surface* u* on which ũ changes
sign (ũ = 0 exactly where u = u*). The explicit discretisation uses the first alone, the implicit
one both.
"""

from collections.abc import Callable, Sequence

from parkproof.errors import InputError
from parkproof.scalar import scalar, spow
from parkproof.validate import finite, positive


@scalar
def one_chain(e: float, gain: float, q: float) -> float:
    """Nominal law of one integrator, ũ = −λ⌈e⌋^q (Step 1, with e = u0 − 1).

    Parameters
    ----------
    e : float
        Error.
    gain : float
        λ > 0.
    q : float
        Exponent in (0, 1).

    Returns
    -------
    float
        ũ; it vanishes where e = 0.

    Examples
    --------
    >>> one_chain(8.0, 1.0, 1 / 3)
    -2.0
    """
    return -gain * spow(e, q)


@scalar
def two_chain(x: float, u: float, K1: float, k3: float, inv_q: float, r: float) -> float:
    """Nominal law of Step 3, ũ = −k̃3⌈⌈u⌋^(1/q) + k̃1^(1/q)·x⌋^(2q−1), of the chain ẋ = u, u̇ = ũ.

    Parameters
    ----------
    x, u : float
        State.
    K1 : float
        k̃1^(1/q).
    k3 : float
        k̃3 > 0.
    inv_q, r : float
        1/q and 2q − 1 for q in (1/2, 1).

    Returns
    -------
    float
        ũ; it vanishes where u = two_chain_surface(x, k̃1, q).

    Examples
    --------
    >>> two_chain(0.0, 1.0, 1.7, 6.5, 9 / 7, 5 / 9)
    -6.5
    """
    return -k3 * spow(spow(u, inv_q) + K1 * x, r)


@scalar
def two_chain_surface(x: float, k1: float, q: float) -> float:
    """Surface of `two_chain`: u* = −k̃1⌈x⌋^q.

    Parameters
    ----------
    x : float
        Position.
    k1 : float
        k̃1 > 0.
    q : float
        Exponent in (1/2, 1).

    Returns
    -------
    float
        u*.

    Examples
    --------
    >>> two_chain_surface(1.0, 1.5, 7 / 9)
    -1.5
    """
    return -k1 * spow(x, q)


@scalar
def three_chain(
    x1: float,
    x2: float,
    u1: float,
    L1: float,
    L2: float,
    l3: float,
    inv_q: float,
    inv_e: float,
    r: float,
) -> float:
    """Nominal law of Step 2, τ̃2 = −l3⌈ξ2⌋^(3q1−2).

    ξ1 = ⌈x2⌋^(1/q1) + l1^(1/q1)·x1 and ξ2 = ⌈u1⌋^(1/(2q1−1)) + l2^(1/(2q1−1))·ξ1.

    Parameters
    ----------
    x1, x2, u1 : float
        State of the chain ẋ1 = α2 u0 x2, ẋ2 = u1, u̇1 = τ̃2.
    L1, L2 : float
        l1^(1/q1) and l2^(1/(2q1−1)).
    l3 : float
        l3 > 0.
    inv_q, inv_e, r : float
        1/q1, 1/(2q1 − 1) and 3q1 − 2 for q1 in (2/3, 1).

    Returns
    -------
    float
        τ̃2; it vanishes where u1 = three_chain_surface(x1, x2, ...).

    Examples
    --------
    >>> three_chain(0.0, 0.0, 1.0, 2.3, 9.5, 21.0, 11 / 9, 11 / 7, 5 / 11)
    -21.0
    """
    xi1 = spow(x2, inv_q) + L1 * x1
    xi2 = spow(u1, inv_e) + L2 * xi1
    return -l3 * spow(xi2, r)


@scalar
def three_chain_surface(
    x1: float, x2: float, L1: float, l2: float, inv_q: float, e: float
) -> float:
    """Surface of `three_chain`: u1* = −l2⌈ξ1⌋^(2q1−1).

    Parameters
    ----------
    x1, x2 : float
        State.
    L1 : float
        l1^(1/q1).
    l2 : float
        l2 > 0.
    inv_q, e : float
        1/q1 and 2q1 − 1.

    Returns
    -------
    float
        u1*.

    Examples
    --------
    >>> three_chain_surface(0.0, 1.0, 2.3, 4.2, 11 / 9, 7 / 11)
    -4.2
    """
    return -l2 * spow(spow(x2, inv_q) + L1 * x1, e)


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
