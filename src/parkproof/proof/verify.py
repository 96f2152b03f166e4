"""Re-proves a certificate. Imports the standard library and ball arithmetic (Arb) alone.

The claim is about Step 2 in continuous time: the chain ẋ1 = b1·x2, ẋ2 = b2·u1, u̇1 = τ̃2 under the
law τ̃2 = −l3⌈ξ2⌋^(3q−2), in the linearising coordinates y1 = x1, y2 = ⌈x2⌋^(1/q),
y3 = ⌈u1⌋^(1/(2q−1)), with ξ1 = y2 + L1·y1, ξ2 = y3 + L2·ξ1. With weights k1, k2,

    V = V1 + I(−L1·y1, y2; q)/k1 + I(−L2·ξ1, y3; 2q − 1)/k2,
    I(a, y; n) = ∫_a^y ⌈s − a⌋^(2−n) n|s|^(n−1) ds,
    J(a, y; n) = ∫_a^y |s − a|^(1−n) n|s|^(n−1) ds,

where V1 = y1²/(2·b1) for a constant b1, and V1 = w·y1²/2 for one that varies. It is proved that
V̇ + c·V^((1+q)/2) < 0 on the surface max(|y1|, |ξ1|/L1, |ξ2|/(L1·L2)) = 1. Every dilation orbit
meets that surface, V has degree 2 and V̇ degree 1 + q, so the inequality holds everywhere but at 0,
and Lemma 1 bounds the settling time by 2·V(0)^((1−q)/2)/(c(1−q)). By Theorem 1 the same holds under
τ2 = (τ̃2 + φ^M sign τ̃2)/γ^m for every γ ≥ γ^m and |φ| ≤ φ^M.

End points of b1 and b2 suffice: V̇ is affine in them; for a constant b1, V = A/b1 + B and so
V^((1+q)/2) is convex in b1, and −V̇ − c·V^((1+q)/2) is concave in (b1, b2). J(a, y) grows with y
and falls with a, and I grows as either end moves away from the other: their values at corners
enclose them on boxes.
"""

import hashlib
import itertools
import json
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from flint import arb, ctx, fmpq

SCHEMA = "parkproof-certificate-1"
PRECISION = 64
"""Bits of the ball arithmetic."""

GRID = 2.0**30
"""Ends of integrals are moved outwards to multiples of 1/GRID, so that none lies just beside 0."""

MAX_BOXES = 2_000_000
"""Boxes after which the proof of a claim is given up."""

SMALLEST_BOX = 2.0**-20

Box = tuple[arb, arb, arb]


class NotACertificateError(ValueError):
    """A file that cannot be read as a certificate, or whose digest is wrong."""


def digest_of(certificate: dict[str, Any]) -> str:
    """SHA-256 of all of a certificate but its digest.

    Parameters
    ----------
    certificate : dict
        The certificate, with or without its digest.

    Returns
    -------
    str
        Hexadecimal digest of its canonical JSON.

    Examples
    --------
    >>> digest_of({"a": 1, "digest": "x"}) == digest_of({"a": 1})
    True
    """
    rest = {key: value for key, value in certificate.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def exact(value: float | str) -> arb:
    """Enclose a number given as a float (its exact binary value) or as a ratio.

    Parameters
    ----------
    value : int, float or str
        The number; a string is a ratio such as "9/11".

    Returns
    -------
    arb
        A ball around it.

    Examples
    --------
    >>> (exact("9/11") * 11).contains(9), exact(0.5) == arb(0.5)
    (True, True)
    """
    ratio = Fraction(value)
    return arb(fmpq(ratio.numerator, ratio.denominator))


def _hull(one: arb, two: arb) -> arb:
    return one.union(two)


def _point_power(x: arb, p: arb) -> arb:
    """⌈x⌋^p of an exact number."""
    if x > 0:
        return x**p
    return -((-x) ** p) if x < 0 else arb(0)


def power(x: arb, p: arb) -> arb:
    """Enclose the signed power ⌈x⌋^p, which increases in x.

    Parameters
    ----------
    x : arb
        A ball.
    p : arb
        A positive exponent.

    Returns
    -------
    arb
        The hull of the powers of its ends.

    Examples
    --------
    >>> power(arb(-8), arb(1) / 3).contains(-2)
    True
    """
    return _hull(_point_power(x.lower(), p), _point_power(x.upper(), p))


def _size(x: arb) -> arb:
    low, high = x.lower(), x.upper()
    if low >= 0:
        return x
    return -x if high <= 0 else _hull(arb(0), x.abs_upper())


def _down(x: arb) -> float:
    below = math.nextafter(math.nextafter(float(x.lower()), -math.inf), -math.inf)
    return (math.floor(below * GRID) - 1.0) / GRID


def _up(x: arb) -> float:
    above = math.nextafter(math.nextafter(float(x.upper()), math.inf), math.inf)
    return (math.ceil(above * GRID) + 1.0) / GRID


class Kernel:
    """Enclosures of I and J for one exponent n.

    Parameters
    ----------
    n : arb
        Exponent in (0, 1).

    Examples
    --------
    >>> kernel = Kernel(exact("9/11"))
    >>> bool(kernel.j(arb(-1), arb(1)) > 0), bool(kernel.i(arb(-1), arb(1)) > 0)
    (True, True)
    """

    def __init__(self, n: arb) -> None:
        self._n = n
        self._known: dict[tuple[float, float, int], arb] = {}

    def j(self, a: arb, y: arb) -> arb:
        """Enclose J(a, y)."""
        low = self._value(_up(a), _down(y), 1)
        return _hull(low, self._value(_down(a), _up(y), 1))

    def i(self, a: arb, y: arb) -> arb:
        """Enclose I(a, y), which is not negative."""
        a_low, a_high, y_low, y_high = _down(a), _up(a), _down(y), _up(y)
        one, two = self._value(a_high, y_low, 2), self._value(a_low, y_high, 2)
        if y_low >= a_high or y_high <= a_low:
            return _hull(one, two)
        return _hull(arb(0), _hull(one, two).abs_upper())

    def _value(self, a: float, y: float, kind: int) -> arb:
        """J (kind 1) or I (kind 2) at exact ends; I as the integral of a signed power is even."""
        key = (a, y, kind)
        if key not in self._known:
            length = arb(y) - arb(a)
            value = arb(0)
            if y != a:
                value = self._n * self._mean(kind - self._n, arb(a) / length) * length**kind
            self._known[key] = value
        return self._known[key]

    def _mean(self, mu: arb, rho: arb) -> arb:
        """∫_0^1 t^mu |rho + t|^(n−1) dt, in closed form by 2F1."""
        n = self._n
        if rho > 0:
            series = (-1 / rho).hypgeom_2f1(1 - n, mu + 1, mu + 2, ab=True)
            return rho ** (n - 1) / (mu + 1) * series
        r = -rho
        if r >= 1:
            return r ** (n - 1) / (mu + 1) * (1 / r).hypgeom_2f1(1 - n, mu + 1, mu + 2)
        if r.is_zero():
            return 1 / (mu + n)
        beta = (mu + 1).gamma() * n.gamma() / (mu + 1 + n).gamma()
        rest = (1 - r).hypgeom_2f1(-mu, 1, n + 1, abc=True)
        return r ** (mu + n) * beta + (1 - r) ** n / n * rest


class Step2:
    """Enclosures of V and V̇ of Step 2 on boxes of (y1, ξ1/L1, ξ2/(L1 L2)).

    Parameters
    ----------
    q : str
        q1 as a ratio.
    l : sequence of 3 floats
        Gains.
    k : sequence of 2 floats
        Weights k1, k2.
    w : float or None
        Weight of V1 = w·y1²/2; None for V1 = y1²/(2·b1).

    Examples
    --------
    >>> loop = Step2("9/11", (2.0, 4.2, 21.0), (4.28, 311.0), None)
    >>> value, rate = loop.value_and_rate((arb(1), arb("0.3"), arb("-0.2")), arb("0.5"), arb(1))
    >>> round(float(value.mid()), 4), round(float(rate.mid()), 4)
    (1.0489, -2.8863)
    """

    def __init__(self, q: str, l: Any, k: Any, w: float | None) -> None:  # noqa: E741
        self.q = exact(q)
        self.e = 2 * self.q - 1
        l1, l2, self._l3 = (exact(gain) for gain in l)
        self._k1, self._k2 = (exact(weight) for weight in k)
        self._w = None if w is None else exact(w)
        self.L1, self.L2 = l1 ** (1 / self.q), l2 ** (1 / self.e)
        self._one, self._two = Kernel(self.q), Kernel(self.e)

    def value(self, y1: arb, y2: arb, y3: arb, b1: arb) -> arb:
        """Enclose V at linearising coordinates."""
        xi1 = y2 + self.L1 * y1
        first = y1 * y1 / (2 * b1) if self._w is None else self._w * y1 * y1 / 2
        one, two = self._one.i(-self.L1 * y1, y2), self._two.i(-self.L2 * xi1, y3)
        return first + one / self._k1 + two / self._k2

    def value_and_rate(self, z: Box, b1: arb, b2: arb) -> tuple[arb, arb]:
        """Enclose V and V̇ on a box of (y1, ξ1/L1, ξ2/(L1 L2))."""
        q, L1, L2 = self.q, self.L1, self.L2
        y1, xi1, xi2 = z[0], z[1] * L1, z[2] * L1 * L2
        y2, y3 = xi1 - L1 * y1, xi2 - L2 * xi1
        x2, u1 = power(y2, q), power(y3, self.e)
        j1, j2 = self._one.j(-L1 * y1, y2), self._two.j(-L2 * xi1, y3)
        first = y1 * x2 if self._w is None else self._w * b1 * y1 * x2
        second = power(xi1, 2 - q) * b2 * u1 + b1 * (2 - q) * L1 * j1 * x2
        drift = power(_size(y2), 1 - q) * b2 * u1 / q + b1 * L1 * x2
        third = (3 - 2 * q) * L2 * j2 * drift - self._l3 * power(_size(xi2), 1 + q)
        rate = first + second / self._k1 + third / self._k2
        return self.value(y1, y2, y3, b1), rate


def faces(parts: int = 8) -> Iterator[tuple[int, tuple[float, float], tuple[float, float]]]:
    """Cover the three faces z_i = 1 of the cube by squares; the others follow by odd symmetry.

    Parameters
    ----------
    parts : int
        Squares along an edge, a power of 2.

    Yields
    ------
    tuple
        Number of the face, and the ranges of the other two coordinates.

    Examples
    --------
    >>> len(list(faces(2)))
    12
    """
    edges = [(-1 + 2 * i / parts, -1 + 2 * (i + 1) / parts) for i in range(parts)]
    for face in range(3):
        for one, two in itertools.product(edges, edges):
            yield face, one, two


def prove_rate(loop: Step2, rate: arb, b1: arb, b2: arb, *, max_boxes: int = MAX_BOXES) -> int:
    """Prove V̇ + rate·V^((1+q)/2) < 0 on the surface, for one pair of gains, by bisection.

    Parameters
    ----------
    loop : Step2
        V and V̇.
    rate : arb
        c.
    b1, b2 : arb
        Gains.
    max_boxes : int
        Boxes after which to give up.

    Returns
    -------
    int
        Number of boxes looked at; 0 if it was not proved.

    Examples
    --------
    >>> loop = Step2("9/11", (2.0, 4.2, 21.0), (4.28, 311.0), None)
    >>> prove_rate(loop, arb("0.5"), arb("0.5"), arb(1)) > 0
    True
    """
    exponent = (1 + loop.q) / 2
    todo, looked = list(faces()), 0
    while todo:
        face, (a, b), (c, d) = todo.pop()
        looked += 1
        if looked > max_boxes or b - a < SMALLEST_BOX:
            return 0
        sides = [arb((a + b) / 2, (b - a) / 2), arb((c + d) / 2, (d - c) / 2)]
        sides.insert(face, arb(1))
        value, slope = loop.value_and_rate((sides[0], sides[1], sides[2]), b1, b2)
        if slope + rate * _point_power(value.upper(), exponent) < 0:
            continue
        if b - a >= d - c:
            middle = (a + b) / 2
            todo += [(face, (a, middle), (c, d)), (face, (middle, b), (c, d))]
        else:
            middle = (c + d) / 2
            todo += [(face, (a, b), (c, middle)), (face, (a, b), (middle, d))]
    return looked


def prove_time(loop: Step2, rate: arb, b1: arb, start: Any, seconds: arb) -> bool:
    """Prove that Lemma 1's bound stays within a time, for all starts of a box.

    Parameters
    ----------
    loop : Step2
        V.
    rate : arb
        A proved c.
    b1 : arb
        Gain.
    start : sequence of 3 pairs
        Ranges of x1, x2, u1.
    seconds : arb
        The time.

    Returns
    -------
    bool
        Whether it is proved.

    Examples
    --------
    >>> loop = Step2("9/11", (2.0, 4.2, 21.0), (4.28, 311.0), None)
    >>> point = [[1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]
    >>> prove_time(loop, arb("1.2"), arb("0.5"), point, arb(10))
    True
    """
    q = loop.q
    todo = [tuple((float(low), float(high)) for low, high in start)]
    for _ in range(200_000):
        if not todo:
            return True
        box = todo.pop()
        x1, x2, u1 = (arb((low + high) / 2, (high - low) / 2) for low, high in box)
        value = loop.value(x1, power(x2, 1 / q), power(u1, 1 / loop.e), b1)
        if 2 * _point_power(value.upper(), (1 - q) / 2) / (rate * (1 - q)) <= seconds:
            continue
        widest = max(range(3), key=lambda i: box[i][1] - box[i][0])
        low, high = box[widest]
        if high - low < SMALLEST_BOX:
            return False
        middle = (low + high) / 2
        todo += [
            (*box[:widest], part, *box[widest + 1 :]) for part in ((low, middle), (middle, high))
        ]
    return False


def read(text: str) -> dict[str, Any]:
    """Read a certificate and check its schema and digest.

    Parameters
    ----------
    text : str
        JSON.

    Returns
    -------
    dict
        The certificate.

    Raises
    ------
    NotACertificateError
        If it cannot be read, is of another schema, or its digest is wrong.

    Examples
    --------
    >>> read("{}")
    Traceback (most recent call last):
    ...
    parkproof.proof.verify.NotACertificateError: not a parkproof-certificate-1 ...
    """
    try:
        certificate = json.loads(text)
    except ValueError as error:
        raise NotACertificateError(f"not JSON: {error}") from error
    if not isinstance(certificate, dict) or certificate.get("schema") != SCHEMA:
        raise NotACertificateError(f"not a {SCHEMA} (its key schema says otherwise)")
    if certificate.get("digest") != digest_of(certificate):
        raise NotACertificateError("the digest is wrong: the file was changed or cut short")
    return certificate


def prove(certificate: dict[str, Any]) -> bool:
    """Re-prove all that a certificate claims.

    Parameters
    ----------
    certificate : dict
        From `read`.

    Returns
    -------
    bool
        Whether every claim was proved.

    Raises
    ------
    NotACertificateError
        If a number is missing or of the wrong kind.

    Examples
    --------
    >>> prove({"schema": SCHEMA})
    Traceback (most recent call last):
    ...
    parkproof.proof.verify.NotACertificateError: 'law' ...
    """
    ctx.prec = PRECISION
    try:
        law, lyapunov = certificate["law"], certificate["lyapunov"]
        claim, given = certificate["claim"], certificate["assumptions"]
        loop = Step2(law["q1"], law["l"], lyapunov["k"], lyapunov["w"])
        rate, seconds = exact(claim["rate"]), exact(claim["step2_time"])
        gains = [[exact(end) for end in sorted(set(given[name]))] for name in ("b1", "b2")]
        start = given["start"]
        positive = [*law["l"], *lyapunov["k"], *given["b1"], *given["b2"], claim["rate"]]
        sound = (
            all(math.isfinite(number) and number > 0 for number in positive)
            and (lyapunov["w"] is None or lyapunov["w"] > 0)
            and Fraction(2, 3) < Fraction(law["q1"]) < 1
            and (given["b1_varies"] is False or lyapunov["w"] is not None)
            and set(claim) == {"rate", "step2_time"}
            and math.isfinite(claim["step2_time"])
            and [len(pair) for pair in start] == [2, 2, 2]
            and all(math.isfinite(low) and low <= high for low, high in start)
        )
    except (KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError) as error:
        raise NotACertificateError(f"{error} is missing or not of its kind") from error
    if not sound:
        return False
    try:
        return all(
            prove_rate(loop, rate, b1, b2) and prove_time(loop, rate, b1, start, seconds)
            for b1, b2 in itertools.product(*gains)
        )
    except (ValueError, OverflowError):  # a ball that is no number: nothing is proved of it
        return False


def statement_of(certificate: dict[str, Any]) -> list[str]:
    """Say what a certificate claims, from its numbers alone.

    Parameters
    ----------
    certificate : dict
        From `read`.

    Returns
    -------
    list of str
        Sentences.

    Examples
    --------
    >>> claim = {"rate": 1.2, "step2_time": 9.8}
    >>> given = {"b1": [0.5, 1.5], "b1_varies": False, "b2": [1.0, 1.0],
    ...          "start": [[-1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]}
    >>> law = {"q1": "9/11", "l": [2.0, 4.2, 21.0]}
    >>> print(statement_of({"claim": claim, "assumptions": given, "law": law})[-2])
    the state is 0 within 9.8 s, and stays 0.
    """
    claim, given, law = certificate["claim"], certificate["assumptions"], certificate["law"]
    ranges = ", ".join(
        f"{name} in [{low!r}, {high!r}]"
        for name, (low, high) in zip(("x1", "x2", "u1"), given["start"], strict=True)
    )
    kind = "varying in time at will" if given["b1_varies"] else "constant and unknown"
    return [
        f"Consider x1' = b1 x2, x2' = b2 u1, u1' = gamma tau2 + phi, with b1 in {given['b1']}, "
        f"{kind}, and b2 in {given['b2']}, varying at will,",
        "under tau2 = (tau + phi_max sign tau)/gamma_min with Step 2's tau = -l3 [xi2]^(3 q1 - 2), "
        f"q1 = {law['q1']}, l = {law['l']},",
        "for every measurable gamma >= gamma_min > 0 and |phi| <= phi_max.",
        f"Then V' <= -c V^((1+q1)/2) with c = {claim['rate']!r} at every state, and from every "
        f"start with {ranges}",
        f"the state is 0 within {claim['step2_time']!r} s, and stays 0.",
        "This speaks of continuous time and of Step 2 alone: not of the run-up, the return, the "
        "size of the inputs, or sampled control.",
    ]
