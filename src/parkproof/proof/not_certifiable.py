"""Shows that no weights make V of Step 2 decrease for given gains: a proof from a few states.

V̇ = S0 + S1/k1 + S2/k2, where the S do not depend on the weights. If at some states, each with
values of the uncertain gains, multipliers λ > 0 make ΣλS0, ΣλS1 and ΣλS2 all positive, then
ΣλV̇ > 0 for every k1, k2 > 0 (and for every weight w > 0 of V1, which multiplies S0): whatever the
weights, V̇ is positive at one of these states. By Farkas' lemma there are such states wherever every
choice of weights misses V̇ ≤ 0 by a margin. A linear program finds them and the multipliers; the
three sums are then enclosed in balls.

A constant b1 may have weights of its own. States with different b1 show that none serve all b1;
states with one b1 show that none serve that b1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from parkproof.laws.gains import Gains
from parkproof.proof.lyapunov import ChainLyapunov
from parkproof.proof.weights import seek, sphere_of


@dataclass(frozen=True)
class Witness:
    """A state, values of the uncertain gains, and the multiplier of V̇ there.

    Attributes
    ----------
    cube : three floats
        The state's coordinates y1, ξ1/L1, ξ2/(L1 L2), exactly.
    b1, b2 : float
        The gains in ẋ1 = b1·x2 and ẋ2 = b2·u1.
    multiplier : float
        λ > 0.

    Examples
    --------
    >>> Witness((1.0, 0.0, 0.0), 1.5, 1.0, 0.25).multiplier
    0.25
    """

    cube: tuple[float, float, float]
    b1: float
    b2: float
    multiplier: float


def no_weights_exist(
    gains: Gains, *, b1: Sequence[float], b2: Sequence[float] = (1.0, 1.0), varies: bool
) -> tuple[Witness, ...]:
    """Show that no k1, k2 > 0 make V of Step 2 decrease at all states.

    Parameters
    ----------
    gains : Gains
        The law; q1, which must be a ratio, and l are used.
    b1, b2 : two floats
        Ranges of the uncertain gains.
    varies : bool
        Whether b1 may vary, and so V1 = w·x1²/2 instead of x1²/(2·b1).

    Returns
    -------
    tuple of Witness
        A proof, checked by `refute`; empty if none was found.

    Raises
    ------
    InputError
        If a range is crossed or not positive.

    Examples
    --------
    The published gains with q1 = 5/7 are out of reach of the paper's V, even for a known α2 = 1:

    >>> gains = Gains(q1="5/7")
    >>> witnesses = no_weights_exist(gains, b1=(1.0, 1.0), varies=False)
    >>> len(witnesses), refute(witnesses, gains, varies=False)
    (3, True)
    >>> no_weights_exist(Gains(q1="9/11"), b1=(1.0, 1.0), varies=False)
    ()
    """
    import numpy as np
    from scipy.optimize import linprog

    chain = ChainLyapunov(
        gains=gains.l, q=gains.exponents[1], k=(1.0, 1.0), constant_alpha=not varies
    )
    sphere = sphere_of(chain, b1=b1, b2=b2)
    seek(sphere, None)  # adds the states at which the best weights fail
    rows = np.concatenate(list(sphere.rates), axis=1)
    rows /= np.abs(rows).mean(axis=1, keepdims=True)
    count = rows.shape[1]
    found = linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=np.hstack([-rows, np.ones((3, 1))]),
        b_ub=np.zeros(3),
        A_eq=np.append(np.ones(count), 0.0)[None],
        b_eq=[1.0],
        bounds=[(0.0, None)] * count + [(None, None)],
    )
    if found.x is None or found.x[-1] <= 0.0:
        return ()
    witnesses = []
    for at in np.flatnonzero(found.x[:-1] > 0.0):
        corner, state = divmod(int(at), sphere.cube.shape[1])
        y1, xi1, xi2 = (float(entry) for entry in sphere.cube[:, state])
        end1, end2 = sphere.corners[corner]
        witnesses.append(Witness((y1, xi1, xi2), end1, end2, float(found.x[at])))
    shown = tuple(witnesses)
    return shown if refute(shown, gains, varies=varies) else ()


def refute(witnesses: Sequence[Witness], gains: Gains, *, varies: bool) -> bool:
    """Check in ball arithmetic that V̇ > 0 at one of the states, whatever the weights.

    Parameters
    ----------
    witnesses : sequence of Witness
        States and multipliers.
    gains : Gains
        The law; q1, which must be a ratio, and l are used.
    varies : bool
        As in `no_weights_exist`.

    Returns
    -------
    bool
        Whether it is proved.

    Examples
    --------
    >>> refute([Witness((1.0, 0.0, 0.0), 1.0, 1.0, 1.0)], Gains(), varies=False)
    False
    """
    from flint import arb

    from parkproof.proof.checker.balls import exact
    from parkproof.proof.checker.chains import ThreeChain

    def total(k1: float, k2: float) -> arb:
        loop = ThreeChain(str(gains.exponents[1]), gains.l, (k1, k2), 1.0 if varies else None)
        return sum(
            (
                exact(w.multiplier)
                * loop.value_and_rate(tuple(map(exact, w.cube)), exact(w.b1), exact(w.b2))[1]
                for w in witnesses
            ),
            arb(0),
        )

    if not all(min(w.b1, w.b2, w.multiplier) > 0.0 for w in witnesses):
        return False
    # Twice the inverse of a weight adds its sum once more.
    both, first, second = total(1.0, 1.0), total(0.5, 1.0), total(1.0, 0.5)
    sums = (3 * both - first - second, first - both, second - both)
    return all(bool(term > 0) for term in sums)
