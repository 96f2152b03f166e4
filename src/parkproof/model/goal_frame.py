"""The goal's image frame: where a robot shown to the camera defines origin, heading and unit.

And the bounds of the image unicycle's gains over what the camera sees.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.model.homography import Homography, homography_jacobian, project_point
from parkproof.model.image_unicycle import image_of
from parkproof.model.unicycle import Pose
from parkproof.validate import finite, positive


class GainBounds(NamedTuple):
    """Least and greatest gains of an image unicycle over a region and all headings.

    Parameters
    ----------
    a_min, a_max : float
        Bounds of a, image unit per m.
    beta_min, beta_max : float
        Bounds of β.

    Examples
    --------
    >>> from parkproof.model.goal_frame import GainBounds
    >>> GainBounds(0.5, 1.5, 1.0, 1.0).a_max
    1.5
    """

    a_min: float
    a_max: float
    beta_min: float
    beta_max: float


def goal_similarity(goal: Pose, unit: float, *, mirrored: bool) -> Homography:
    """Map from pixels to goal image coordinates, from the picture of the goal alone.

    They are centred at the goal's image p*, with the first axis along its image heading ψ*, in the
    given unit; in a mirrored image the second axis is flipped, so that β > 0 in them.

    Parameters
    ----------
    goal : Pose
        Image pose (p*, ψ*) of the robot when it is parked, px and rad.
    unit : float
        Unit of the new coordinates in px, for example the side of the robot's tag; positive.
    mirrored : bool
        Whether β < 0 in the picture, as when v points down and the camera looks down.

    Returns
    -------
    Homography
        Pixels → goal image coordinates, a similarity.

    Raises
    ------
    InputError
        If a number is not finite, or the unit not positive.

    Examples
    --------
    >>> from parkproof.model.goal_frame import goal_similarity
    >>> from parkproof.model.unicycle import Pose
    >>> goal_similarity(Pose(320.0, 240.0, 0.0), 40.0, mirrored=True).project(360.0, 260.0)
    (1.0, -0.5)
    """
    x, y, psi = (finite(name, value) for name, value in goal._asdict().items())
    unit = positive("unit", unit, example=40.0)
    c, s = math.cos(psi) / unit, math.sin(psi) / unit
    flip = -1.0 if mirrored else 1.0
    return Homography(
        (
            c,
            s,
            -(c * x + s * y),
            -flip * s,
            flip * c,
            flip * (s * x - c * y),
            0.0,
            0.0,
            1.0,
        )
    )


def goal_homography(camera: Homography, goal: Pose, unit: float) -> Homography:
    """Map from the floor to goal image coordinates (`goal_similarity`), in which β > 0.

    Parameters
    ----------
    camera : Homography
        Floor → pixels.
    goal : Pose
        Where the robot shall park, on the floor.
    unit : float
        Unit of the new coordinates in px, positive.

    Returns
    -------
    Homography
        Floor → goal image coordinates: the goal's image is the origin, with heading 0.

    Raises
    ------
    InputError
        If a number is not finite, the unit not positive, or the goal behind the camera.

    Examples
    --------
    >>> from parkproof.model.camera import PinholeCamera
    >>> from parkproof.model.goal_frame import goal_homography
    >>> from parkproof.model.image_unicycle import image_of
    >>> from parkproof.model.unicycle import Pose
    >>> camera = PinholeCamera(
    ...     position=(0.0, 0.0), height=3.0, focal_length=600.0, image_size=(641, 481)
    ... )
    >>> to_goal = goal_homography(camera.homography(), goal=Pose(0.0, 0.0, 0.0), unit=40.0)
    >>> to_goal.project(1.0, 0.5)
    (5.0, 2.5)
    >>> image_of(to_goal, Pose(1.0, 0.5, 0.0)).beta
    1.0
    """
    shown = image_of(camera, goal)
    return goal_similarity(shown.pose, unit, mirrored=shown.beta < 0.0) @ camera


def gain_bounds(
    homography: Homography, corners: Sequence[tuple[float, float]], samples: int = 64
) -> GainBounds:
    """Bounds of a and β over a polygon of the image and all headings: sampled along its border.

    Along a line through an image point in the direction of its heading, a and β are monotone, so
    their extremes lie on the border; there the positions are sampled, so the bounds can fall short
    by O(1/samples²). Over headings they are exact: a is between the singular values of J.

    Parameters
    ----------
    homography : Homography
        Floor → image.
    corners : sequence of tuple of float
        Corners of the polygon in image coordinates, in order; at least three.
    samples : int
        Positions on each edge, at least 1 (its ends are among them).

    Returns
    -------
    GainBounds
        (a_min, a_max, beta_min, beta_max).

    Raises
    ------
    InputError
        If there are fewer than three corners, one is not finite, a number of samples below 1, or
        the polygon reaches the horizon.

    Examples
    --------
    >>> from parkproof.model.camera import CeilingCamera
    >>> from parkproof.model.goal_frame import gain_bounds
    >>> view = ((0.0, 0.0), (640.0, 0.0), (640.0, 480.0), (0.0, 480.0))
    >>> gain_bounds(CeilingCamera(alpha=(200.0, 100.0)).homography(), view)
    GainBounds(a_min=100.0, a_max=200.0, beta_min=0.5, beta_max=2.0)
    """
    if len(corners) < 3 or samples < 1:
        raise InputError(
            f"corners, samples = {len(corners)}, {samples}: must be at least 3 corners and 1 "
            "sample an edge; write for example corners = camera.corners(), samples = 64"
        )
    to_floor = homography.inverse()
    for X, Y in corners:
        if not to_floor.depth(finite("X", X), finite("Y", Y)) > 0.0:
            raise InputError(
                f"corner ({X:.6g}, {Y:.6g}): lies on or above the horizon, where the floor has no "
                "image; keep the view below the horizon, or tilt the camera less"
            )
    a_min, a_max, ratio, handedness = math.inf, 0.0, 1.0, 1.0
    for (X0, Y0), (X1, Y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        for k in range(samples):
            t = k / samples
            x, y, _ = project_point(*to_floor.entries, X0 + t * (X1 - X0), Y0 + t * (Y1 - Y0))
            j00, j01, j10, j11 = homography_jacobian(*homography.entries, x, y)
            # Singular values of J: their sum and difference are these two lengths.
            greatest = 0.5 * (math.hypot(j00 + j11, j10 - j01) + math.hypot(j00 - j11, j10 + j01))
            det = j00 * j11 - j01 * j10
            least = abs(det) / greatest
            a_min, a_max = min(a_min, least), max(a_max, greatest)
            ratio = max(ratio, greatest / least)
            handedness = math.copysign(1.0, det)
    beta_min, beta_max = sorted((handedness * ratio, handedness / ratio))
    return GainBounds(a_min, a_max, beta_min, beta_max)
