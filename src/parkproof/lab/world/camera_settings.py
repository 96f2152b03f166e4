"""The camera of a simulated world: where it hangs, its lens and sensor, when frames arrive."""

import math

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.settings import LONGEST, RATES
from parkproof.lab.world.lens import Lens
from parkproof.model.camera import PinholeCamera
from parkproof.model.homography import numbers
from parkproof.validate import finite, not_negative, positive, within


class CameraSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The true camera: where it hangs, its lens, its sensor, and when its frames arrive.

    Parameters
    ----------
    position : two floats
        Floor coordinates of the camera in m.
    height : float
        Its height over the floor in m.
    tilt_deg, roll_deg, pan_deg : float
        Angles in degrees (`parkproof.model.camera.PinholeCamera`); all 0 looks straight down.
    focal_length : float
        Focal length f_x in px.
    aspect : float
        Vertical over horizontal focal length, f_y/f_x.
    image_size : two ints
        Width and height of the picture in px.
    k1 : float
        Radial distortion, x_d = x (1 + k1 r²) in normalised coordinates, as in OpenCV.
    noise : float
        Standard deviation of the noise of each pixel in grey levels.
    blur : float
        Standard deviation of the blur in px.
    exposure : float
        Factor on the brightness; 1 shows white as nearly white.
    exposure_time : float
        Time in s over which the shutter is open: what moves meanwhile is blurred.
    rate : float
        Frames taken in a second.
    latency : float
        Time in s from the middle of the exposure until the frame arrives.
    drop : float
        Probability that a frame never arrives.
    colour : bool
        Whether frames are RGB; else they are grey.

    Raises
    ------
    InputError
        If a number is out of its range, the picture shows the horizon, or the distortion folds it.

    Examples
    --------
    >>> CameraSettings(tilt_deg=20.0, latency=0.1).rate
    30.0
    >>> CameraSettings(drop=1.5)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: drop = 1.5: must be in [0, 1); write for example drop = 0.1
    """

    position: tuple[float, float] = (0.0, 0.0)
    height: float = 2.0
    tilt_deg: float = 0.0
    roll_deg: float = 0.0
    pan_deg: float = 0.0
    focal_length: float = 600.0
    aspect: float = 1.0
    image_size: tuple[int, int] = (640, 480)
    k1: float = 0.0
    noise: float = 2.0
    blur: float = 0.5
    exposure: float = 1.0
    exposure_time: float = 0.0
    rate: float = 30.0
    latency: float = 0.066
    drop: float = 0.0
    colour: bool = False

    def __post_init__(self) -> None:
        for name, most, unit in (("noise", 255.0, "grey levels"), ("blur", 50.0, "px")):
            force_setattr(self, name, within(name, getattr(self, name), 0.0, most, unit=unit))
        force_setattr(self, "exposure_time", not_negative("exposure_time", self.exposure_time))
        positive("exposure", self.exposure)
        force_setattr(self, "rate", within("rate", self.rate, *RATES, unit="frames/s"))
        force_setattr(self, "latency", within("latency", self.latency, 0.0, LONGEST, unit="s"))
        if not 0.0 <= finite("drop", self.drop) < 1.0:
            raise InputError(
                f"drop = {self.drop:g}: must be in [0, 1); write for example drop = 0.1"
            )
        if not self.exposure_time < 1.0 / self.rate:
            raise InputError(
                f"exposure_time = {self.exposure_time:g}: must be shorter than the time between "
                f"frames, {1.0 / self.rate:.3g} s; write for example exposure_time = "
                f"{0.2 / self.rate:.2g}"
            )
        if not self.latency >= 0.5 * self.exposure_time:
            raise InputError(
                f"latency = {self.latency:g}: must be at least half of exposure_time = "
                f"{self.exposure_time:g}, when the shutter closes; write for example latency = "
                f"{0.5 * self.exposure_time + 0.05:.2g}"
            )
        width, height = numbers("image_size", self.image_size, 2)
        whole = width == int(width) and height == int(height)
        if not (whole and 64 <= width <= 4096 and 64 <= height <= 4096):
            raise InputError(
                f"image_size = {list(self.image_size)}: width and height must be whole numbers in "
                "[64, 4096] px; write for example image_size = [640, 480]"
            )
        force_setattr(self, "image_size", (int(width), int(height)))
        floor = self.pinhole().homography().inverse()
        for corner in self.lens().ideal_corners():
            if not floor.depth(*corner) > 0.0:
                raise InputError(
                    f"tilt_deg = {self.tilt_deg:g}: a corner of the picture shows the horizon; "
                    "tilt the camera less or take a longer focal_length"
                )

    def pinhole(self) -> PinholeCamera:
        """Return the camera without its lens distortion."""
        return PinholeCamera(
            position=self.position,
            height=self.height,
            focal_length=self.focal_length,
            image_size=self.image_size,
            tilt=math.radians(finite("tilt_deg", self.tilt_deg)),
            roll=math.radians(finite("roll_deg", self.roll_deg)),
            pan=math.radians(finite("pan_deg", self.pan_deg)),
            aspect=self.aspect,
        )

    def lens(self) -> Lens:
        """Return the lens, which bends what the pinhole camera would show."""
        return Lens(
            image_size=self.image_size,
            focal_length=self.focal_length,
            aspect=self.aspect,
            k1=self.k1,
        )
