"""Many states on the homogeneous sphere, and the terms of V and V̇ there.

At a state, V and V̇ are linear in the inverses of the weights. The integrals in them are therefore
found once for each state, and thousands of weights are then compared by sums alone.
"""

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from parkproof.proof.integrals import power_integrals, signed_power
from parkproof.proof.lyapunov import ChainLyapunov

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

Corner = tuple[float, ...]
"""Values of b_1 … b_{r−1}, the uncertain gains of a chain of r integrators."""

EDGE = {2: 201, 3: 25}
"""States along each edge of the cube at first, for a chain of 2 or 3."""

PARTS = 4
"""Parts of an edge, for the search for worse states."""

SUSPECTS = 24
"""States around which worse ones are sought."""

ZOOMS = 7
"""Finer grids around each of them."""


class ChainTerms:
    """Terms of V and V̇ at many states of ż_i = b_i·z_{i+1}, ż_r = τ̃ under the paper's law.

    V = V1 + Σ I_i/k_i, where V1 is z1²/2, or z1²/(2·b1) for a constant b1. With squares, V holds
    s_1·y_2²/2 and so on to s_{r−1}·ξ_{r−1}²/2, too: squares of y_2 … y_{r−1} and of ξ_{r−1}, of
    which the input is a power.

    Parameters
    ----------
    gains : sequence of r floats
        l_1 … l_r.
    q : float
        Exponent in ((r − 1)/r, 1).
    state : sequence of r arrays
        The states.
    squares : bool
        Whether V holds the squares.

    Examples
    --------
    >>> import numpy as np
    >>> terms = ChainTerms((2.0, 4.2, 21.0), 9 / 11, np.array([[1.0], [-2.0], [-2.0]]))
    >>> weights = np.array([1.0, 1 / 2.4, 1 / 1.75])
    >>> print((weights @ terms.rates((1.5, 1.0), constant=True)).round(1))
    [49.5]
    """

    def __init__(
        self, gains: Sequence[float], q: float, state: "Sequence[Array]", *, squares: bool = False
    ) -> None:
        self._q, self._last, self._z, self._squares = q, gains[-1], state, squares
        self._w = tuple(i * q - (i - 1) for i in range(1, len(gains)))
        self._L = tuple(gain ** (1.0 / w) for gain, w in zip(gains, self._w, strict=False))
        self._y, self._xi = [state[0]], [state[0]]
        self._integrals, self._slopes = [], []
        for w, L, z in zip(self._w, self._L, state[1:], strict=True):
            y = signed_power(z, 1.0 / w)
            integral, slope = power_integrals(-L * self._xi[-1], y, w)
            self._y.append(y)
            self._xi.append(y + L * self._xi[-1])
            self._integrals.append(integral)
            self._slopes.append((2.0 - w) * L * slope)

    def values(self, b1: float | None) -> "Array":
        """Give the terms of V: a row each, to be multiplied by 1, 1/k1, …, s1, … and summed.

        Parameters
        ----------
        b1 : float or None
            A constant b1; None for V1 = z1²/2.

        Returns
        -------
        array
            r rows; with squares 2r − 1.
        """
        import numpy as np

        first = 0.5 * self._y[0] ** 2 / (1.0 if b1 is None else b1)
        squares = [*self._y[1:-1], self._xi[-1]] if self._squares else []
        return np.array([first, *self._integrals, *(0.5 * y**2 for y in squares)])

    def coordinates(self) -> "Array":
        """Give y_1 … y_r and ξ_{r−1} at the states: a row each."""
        import numpy as np

        return np.array([*self._y, self._xi[-1]])

    def rates(self, b: Corner, *, constant: bool) -> "Array":
        """Give the terms of V̇, as those of V.

        Parameters
        ----------
        b : tuple of r − 1 floats
            The gains.
        constant : bool
            Whether b1 is constant, and so V1 = z1²/(2·b1).

        Returns
        -------
        array
            r rows; with squares 2r − 1.
        """
        import numpy as np

        speeds = [gain * z for gain, z in zip(b, self._z[1:], strict=True)]
        rows, xi_rate = [self._y[0] * (self._z[1] if constant else speeds[0])], speeds[0]
        squares = []
        for i, (w, L, y, xi) in enumerate(
            zip(self._w, self._L, self._y[1:], self._xi[1:], strict=True)
        ):
            row, stretch = self._slopes[i] * xi_rate, np.abs(y) ** (1.0 - w) / w
            if i + 1 < len(speeds):
                row = row + signed_power(xi, 2.0 - w) * speeds[i + 1]
                xi_rate = stretch * speeds[i + 1] + L * xi_rate
                squares.append(y * stretch * speeds[i + 1])
            else:
                row = row - self._last * np.abs(xi) ** (1.0 + self._q)
                falls = self._last * np.abs(xi) ** (self._q + w)
                squares.append(xi * L * xi_rate - stretch * falls)
            rows.append(row)
        if self._squares:
            rows += squares
        return np.array(rows)


class SampledSphere:
    """States of the faces of the cube max_i |ξ_i|/(L_1…L_i) = 1, half of them by odd symmetry.

    Parameters
    ----------
    chain : ChainLyapunov
        The law and the form of V; its weights are not used.
    corners : list of tuples
        Values of the uncertain gains.
    squares : bool
        Whether V holds squares, too.

    Attributes
    ----------
    cube : array
        Coordinates of the states: a column each.
    values, rates : array
        Terms of V and V̇: corners × terms × states.

    Examples
    --------
    >>> import numpy as np
    >>> sphere = SampledSphere(ChainLyapunov(gains=(1.5, 6.5), q=7 / 9, k=(1.0,)), [(0.5,), (1.5,)])
    >>> sphere.rates.shape
    (2, 2, 402)
    >>> before, after = sphere.add_worse(np.array([1.0, 1 / 2.6]))
    >>> before <= after < 0.0
    True
    """

    def __init__(
        self, chain: ChainLyapunov, corners: list[Corner], *, squares: bool = False
    ) -> None:
        import numpy as np

        self.chain, self.corners, self._r = chain, corners, len(chain.gains)
        self._squares = squares
        edge = np.linspace(-1.0, 1.0, EDGE[self._r])
        self._spacing = float(edge[1] - edge[0])
        free = np.array(list(itertools.product(edge, repeat=self._r - 1))).T
        faces = [np.insert(free, face, 1.0, axis=0) for face in range(self._r)]
        self.cube = np.concatenate(faces, axis=1)
        self._face = np.repeat(np.arange(self._r), free.shape[1])
        self.values, self.rates = self._sample(self.cube)

    def terms(self, state: "Sequence[Array]") -> "tuple[Array, Array]":
        """Give the terms of V and V̇ at some states, in every corner.

        Parameters
        ----------
        state : sequence of r arrays
            The states.

        Returns
        -------
        tuple of 2 arrays
            Corners × terms × states.
        """
        import numpy as np

        constant = self.chain.constant_alpha
        terms = ChainTerms(self.chain.gains, self.chain.q, state, squares=self._squares)
        return (
            np.array([terms.values(b[0] if constant else None) for b in self.corners]),
            np.array([terms.rates(b, constant=constant) for b in self.corners]),
        )

    def worst(self, weights: "Array") -> float:
        """Give the largest V̇/V^((1+q)/2) over the corners and states.

        Parameters
        ----------
        weights : array
            1, 1/k1, …, s1, ….

        Returns
        -------
        float
            The ratio.
        """
        return float(self._ratios(weights, self.values, self.rates).max())

    def sizes(self, weights: "Array") -> "Array":
        """Give the largest y_i²/V and ξ²/V over the corners and states.

        Parameters
        ----------
        weights : array
            1, 1/k1, …, s1, ….

        Returns
        -------
        array
            One for each coordinate, and one for ξ.
        """
        terms = ChainTerms(self.chain.gains, self.chain.q, self.chain.state_at(*self.cube))
        values = (weights @ self.values).min(axis=0)
        largest: Array = (terms.coordinates() ** 2 / values).max(axis=1)
        return largest

    def add_worse(self, weights: "Array") -> tuple[float, float]:
        """Zoom in on the worst states of parts of the faces, and add what is met.

        Parameters
        ----------
        weights : array
            1, 1/k1, …, s1, ….

        Returns
        -------
        tuple of two floats
            The largest ratio before and after.
        """
        import numpy as np

        before = self._ratios(weights, self.values, self.rates)
        corner, at = self._suspects(before)
        centers, face = self.cube[:, at], self._face[at]
        fine = np.linspace(-1.0, 1.0, 7)
        offsets = np.array(list(itertools.product(fine, repeat=self._r - 1))).T
        around = np.array([np.insert(offsets, row, 0.0, axis=0) for row in face]).swapaxes(0, 1)
        each, met = np.arange(len(at)), []
        for zoom in range(ZOOMS):
            near = np.clip(centers[:, :, None] + self._spacing / 3.0**zoom * around, -1.0, 1.0)
            found = self._ratios(weights, *self._sample(near.reshape(self._r, -1)))
            own = found.reshape(len(self.corners), len(at), -1)[corner, each]
            centers = near[:, each, own.argmax(axis=1)]
            met.append(centers)
        cube = np.concatenate(met, axis=1)
        values, rates = self._sample(cube)
        self.cube = np.concatenate([self.cube, cube], axis=1)
        self._face = np.concatenate([self._face, np.tile(face, ZOOMS)])
        self.values = np.concatenate([self.values, values], axis=2)
        self.rates = np.concatenate([self.rates, rates], axis=2)
        return float(before.max()), self.worst(weights)

    def _suspects(self, ratios: "Array") -> "tuple[Any, Any]":
        """Corners and states of the largest ratios, one from each part of a face in each corner."""
        import numpy as np

        part = np.minimum(((self.cube + 1.0) * (PARTS / 2)).astype(int), PARTS - 1)
        number = np.ravel_multi_index((self._face, *part), (self._r, *[PARTS] * self._r))
        states = []
        for row in ratios:
            order = row.argsort()[::-1]
            states.append(order[np.unique(number[order], return_index=True)[1]])
        corner = np.repeat(np.arange(len(ratios)), [len(found) for found in states])
        at = np.concatenate(states)
        worst = ratios[corner, at].argsort()[::-1][:SUSPECTS]
        return corner[worst], at[worst]

    def _sample(self, cube: "Array") -> "tuple[Array, Array]":
        return self.terms(self.chain.state_at(*cube))

    def _ratios(self, weights: "Array", values: "Array", rates: "Array") -> "Array":
        ratios: Array = (weights @ rates) / (weights @ values) ** self.chain.exponent
        return ratios
