"""The primitives that every law and model is written in, and the mark for functions that compile.

A function marked with `scalar` is plain Python over floats: called from Python it runs as it is.
The ensemble engine hands all marked functions to the compiler when lanes are first needed, and
then replaces the primitives below by inlined polynomials; there is no second copy of any law.
Marking costs nothing at import.
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

MARKED: list[Callable[..., Any]] = []
"""Every function marked with `scalar`, in order of definition (callees before callers)."""


def scalar(function: Function) -> Function:
    """Mark a pure function of floats as a source for compiled lanes, and return it unchanged.

    Such a function takes and returns floats (or tuples of floats), uses only other marked
    functions, the primitives of this module, ``abs``, ``min``, ``max``, ``math.sqrt`` and
    ``math.copysign``, and chooses with conditional expressions.

    Parameters
    ----------
    function : callable
        The function to mark.

    Returns
    -------
    callable
        The same function.

    Examples
    --------
    >>> from parkproof.scalar import scalar, spow
    >>> @scalar
    ... def square_root_law(x: float) -> float:
    ...     return -spow(x, 0.5)
    >>> square_root_law(4.0)
    -2.0
    """
    MARKED.append(function)
    return function


def spow(x: float, p: float) -> float:
    """Signed power ⌈x⌋^p = sign(x)·|x|^p (the paper's notation; equals x^p for odd/odd p).

    Parameters
    ----------
    x : float
        Base, any real number.
    p : float
        Exponent, p > 0.

    Returns
    -------
    float
        ⌈x⌋^p, with ⌈0⌋^p = 0.

    Examples
    --------
    >>> from parkproof.scalar import spow
    >>> spow(-8.0, 1 / 3)
    -2.0
    """
    return math.copysign(abs(x) ** p, x)


def spow_begun(x: float, p: float) -> float:
    """First half of `spow`; what it is matters to `spow_ended` alone.

    A loop over lanes goes through a whole power slowly, as a processor sees too few lanes ahead
    while it waits for each power. So lanes go through two loops, over halves of it.

    Parameters
    ----------
    x : float
        Base, any real number.
    p : float
        Exponent, p > 0.

    Returns
    -------
    float
        |x|^p, in compiled lanes its logarithm.

    Examples
    --------
    >>> from parkproof.scalar import spow_begun, spow_ended
    >>> spow_ended(spow_begun(-8.0, 1 / 3), -8.0, 1 / 3)
    -2.0
    """
    size: float = abs(x) ** p
    return size


def spows_begun(x1: float, p1: float, x2: float, p2: float) -> tuple[float, float]:
    """First halves of two powers at once; compiled lanes share one division between them.

    Parameters
    ----------
    x1, p1, x2, p2 : float
        Base and exponent of either.

    Returns
    -------
    tuple of 2 floats
        `spow_begun` of each; in compiled lanes they may be rounded otherwise.

    Examples
    --------
    >>> from parkproof.scalar import spows_begun
    >>> spows_begun(9.0, 0.5, -8.0, 1.0)
    (3.0, 8.0)
    """
    return spow_begun(x1, p1), spow_begun(x2, p2)


def spow_ended(begun: float, x: float, p: float) -> float:  # noqa: ARG001  # compiled lanes ask
    """Second half of `spow`.

    Parameters
    ----------
    begun : float
        `spow_begun` of the same base and exponent, or what `spows_begun` gives for them.
    x : float
        Base.
    p : float
        Exponent.

    Returns
    -------
    float
        ⌈x⌋^p, as from `spow`.

    Examples
    --------
    >>> from parkproof.scalar import spow_begun, spow_ended
    >>> spow_ended(spow_begun(9.0, 0.5), 9.0, 0.5)
    3.0
    """
    return math.copysign(begun, x)


def sine(x: float) -> float:
    """Sine of an angle in radians.

    Parameters
    ----------
    x : float
        Angle in rad.

    Returns
    -------
    float
        sin x.

    Examples
    --------
    >>> from parkproof.scalar import sine
    >>> sine(0.0)
    0.0
    """
    return math.sin(x)


def tangent(x: float) -> float:
    """Tangent of an angle in radians.

    Parameters
    ----------
    x : float
        Angle in rad.

    Returns
    -------
    float
        tan x.

    Examples
    --------
    >>> from parkproof.scalar import tangent
    >>> round(tangent(0.25 * math.pi), 4)
    1.0
    """
    return math.tan(x)


@scalar
def arctan(x: float) -> float:
    """Angle in (−π/2, π/2) whose tangent is given.

    Parameters
    ----------
    x : float
        A tangent.

    Returns
    -------
    float
        arctan x in rad.

    Examples
    --------
    >>> from parkproof.scalar import arctan
    >>> round(arctan(1.0), 4)
    0.7854
    """
    return math.atan(x)


@scalar
def cosine(x: float) -> float:
    """Cosine of an angle in radians, as a shifted sine.

    Parameters
    ----------
    x : float
        Angle in rad.

    Returns
    -------
    float
        cos x.

    Examples
    --------
    >>> from parkproof.scalar import cosine
    >>> cosine(0.0)
    1.0
    """
    return sine(x + 0.5 * math.pi)


@scalar
def rotated(s: float, c: float, turn_s: float, turn_c: float) -> tuple[float, float]:
    """Sine and cosine of the sum of two angles.

    Parameters
    ----------
    s, c : float
        Sine and cosine of the one.
    turn_s, turn_c : float
        Sine and cosine of the other.

    Returns
    -------
    tuple of 2 floats
        Sine and cosine of their sum.

    Examples
    --------
    >>> from parkproof.scalar import rotated
    >>> rotated(0.0, 1.0, 1.0, 0.0)
    (1.0, 0.0)
    """
    return s * turn_c + c * turn_s, c * turn_c - s * turn_s


@scalar
def sign(x: float) -> float:
    """Sign of a number, with sign(0) = 0: one selection of the set-valued sign.

    Parameters
    ----------
    x : float
        Any number.

    Returns
    -------
    float
        -1.0, 0.0 or 1.0.

    Examples
    --------
    >>> from parkproof.scalar import sign
    >>> sign(-3.0), sign(0.0)
    (-1.0, 0.0)
    """
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@scalar
def clip(x: float, bound: float) -> float:
    """Nearest number in [−bound, bound].

    Parameters
    ----------
    x : float
        Any number.
    bound : float
        Half width of the interval, not negative.

    Returns
    -------
    float
        x, or the end of the interval beyond which it lies.

    Examples
    --------
    >>> from parkproof.scalar import clip
    >>> clip(-3.0, 2.0)
    -2.0
    """
    return max(-bound, min(bound, x))
