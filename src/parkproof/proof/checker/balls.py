"""Ball arithmetic with what Arb leaves open: monotone powers at 0, and searches over boxes.

A ball encloses a number; a box is a tuple of balls. Every function here rounds outwards.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

from flint import arb, fmpq

MAX_BOXES = 600_000
"""Boxes after which a proof is given up; a rate shares them among the ends of its gains."""

SMALLEST = 2.0**-20
"""Length of an edge below which a proof is given up."""

Range = tuple[float, float]


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


def point_power(x: arb, p: arb) -> arb:
    """⌈x⌋^p of an exact number.

    Parameters
    ----------
    x : arb
        A ball without radius.
    p : arb
        A positive exponent.

    Returns
    -------
    arb
        An enclosure.

    Raises
    ------
    ValueError
        If the sign of the number is not known.

    Examples
    --------
    >>> point_power(arb(0), arb(1) / 3) == 0
    True
    """
    if x > 0:
        return x**p
    if x < 0:
        return -((-x) ** p)
    if not x.is_zero():
        raise ValueError("a power of a ball that holds 0 and more")
    return arb(0)


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
    return point_power(x.lower(), p).union(point_power(x.upper(), p))


def size(x: arb) -> arb:
    """Enclose |x|.

    Parameters
    ----------
    x : arb
        A ball.

    Returns
    -------
    arb
        A ball of numbers that are not negative, but for rounding.

    Examples
    --------
    >>> bool(size(arb(0, 2)) < 3), size(arb(-2)) == 2
    (True, True)
    """
    low, high = x.lower(), x.upper()
    if low >= 0:
        return x
    return -x if high <= 0 else arb(0).union(x.abs_upper())


def largest(*numbers: arb) -> arb:
    """An upper bound of all of some numbers.

    Parameters
    ----------
    *numbers : arb
        Balls.

    Returns
    -------
    arb
        The largest upper end.

    Raises
    ------
    ValueError
        If a ball is not finite: of what is no number, nothing is an upper bound.

    Examples
    --------
    >>> largest(arb(1), arb(3), arb(2)) == 3
    True
    """
    if not all(number.is_finite() for number in numbers):
        raise ValueError("a ball that is not finite")
    top = numbers[0].upper()
    for number in numbers[1:]:
        if not number.upper() <= top:
            top = number.upper()
    return top


def least(*numbers: arb) -> arb:
    """A lower bound of all of some numbers.

    Parameters
    ----------
    *numbers : arb
        Balls.

    Returns
    -------
    arb
        The least lower end.

    Examples
    --------
    >>> least(arb(1), arb(3), arb(2)) == 1
    True
    """
    return -largest(*(-number for number in numbers))


def ball(low: float, high: float) -> arb:
    """The ball between two exact ends.

    Parameters
    ----------
    low, high : float
        Ends, low ≤ high.

    Returns
    -------
    arb
        A ball that contains both.

    Examples
    --------
    >>> ball(0.0, 0.5).contains(0.5)
    True
    """
    return arb(low).union(arb(high))


def down(x: arb) -> float:
    """A float that no number of a ball is below.

    Parameters
    ----------
    x : arb
        A ball.

    Returns
    -------
    float
        The float; the ball itself if that is a float.

    Examples
    --------
    >>> down(arb(1)), down(arb("0.1")) <= 0.1
    (1.0, True)
    """
    low = x.lower()
    near = float(low)
    return near if arb(near) <= low else math.nextafter(near, -math.inf)


def up(x: arb) -> float:
    """A float that no number of a ball is above.

    Parameters
    ----------
    x : arb
        A ball.

    Returns
    -------
    float
        The float; the ball itself if that is a float.

    Examples
    --------
    >>> up(arb(1)), up(arb("0.1")) >= 0.1
    (1.0, True)
    """
    return -down(-x)


def faces(dimension: int, parts: int = 8) -> Iterator[tuple[int, tuple[Range, ...]]]:
    """Cover the faces z_i = 1 of a cube by smaller ones; the others follow by odd symmetry.

    Parameters
    ----------
    dimension : int
        Of the space.
    parts : int
        Pieces along an edge, a power of 2.

    Yields
    ------
    tuple
        Number of the face, and the ranges of the other coordinates.

    Examples
    --------
    >>> len(list(faces(3, 2))), len(list(faces(2, 2)))
    (12, 4)
    """
    edges = [(-1 + 2 * i / parts, -1 + 2 * (i + 1) / parts) for i in range(parts)]
    for face in range(dimension):
        for sides in itertools.product(edges, repeat=dimension - 1):
            yield face, sides


def prove_on_surface(
    dimension: int, holds: Callable[[tuple[arb, ...]], bool], *, budget: int = MAX_BOXES
) -> int:
    """Prove a statement at every point of the surface max |z_i| = 1, by bisection.

    Parameters
    ----------
    dimension : int
        Of the space.
    holds : callable
        Whether the statement is shown for all points of a box; it must be odd or even in z.
    budget : int
        Boxes after which to give up.

    Returns
    -------
    int
        Number of boxes looked at; 0 if it was not proved.

    Examples
    --------
    >>> prove_on_surface(2, lambda z: bool(z[0] * z[0] + z[1] * z[1] > 0.9)) > 0
    True
    """
    todo, looked = list(faces(dimension)), 0
    while todo:
        face, sides = todo.pop()
        looked += 1
        lengths = [high - low for low, high in sides]
        if looked > budget or max(lengths) < SMALLEST:
            return 0
        z = [ball(low, high) for low, high in sides]
        z.insert(face, arb(1))
        if not holds(tuple(z)):
            todo += [(face, part) for part in halves(sides, lengths.index(max(lengths)))]
    return looked


def halves(sides: Sequence[Range], i: int) -> list[tuple[Range, ...]]:
    """Cut a box in two.

    Parameters
    ----------
    sides : sequence of pairs
        Ranges of the coordinates.
    i : int
        Which range is cut at its middle.

    Returns
    -------
    list of 2 tuples
        The halves.

    Examples
    --------
    >>> halves([(0.0, 1.0)], 0)
    [((0.0, 0.5),), ((0.5, 1.0),)]
    """
    low, high = sides[i]
    middle = (low + high) / 2
    return [(*sides[:i], part, *sides[i + 1 :]) for part in ((low, middle), (middle, high))]


def upper_bound(
    value: Callable[[tuple[arb, ...]], arb], box: Sequence[Range], *, slack: float = 1e-3
) -> arb:
    """A proven upper bound of a function over a box, nearly the least.

    Parameters
    ----------
    value : callable
        Encloses the function on a box.
    box : sequence of pairs
        Ranges of the coordinates.
    slack : float
        By how much of the largest corner the bound may exceed it.

    Returns
    -------
    arb
        The bound, without radius.

    Raises
    ------
    ValueError
        If it takes too many boxes, or the function is not bounded on them.

    Examples
    --------
    >>> bool(upper_bound(lambda z: z[0] * z[1], [(0.0, 2.0), (-1.0, 3.0)]) < 6.01)
    True
    """
    corners = itertools.product(*((low, high) for low, high in box))
    top = largest(*(value(tuple(arb(x) for x in corner)) for corner in corners))
    bound = ((1 + arb(slack)) * top + arb(1e-300)).upper()
    for _ in range(40):  # the largest value may lie elsewhere than at a corner: raise the bound
        todo, looked = [tuple(box)], 0
        while todo and looked < 3000:
            sides = todo.pop()
            looked += 1
            if not value(tuple(ball(low, high) for low, high in sides)) <= bound:
                lengths = [
                    (high - low) / (b - a or 1.0)
                    for (low, high), (a, b) in zip(sides, box, strict=True)
                ]
                todo += halves(sides, lengths.index(max(lengths)))
        if not todo:
            return bound
        bound = (bound * (1 + arb(5 * slack))).upper()
    raise ValueError("no bound was found on a box")
