"""The integrals of Lyapunov functions built by adding a power integrator."""

import functools
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_BLOCK = 4096
"""Points integrated at once, so that long trajectories need little memory."""


def signed_power(x: "Array", p: float) -> "Array":
    """Signed power ⌈x⌋^p of arrays.

    Parameters
    ----------
    x : array
        Bases.
    p : float
        Exponent, p > 0.

    Returns
    -------
    array
        ⌈x⌋^p.

    Examples
    --------
    >>> import numpy as np
    >>> print(signed_power(np.array([-8.0, 0.0]), 1 / 3))
    [-2.  0.]
    """
    import numpy as np

    return np.copysign(np.abs(x) ** p, x)


@functools.cache
def _nodes() -> "tuple[Array, Array, Array]":
    """Nodes t and 1 − t and weights of double-exponential quadrature on [0, 1].

    It converges as fast as ever when the integrand is not smooth at the ends.
    """
    import numpy as np

    step = 1.0 / 14.0
    u = step * np.arange(-45, 46)
    t, rest = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(u))), 1.0 / (1.0 + np.exp(np.pi * np.sinh(u)))
    return t, rest, step * np.pi * np.cosh(u) * t * rest


def power_integrals(start: "Array", end: "Array", n: float) -> "tuple[Array, Array]":
    """Integrate ⌈w − start⌋^(2−n) and |w − start|^(1−n) over s, from w = start to w = end.

    Here w = ⌈s⌋^(1/n). Both are homogeneous in (start, end), of degree 2 and 1. Their error is
    about 1e-14 of max(|start|, |end|) to that degree.

    Parameters
    ----------
    start, end : array
        Ends of the interval, in the coordinate w.
    n : float
        Exponent in (0, 1).

    Returns
    -------
    tuple of 2 arrays
        The two integrals; the first is never negative, the second has the sign of end − start.

    Examples
    --------
    From 0 both are closed: n·end²/2 and n·end.

    >>> import numpy as np
    >>> first, second = power_integrals(np.zeros(1), np.array([-3.0]), 0.5)
    >>> print(first.round(12), second.round(12))
    [2.25] [-1.5]
    """
    import numpy as np

    start, end = np.broadcast_arrays(start, end)
    shape, start, end = start.shape, start.ravel(), end.ravel()
    # |w| runs from that of the end nearer to 0, or from 0 itself, to that of the other end.
    across = start * end < 0.0
    from_start = np.abs(start) <= np.abs(end)
    far = np.where(across | from_start, end, start)
    near = np.where(across, 0.0, np.where(from_start, start, end))
    s_far, s_near = np.abs(far) ** n, np.abs(near) ** n
    origin = np.where(across, -1.0, 1.0) * np.abs(start)
    first, second = np.empty_like(start), np.empty_like(start)
    t, rest, weights = _nodes()
    for begin in range(0, start.size, _BLOCK):
        part = np.s_[begin : begin + _BLOCK]
        w = (s_near[part, None] * rest + s_far[part, None] * t) ** (1.0 / n)
        offset = np.abs(w - origin[part, None])
        power = weights * offset ** (1.0 - n)
        first[part], second[part] = (power * offset).sum(axis=1), power.sum(axis=1)
    # From start to 0, where they lie on opposite sides: Beta functions.
    size = np.where(across, np.abs(start), 0.0)
    first = (s_far - s_near) * first + n * size**2 * math.gamma(3.0 - n) * math.gamma(n) / 2.0
    second = (s_far - s_near) * second + n * size * math.gamma(2.0 - n) * math.gamma(n)
    return first.reshape(shape), np.copysign(second, end - start).reshape(shape)
