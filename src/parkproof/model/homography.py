"""Homographies: invertible projective maps of planes, with their Jacobian.

Every camera is one, for the plane in which the robot's tag moves.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.scalar import scalar
from parkproof.validate import finite

Nine = tuple[float, float, float, float, float, float, float, float, float]
"""A 3 × 3 matrix, row by row."""

_SINGULAR = 1e-13
"""A determinant below this share of the sum of its terms' sizes is rounding."""


@scalar
def project_point(
    h00: float,
    h01: float,
    h02: float,
    h10: float,
    h11: float,
    h12: float,
    h20: float,
    h21: float,
    h22: float,
    x: float,
    y: float,
) -> tuple[float, float, float]:
    """Image of a point under a homography.

    Parameters
    ----------
    h00, h01, h02, h10, h11, h12, h20, h21, h22 : float
        The homography, row by row.
    x, y : float
        The point.

    Returns
    -------
    tuple of float
        (X, Y, w): the image, and the point's homogeneous depth w3 = h20 x + h21 y + h22, positive
        in front of the camera.

    Examples
    --------
    >>> from parkproof.model.homography import project_point
    >>> project_point(2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.5, 1.0, 1.0, 2.0)
    (1.5, 2.0, 2.0)
    """
    w = h20 * x + h21 * y + h22
    return (h00 * x + h01 * y + h02) / w, (h10 * x + h11 * y + h12) / w, w


@scalar
def homography_jacobian(
    h00: float,
    h01: float,
    h02: float,
    h10: float,
    h11: float,
    h12: float,
    h20: float,
    h21: float,
    h22: float,
    x: float,
    y: float,
) -> tuple[float, float, float, float]:
    """Jacobian of a homography at a point: (first two rows − image ⊗ third row)/w3.

    Parameters
    ----------
    h00, h01, h02, h10, h11, h12, h20, h21, h22 : float
        The homography, row by row.
    x, y : float
        The point, not on the horizon (w3 ≠ 0).

    Returns
    -------
    tuple of float
        (∂X/∂x, ∂X/∂y, ∂Y/∂x, ∂Y/∂y).

    Examples
    --------
    >>> from parkproof.model.homography import homography_jacobian
    >>> homography_jacobian(2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.5, 1.0, 1.0, 2.0)
    (1.0, -0.375, 0.0, 0.5)
    """
    X, Y, w = project_point(h00, h01, h02, h10, h11, h12, h20, h21, h22, x, y)
    return (h00 - X * h20) / w, (h01 - X * h21) / w, (h10 - Y * h20) / w, (h11 - Y * h21) / w


def numbers(name: str, values: Sequence[float], count: int) -> tuple[float, ...]:
    """Return some finite numbers as a tuple, or refuse them by name.

    Parameters
    ----------
    name : str
        What they are called.
    values : sequence of floats
        The numbers.
    count : int
        How many there must be.

    Returns
    -------
    tuple of floats
        The numbers.

    Raises
    ------
    InputError
        If there are more or less, or one is not finite.

    Examples
    --------
    >>> numbers("position", [1, 2], 2)
    (1.0, 2.0)
    """
    if len(values) != count:
        raise InputError(
            f"{name} = {tuple(values)}: must be {count} numbers, not {len(values)}; "
            f"write {name} = ({', '.join(['...'] * count)})"
        )
    return tuple(finite(name, value) for value in values)


@dataclass(frozen=True, slots=True)
class Homography:
    """An invertible projective map of planes, (x, y) ↦ (X, Y).

    Parameters
    ----------
    entries : sequence of float, length 9
        The 3 × 3 matrix, row by row, with the sign that makes w3 > 0 in front of the camera.

    Raises
    ------
    InputError
        If the entries are not nine finite numbers or the matrix is singular.

    Examples
    --------
    >>> from parkproof.model.homography import Homography
    >>> camera = Homography((2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.5, 1.0))
    >>> camera.project(1.0, 2.0)
    (1.5, 2.0)
    >>> camera.inverse().project(1.5, 2.0)
    (1.0, 2.0)
    >>> Homography((1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: homography: the matrix is singular ...
    """

    entries: Nine

    def __post_init__(self) -> None:
        entries = numbers("homography", self.entries, 9)
        object.__setattr__(self, "entries", entries)
        if not abs(self.determinant) > _SINGULAR * sum(map(abs, self._terms())):
            raise InputError(
                f"homography: the matrix is singular (determinant {self.determinant:.3g}), it must "
                "map the floor to a plane; give one made from four points, no three on a line"
            )

    def _terms(self) -> tuple[float, ...]:
        """Return the six terms of the determinant."""
        a, b, c, d, e, f, g, h, i = self.entries
        return a * e * i, b * f * g, c * d * h, -c * e * g, -b * d * i, -a * f * h

    @property
    def determinant(self) -> float:
        """Determinant of the matrix; its sign is the image's handedness where w3 > 0."""
        return sum(self._terms())

    def project(self, x: float, y: float) -> tuple[float, float]:
        """Image of a point.

        Parameters
        ----------
        x, y : float
            A point in front of the camera, w3 > 0.

        Returns
        -------
        tuple of float
            (X, Y).

        Raises
        ------
        InputError
            If the point is not finite, or lies on the horizon or behind the camera.
        """
        x, y = finite("x", x), finite("y", y)
        depth = self.depth(x, y)
        if not depth > 0.0:
            raise InputError(
                f"point ({x:.6g}, {y:.6g}): lies behind the camera (w3 = {depth:.3g}), must lie in "
                "front (w3 > 0); choose a point in view, or turn the camera towards it"
            )
        X, Y, _ = project_point(*self.entries, x, y)
        return X, Y

    def depth(self, x: float, y: float) -> float:
        """Homogeneous depth w3 of a point: positive in front of the camera.

        Parameters
        ----------
        x, y : float
            The point.

        Returns
        -------
        float
            h20 x + h21 y + h22.
        """
        return self.entries[6] * x + self.entries[7] * y + self.entries[8]

    def inverse(self) -> "Homography":
        """Return the map from image to floor, with w3 > 0 where this one has it.

        Returns
        -------
        Homography
            The inverse matrix.
        """
        a, b, c, d, e, f, g, h, i = self.entries
        det = self.determinant
        return Homography(
            (
                (e * i - f * h) / det,
                (c * h - b * i) / det,
                (b * f - c * e) / det,
                (f * g - d * i) / det,
                (a * i - c * g) / det,
                (c * d - a * f) / det,
                (d * h - e * g) / det,
                (b * g - a * h) / det,
                (a * e - b * d) / det,
            )
        )

    def __matmul__(self, first: "Homography") -> "Homography":
        """Compose: ``(self @ first).project(x, y) == self.project(*first.project(x, y))``."""
        rows, m = self.entries, first.entries
        a, b, c, d, e, f, g, h, i = (
            sum(rows[3 * row + k] * m[3 * k + column] for k in range(3))
            for row in range(3)
            for column in range(3)
        )
        return Homography((a, b, c, d, e, f, g, h, i))
