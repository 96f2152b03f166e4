"""Makes certificates of Step 2: weights are sought by sampling, then the claim is proved in balls.

The weights do not enter the law, so they are free; the proof is that of `parkproof.proof.verify`,
which anyone can repeat with that module alone.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from parkproof import __version__
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.lyapunov import ChainLyapunov, settling_bound, step2_lyapunov
from parkproof.proof.sphere import worst_ratio
from parkproof.validate import increasing, positive

SHARES = (0.99, 0.95, 0.8, 0.5)
"""Shares of the sampled rate that are tried in turn: the nearer to 1, the more boxes."""


@dataclass(frozen=True)
class Step2Certificate:
    """A certificate of Step 2, and what was sampled on the way.

    Attributes
    ----------
    certificate : dict
        As it is written to a file; `parkproof.proof.verify` re-proves it.
    sampled_rate : float
        The largest c that sampling left possible with these weights.
    boxes : int
        Boxes looked at in the proof.

    Examples
    --------
    >>> Step2Certificate({}, 1.24, 48_000).boxes
    48000
    """

    certificate: dict[str, Any]
    sampled_rate: float
    boxes: int


def _lyapunov(gains: Gains, weights: Sequence[float], *, varies: bool) -> ChainLyapunov:
    return step2_lyapunov(gains, k=tuple(weights), constant_alpha=not varies)


def best_weights(
    gains: Gains, *, b1: tuple[float, float], varies: bool, start: Sequence[float] = (1.0, 0.0, 0.0)
) -> tuple[tuple[float, float], float]:
    """Seek the weights k1, k2 with the shortest sampled bound of the settling time.

    Parameters
    ----------
    gains : Gains
        The law; q1 and l are used.
    b1 : two floats
        Range of b1 = α2|u0|.
    varies : bool
        Whether b1 may vary in time.
    start : three floats
        The start (x1, x2, u1) whose bound is made short.

    Returns
    -------
    tuple
        (k1, k2), and the sampled rate c; not positive if no weights were found.

    Examples
    --------
    >>> (k1, k2), rate = best_weights(Gains(q1="13/15"), b1=(0.5, 1.5), varies=False)
    >>> rate > 1.6
    True
    """
    from scipy.optimize import minimize

    exponent = 0.5 * (1.0 + gains.exponents[1])

    def merit(logs: Sequence[float]) -> float:
        lyapunov = _lyapunov(gains, [math.exp(x) for x in logs], varies=varies)
        rate = -worst_ratio(lyapunov, alpha=b1, points=21, zooms=6).ratio
        if rate <= 0.0:
            return 1e3 - rate
        value = max(float(lyapunov.value(*start, alpha=end)) for end in b1)
        return math.log(settling_bound(value, c=rate, exponent=exponent))

    scale = 1.0 if not varies else 1.0 / b1[1]
    guesses = [
        (math.log(scale * k1), math.log(scale * k2)) for k1, k2 in ((4.0, 200.0), (1.5, 20.0))
    ]
    found = min(
        (
            minimize(
                merit,
                guess,
                method="Nelder-Mead",
                options={"maxiter": 160, "xatol": 3e-3, "fatol": 1e-4},
            )
            for guess in guesses
        ),
        key=lambda result: float(result.fun),
    )
    weights = (float(f"{math.exp(found.x[0]):.6g}"), float(f"{math.exp(found.x[1]):.6g}"))
    rate = -worst_ratio(_lyapunov(gains, weights, varies=varies), alpha=b1).ratio
    return weights, rate


def certify_step2(
    gains: Gains,
    *,
    b1: tuple[float, float],
    b2: tuple[float, float] = (1.0, 1.0),
    varies: bool = False,
    start: Sequence[tuple[float, float]] = ((-1.0, 1.0), (0.0, 0.0), (0.0, 0.0)),
    weights: tuple[float, float] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Step2Certificate | None:
    """Prove that Step 2 settles within a time, from every start of a box, for every b1, b2, γ, φ.

    Parameters
    ----------
    gains : Gains
        The law; q1, which must be a ratio, and l are used.
    b1 : two floats
        Range of b1 = α2·|u0| in ẋ1 = b1·x2.
    b2 : two floats
        Range of b2 in ẋ2 = b2·u1.
    varies : bool
        Whether b1 may vary in time; otherwise it is an unknown constant.
    start : three pairs
        Ranges of x1, x2 and u1 at the start of Step 2.
    weights : two floats, optional
        k1, k2 of V; default: sought.
    progress : callable
        Told what is being done.

    Returns
    -------
    Step2Certificate or None
        None if no claim of this form could be proved.

    Raises
    ------
    InputError
        If a range is crossed or not positive, or q1 is no ratio of integers.

    Examples
    --------
    >>> found = certify_step2(Gains(q1="13/15"), b1=(0.5, 1.5), weights=(2.71, 79.6))
    >>> found.certificate["claim"]["rate"] > 1.6
    True
    """
    from flint import ctx

    from parkproof.proof import verify

    q1 = gains.exponents[1]
    if q1.fraction is None:
        raise InputError(f'q1 = {q1}: a certificate needs a ratio of integers; write q1 = "9/11"')
    for name, (low, high) in (("b1", b1), ("b2", b2)):
        increasing(name, (positive(name, low), positive(name, high)))
    box = [list(increasing("start", pair)) for pair in start]
    progress("seeking weights of V by sampling")
    corner = [max(abs(low), abs(high)) for low, high in box]
    chosen, sampled = (
        best_weights(gains, b1=b1, varies=varies, start=corner)
        if weights is None
        else (weights, -worst_ratio(_lyapunov(gains, weights, varies=varies), alpha=b1).ratio)
    )
    if sampled <= 0.0:
        return None
    ctx.prec = verify.PRECISION
    loop = verify.Step2(str(q1), gains.l, chosen, 1.0 if varies else None)
    ends = [(verify.exact(x), verify.exact(z)) for x in sorted(set(b1)) for z in sorted(set(b2))]
    for share in SHARES:
        rate = float(f"{share * sampled:.6g}")
        progress(f"proving the rate {rate:g} (sampled: {sampled:.4g})")
        counts = []
        for x, z in ends:
            counts.append(verify.prove_rate(loop, verify.exact(rate), x, z))
            if counts[-1] == 0:
                break
        if all(counts):
            claim = {"rate": rate, "step2_time": _time(loop, rate, ends, box)}
            body = _body(gains, chosen, claim, b1=b1, b2=b2, varies=varies, box=box)
            return Step2Certificate(
                {**body, "digest": verify.digest_of(body)}, sampled, sum(counts)
            )
    return None


def _time(loop: Any, rate: float, ends: list[tuple[Any, Any]], box: list[list[float]]) -> float:
    """The smallest time, on a grid of 1 %, that is proved to bound the settling time."""
    from parkproof.proof import verify

    low, high = 1e-3, 1e-3
    c = verify.exact(rate)

    def holds(seconds: float) -> bool:
        return all(verify.prove_time(loop, c, x, box, verify.exact(seconds)) for x, _ in ends)

    while not holds(high):
        low, high = high, 2.0 * high
    while high > 1.002 * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    rounded = float(f"{1.001 * high:.4g}")
    return rounded if holds(rounded) else float(f"{1.01 * high:.4g}")


def _body(
    gains: Gains,
    weights: tuple[float, float],
    claim: dict[str, float],
    *,
    b1: tuple[float, float],
    b2: tuple[float, float],
    varies: bool,
    box: list[list[float]],
) -> dict[str, Any]:
    """A certificate without its digest."""
    from importlib.metadata import version

    from parkproof.proof import verify

    return {
        "schema": verify.SCHEMA,
        "claim": claim,
        "assumptions": {
            "b1": [float(x) for x in b1],
            "b1_varies": varies,
            "b2": [float(x) for x in b2],
            "start": box,
        },
        "law": {"q1": str(gains.exponents[1]), "l": [float(x) for x in gains.l]},
        "lyapunov": {"k": [float(x) for x in weights], "w": 1.0 if varies else None},
        "sampled": [],
        "method": "bisection of the homogeneous sphere in ball arithmetic (Arb)",
        "versions": {"parkproof": __version__, "python-flint": version("python-flint")},
    }
