"""Learns how the robot answers to commands, from what the picture shows of its motion.

The tag's own homography gives a and β in every frame, so the robot's way and angle between two
frames follow from the picture; the commands in force meanwhile are known. Recursive least squares
with forgetting then find the gains of v and ω, and the turn that unequal wheels make of v.
"""

import math
from dataclasses import dataclass, field

from parkproof.lab.predict import Motion

FORGETTING = 0.98
"""Weight of the past from frame to frame."""

LEAST_WAY, LEAST_ANGLE = 1e-4, 1e-3
"""Ways in m and angles in rad between frames below which nothing is learnt."""

GAIN_RANGE = (0.5, 2.0)
"""Gains are kept within these."""

SKEW_RANGE = (-8.0, 8.0)
"""Skews in rad/m are kept within these."""

PRIOR_WAY, PRIOR_ANGLE = 0.01**2, 0.1**2
"""What the assumption of a perfect robot weighs: as if one such way and angle had been seen."""


def _within(value: float, bounds: tuple[float, float]) -> float:
    return min(max(value, bounds[0]), bounds[1])


@dataclass
class MotionEstimate:
    """Recursive least squares for a `Motion`.

    Examples
    --------
    >>> estimate = MotionEstimate()
    >>> for _ in range(50):
    ...     estimate.update(way=0.012, angle=0.02, sent_way=0.01, sent_angle=0.03)
    ...     estimate.update(way=0.006, angle=-0.02, sent_way=0.005, sent_angle=-0.02)
    >>> round(estimate.motion.speed, 2)
    1.2
    """

    _speed: list[float] = field(default_factory=lambda: [PRIOR_WAY, PRIOR_WAY])
    _turn: list[float] = field(
        default_factory=lambda: [PRIOR_ANGLE, 0.0, PRIOR_WAY, PRIOR_ANGLE, 0.0]
    )

    @property
    def motion(self) -> Motion:
        """The gains found so far."""
        square, product = self._speed
        s11, s12, s22, r1, r2 = self._turn
        determinant = s11 * s22 - s12 * s12
        turn = (s22 * r1 - s12 * r2) / determinant
        skew = (s11 * r2 - s12 * r1) / determinant
        return Motion(
            _within(product / square, GAIN_RANGE),
            _within(turn, GAIN_RANGE),
            _within(skew, SKEW_RANGE),
        )

    def update(self, *, way: float, angle: float, sent_way: float, sent_angle: float) -> None:
        """Take in what was seen and what was sent between two frames.

        Parameters
        ----------
        way, angle : float
            Seen: way in m and angle in rad.
        sent_way, sent_angle : float
            Sent: ∫v dt and ∫ω dt.
        """
        if not all(math.isfinite(x) for x in (way, angle, sent_way, sent_angle)):
            return
        keep = FORGETTING
        if abs(sent_way) >= LEAST_WAY:
            square, product = self._speed
            self._speed = [keep * square + sent_way**2, keep * product + sent_way * way]
        if abs(sent_way) >= LEAST_WAY or abs(sent_angle) >= LEAST_ANGLE:
            new = (
                sent_angle * sent_angle,
                sent_angle * sent_way,
                sent_way * sent_way,
                sent_angle * angle,
                sent_way * angle,
            )
            self._turn = [keep * old + x for old, x in zip(self._turn, new, strict=True)]
