"""From the homography of a tag to the image pose of the robot: no PnP, no intrinsics.

The homography H takes the tag's frame (`parkproof.lab.tag_square`) to pixels. With m the middle of
the axle in the tag's frame, e the robot's forward direction there, and J the Jacobian of H at m:
(u, v) = H(m), ψ is the direction of J e, a = |J e| and β = det J/a²
(`parkproof.model.image_unicycle`). The tag's scale cancels in β and in ψ.
"""

import math
from typing import NamedTuple

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.tag import TAGS
from parkproof.lab.tag_square import SLACK, SQUARE, Near, near
from parkproof.model.homography import Homography, homography_jacobian, numbers
from parkproof.model.image_unicycle import image_direction
from parkproof.model.unicycle import wrap_angle
from parkproof.validate import finite, positive

FARTHEST = 20.0
"""Largest distance of axle and tag, in sides; beyond it the offset was surely given in another
unit."""


class TagMount(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the tag sits on the robot.

    Parameters
    ----------
    tag_id : int
        Which tag of the family 36h11, 0 to 586.
    offset : tuple of float
        The middle of the axle in the tag's frame (x to the right, y up on the tag as it is
        printed), in sides of the tag.
    angle : float
        Direction of the robot's forward in the tag's frame, in rad counter-clockwise from its x.
    side : float
        Side of the tag's black square in m. Turns speeds from sides into metres; the parking
        itself does not need it.

    Raises
    ------
    InputError
        If there is no such tag, a number is not finite, or the offset is beyond 20 sides.

    Examples
    --------
    >>> TagMount(tag_id=7).offset
    (0.0, 0.0)
    >>> TagMount(tag_id=600)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: tag_id = 600: ...
    """

    tag_id: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0
    side: float = 0.1

    def __post_init__(self) -> None:
        check_tag_id(self.tag_id)
        x, y = numbers("offset", self.offset, 2)
        if math.hypot(x, y) > FARTHEST:
            raise InputError(
                f"offset = ({x:g}, {y:g}): must be within {FARTHEST:g} sides of the tag, and is in "
                "these, not in pixels or centimetres; divide the distance by the tag's side"
            )
        force_setattr(self, "offset", (x, y))
        force_setattr(self, "angle", wrap_angle(finite("angle", self.angle)))
        force_setattr(self, "side", positive("side", self.side, example=0.1))


def check_tag_id(tag_id: int) -> int:
    """Return the id of a tag, or raise if there is no such tag.

    Parameters
    ----------
    tag_id : int
        Which tag.

    Returns
    -------
    int
        The same.

    Raises
    ------
    InputError
        If the family 36h11 has no such tag.

    Examples
    --------
    >>> check_tag_id(586)
    586
    """
    if isinstance(tag_id, bool) or not isinstance(tag_id, int) or not 0 <= tag_id < TAGS:
        raise InputError(
            f"tag_id = {tag_id}: must be an integer from 0 to {TAGS - 1}, the tags of the family "
            "36h11; write for example tag_id = 0"
        )
    return tag_id


class ImagePose(NamedTuple):
    """The robot as one picture shows it, in px, rad and sides of its tag.

    Attributes
    ----------
    u, v : float
        Image of the axle's middle, px.
    psi : float
        Image heading ψ in (−π, π]: direction of J e, from u towards v, so clockwise on the screen.
    beta : float
        Turn gain ψ̇/ω, negative where the picture is not that of a mirror.
    a : float
        Speed gain: px per side of the tag that the robot drives.
    side : float
        Mean length of the tag's sides, px.
    a_min, a_max : float
        Least and greatest a over all headings, here: the singular values of J.

    Examples
    --------
    >>> ImagePose(320.0, 240.0, 0.0, beta=-1.0, a=30.0, side=30.0, a_min=30.0, a_max=30.0).beta
    -1.0
    """

    u: float
    v: float
    psi: float
    beta: float
    a: float
    side: float
    a_min: float
    a_max: float


def image_pose(homography: Homography, mount: TagMount) -> ImagePose:
    """Image pose of the robot that carries a tag.

    Parameters
    ----------
    homography : Homography
        Tag's frame → px, as in `Detection.homography`.
    mount : TagMount
        How the tag sits on the robot.

    Returns
    -------
    ImagePose
        Of the middle of the axle.

    Raises
    ------
    InputError
        If the middle of the axle lies behind the camera.

    Examples
    --------
    >>> from parkproof.lab.tag_square import square_homography
    >>> shown = square_homography(((10.0, 50.0), (50.0, 50.0), (50.0, 10.0), (10.0, 10.0)))
    >>> pose = image_pose(shown, TagMount(offset=(-0.5, 0.0), angle=math.pi / 2))
    >>> pose.u, pose.v, round(pose.psi, 4), pose.beta, pose.a
    (10.0, 30.0, -1.5708, -1.0, 40.0)
    """
    x, y = mount.offset
    u, v = homography.project(x, y)
    jacobian = homography_jacobian(*homography.entries, x, y)
    c, s, a, beta = image_direction(*jacobian, math.cos(mount.angle), math.sin(mount.angle))
    j00, j01, j10, j11 = jacobian
    # Singular values: their sum and difference are these two lengths.
    total = math.hypot(j00 + j11, j10 - j01)
    rest = math.hypot(j00 - j11, j10 + j01)
    corners = [homography.project(i, j) for i, j in SQUARE]
    side = sum(math.dist(corners[k - 1], corners[k]) for k in range(4)) / 4.0
    return ImagePose(
        u,
        v,
        math.atan2(s, c),
        beta,
        a,
        side,
        a_min=0.5 * abs(total - rest),
        a_max=0.5 * (total + rest),
    )


def expected(pose: ImagePose, mount: TagMount, *, slack: float = SLACK) -> Near:
    """Where to look for the tag of a robot that is expected at an image pose.

    Parameters
    ----------
    pose : ImagePose
        Expected; its side and the sign of its beta may be those of an earlier frame.
    mount : TagMount
        How the tag sits on the robot.
    slack : float
        How wrong the expectation may be, px.

    Returns
    -------
    Near
        For `TagDetector.find`.

    Examples
    --------
    >>> pose = ImagePose(320.0, 240.0, 0.0, beta=-1.0, a=30.0, side=30.0, a_min=30.0, a_max=30.0)
    >>> expected(pose, TagMount(offset=(-1.0, 0.0)))
    Near(u=350.0, v=240.0, reach=68.5)
    """
    x, y = mount.offset
    # The tag's centre seen from the axle, along and across forward, as if the view were upright;
    # what tilt and unequal scales change in that is at most about half of it.
    c, s = math.cos(mount.angle), math.sin(mount.angle)
    ahead, left = -(c * x + s * y), s * x - c * y
    left = math.copysign(left, left * pose.beta)
    c, s = math.cos(pose.psi), math.sin(pose.psi)
    u = pose.u + pose.side * (c * ahead - s * left)
    v = pose.v + pose.side * (s * ahead + c * left)
    doubt = 0.5 * pose.side * math.hypot(x, y)
    return near((u, v), pose.side, slack=slack + doubt)
