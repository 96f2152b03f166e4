"""What a laboratory run is told: the law, times and tolerances. All have defaults that work."""

import math
from collections.abc import Sequence
from typing import Any, Literal

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.scenario_file.overrides import apply_overrides
from parkproof.scenario_file.read import converted
from parkproof.validate import not_negative, positive, within

CommandedBy = Literal["velocity", "torque"]
"""What a robot takes: speeds that its motors follow, or accelerations."""


RATES = 1.0, 1000.0
"""Frames per s that a camera can give."""

LONGEST = 5.0
"""Longest delay in s: with a longer one the robot would be driven blind."""


class LabSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a run goes.

    Parameters
    ----------
    law : "corrected" or "homogeneous"
        The law.
    gains : Gains, optional
        Its gains, in units of the tag's side. Default: chosen for the start, from the paper's at
        several speeds and slopes.
    motor_error : float
        By what share the robot's speeds, or accelerations, may differ from those that it is sent.
    disturbance : two floats
        Of a robot that takes accelerations: by how much, besides the motors' error, its
        accelerations may differ from those that it is sent, in m/s² and rad/s². Friction is most
        of it.
    rate : float
        Frames per s that are expected.
    delay : float
        Time in s from sending a command until the robot moves so; `parkproof camera --latency`
        measures it together with the camera's.
    stamp_delay : float
        By how much in s the time stamps of the frames are late: 0 for a camera that stamps the
        capture.
    position_px, heading_deg : float
        Within these of the goal, in px and degrees, the robot has arrived and rests.
    wait : float
        How long in s the camera is watched for the robot's tag to be seen for the first time.
    duration : float
        Longest time in s.
    hold : float
        How long the robot is watched and held once it is parked, in s.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> LabSettings().rate
    30.0
    """

    law: Literal["corrected", "homogeneous"] = "corrected"
    gains: Gains | None = None
    motor_error: float = 0.3
    disturbance: tuple[float, float] = (0.2, 2.0)
    rate: float = 30.0
    delay: float = 0.045
    stamp_delay: float = 0.0
    position_px: float = 0.5
    heading_deg: float = 0.4
    wait: float = 10.0
    duration: float = 90.0
    hold: float = 10.0

    def __post_init__(self) -> None:
        for name, example in (
            ("position_px", 0.5),
            ("heading_deg", 0.4),
            ("wait", 10.0),
            ("duration", 90.0),
        ):
            force_setattr(self, name, positive(name, getattr(self, name), example=example))
        force_setattr(self, "rate", within("rate", self.rate, *RATES, unit="frames/s"))
        for name in ("delay", "stamp_delay"):
            force_setattr(self, name, within(name, getattr(self, name), 0.0, LONGEST, unit="s"))
        for name in ("motor_error", "hold"):
            force_setattr(self, name, not_negative(name, getattr(self, name)))
        force_setattr(
            self, "disturbance", tuple(not_negative("disturbance", x) for x in self.disturbance)
        )
        if self.motor_error >= 0.9:
            raise InputError(
                f"motor_error = {self.motor_error:g}: must be below 0.9, a share of what is "
                "sent; write for example motor_error = 0.3"
            )
        if self.gains is not None:
            self.gains.check_law(self.law)
        elif self.law == "homogeneous":
            raise InputError(
                'law = "homogeneous" needs gains; write those of a design, in units of the tag side'
            )

    @property
    def heading(self) -> float:
        """``heading_deg`` in rad."""
        return math.radians(self.heading_deg)


def read_settings(overrides: Sequence[str] = ()) -> LabSettings:
    """The settings, with overrides from the command line.

    Parameters
    ----------
    overrides : sequence of str
        Expressions ``key=value``.

    Returns
    -------
    LabSettings
        Checked.

    Raises
    ------
    InputError
        If a key is unknown or a value out of its range.

    Examples
    --------
    >>> read_settings(["hold=30"]).hold
    30.0
    """
    data: dict[str, Any] = {}
    apply_overrides(data, overrides, LabSettings)
    return converted(data, LabSettings, "--set")
