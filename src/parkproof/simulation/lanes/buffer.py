"""The buffer of a block of lanes, and the numbers that all of its trials share."""

from typing import NamedTuple, TypedDict

from parkproof.laws.controller import RobotKind
from parkproof.laws.parameters import LawParameters

BLOCK = 64 if __name__ == "parkproof.simulation.lanes.buffer" else 1
"""Lanes side by side: enough to fill vector registers, few enough for the first-level cache. One
where this package is loaded again for graphics processors (`parkproof.simulation.gpu`)."""

GROUP = min(8, BLOCK)
"""Lanes that go through a law together: those of one vector register."""

GROUPS = BLOCK // GROUP
"""Groups of a block."""

OWN_ROWS = 4 if BLOCK > 1 else 1
"""Rows of a number that each of the four steps after the turn has for itself: a group with lanes in
several of them goes through each. A block of one lane is in one step at a time."""

DIVERGED, OUT_OF_VIEW, LEFT_CHART, INPUT_LIMIT, SPEED_LIMIT = 1.0, 2.0, 3.0, 4.0, 5.0
"""Codes of the row ``ended``; 0 where a trial ran to its end."""

ROWS = (
    # results
    "step", "way", "returns", "ended", "ended_at", "end0", "end1", "end2", "end3",
    "s0", "s1", "s2", "s3", "s4",
    "residual0", "residual1", "residual2", "held0", "held1", "held2",
    "peak1", "peak2", "excursion2", "square1", "square2", "variation1", "variation2", "path",
    "max0", "max1", "max2", "max3", "max4", "low0", "high0", "speed", "turn_rate", "heading",
    # working values
    "chart", "next", "ending", "tau1", "tau2", "new1", "new2",
    "push1", "push2", "turn_square", "place",
    "kept0", "kept1", "kept2", "kept3", "kept4", "length", "kept_length",
    "rest1", "rest2", "rest3", "rest4", "rest5",
    "seen0", "seen1", "seen2", "seen3", "seen4", "raw2", "raw3", "raw4", "raw_chart",
    # of cameras, and of robots that take accelerations or velocities
    "beta", "seen_beta", "own0", "own1", "own2", "own3", "own4",
    "pose0", "pose1", "pose2", "pose3", "pose4",
    "kept_u0", "kept_u1", "kept_chart", "kept_v", "kept_omega", "act1", "act2",
    *(f"{name}_{when}" for when in ("mean", "start", "middle", "end") for name in (
        "gamma1", "gamma2", "phi1", "phi2", "alpha1", "alpha2", "b2",
    )),
    # what the implicit form seeks, for each channel
    *(f"{name}_{channel}" for channel in (1, 2) for name in (
        "size", "power", "offset", "outer", "surface", "side", "distance",
        "low", "high", "at_low", "at_high", "last", "at", "open",
    )),
    # what the explicit form has begun, for each step
    *(f"{name}_{i}" for name in ("begun1", "begun2", "error1", "error2") for i in range(OWN_ROWS)),
)  # fmt: skip
"""Rows of a block's buffer. One buffer, so that the compiler sees that rows never overlap."""

RESULTS = ROWS[: ROWS.index("chart")]
"""Rows that a kernel returns: ``end_i`` is when Step i last ended (−1 if not), ``held_i`` the
largest error since holding began, ``excursion2`` the excursion squared, ``max_i`` the largest |x0|,
|x1|, |x2|, |u0|, |u1|, ``low0`` and ``high0`` the range of x0, ``heading`` the
largest |θ| outside the chart."""

(
    STEP, WAY, RETURNS, ENDED, ENDED_AT, END0, END1, END2, END3,
    S0, S1, S2, S3, S4,
    RESIDUAL0, RESIDUAL1, RESIDUAL2, HELD0, HELD1, HELD2,
    PEAK1, PEAK2, EXCURSION2, SQUARE1, SQUARE2, VARIATION1, VARIATION2, PATH,
    MAX0, MAX1, MAX2, MAX3, MAX4, LOW0, HIGH0, SPEED, TURN_RATE, HEADING,
    CHART, NEXT, ENDING, TAU1, TAU2, NEW1, NEW2,
    PUSH1, PUSH2, TURN_SQUARE, PLACE,
    KEPT0, KEPT1, KEPT2, KEPT3, KEPT4, LENGTH, KEPT_LENGTH,
    REST1, REST2, REST3, REST4, REST5,
    SEEN0, SEEN1, SEEN2, SEEN3, SEEN4, RAW2, RAW3, RAW4, RAW_CHART,
    BETA, SEEN_BETA, OWN0, OWN1, OWN2, OWN3, OWN4,
    POSE0, POSE1, POSE2, POSE3, POSE4,
    KEPT_U0, KEPT_U1, KEPT_CHART, KEPT_V, KEPT_OMEGA, ACT1, ACT2,
    *_REST,
) = range(0, BLOCK * len(ROWS), BLOCK)  # fmt: skip
"""Where each row begins: lane j of row ``TAU1`` is ``b[TAU1 + j]``."""

RESTS = REST1 - SQUARE1
"""How far behind a sum, from `SQUARE1` to `PATH`, lies what rounding took from it."""

SIGNALS = 7
"""Signals of a trial: γ1, γ2, φ1, φ2, α1, α2, b2."""

MEAN, START, MIDDLE, END = _REST[: 4 * SIGNALS : SIGNALS]
"""Where the rows of signals begin: their means, and their values at a step's start, middle and
end."""

GAMMA1, GAMMA2, PHI1, PHI2, ALPHA1, ALPHA2, B2 = range(0, BLOCK * SIGNALS, BLOCK)
"""Where the row of each signal begins, counted from one of these."""

(
    SIZE, POWER, OFFSET, OUTER, SURFACE, SIDE, DISTANCE,
    LOW, HIGH, AT_LOW, AT_HIGH, LAST, AT, OPEN,
) = _REST[4 * SIGNALS : 4 * SIGNALS + 14]  # fmt: skip
CHANNELS = _REST[4 * SIGNALS + 14] - SIZE
"""How far the second channel's rows of a search lie behind those of the first, given above."""

BEGUN1, BEGUN2, ERROR1, ERROR2 = _REST[4 * SIGNALS + 28 :: OWN_ROWS]
"""Where the rows of each begin that the explicit form has for each step."""

STEPS = 5
"""Steps of a law: turn, run-up, approach, return, hold."""

LISTED = STEPS * (1 + GROUPS)
"""Whole numbers that say which groups have lanes in which step: how many for each step, then which
(`parkproof.simulation.lanes.order.group_of`)."""

BEFORE = -1.0
"""In the row ``step``: the law has not begun."""

ASK = -2.0
"""In the row ``next``: a lane that cannot go on, or one that may have turned far enough or beyond
half a turn. Such are looked at one by one."""

UNUSED, SINES, SQUARES = 0, 1, 2
"""What the lanes of a block have of a tone: nothing, sines at most, or square waves, too."""

TONE_ROWS = 8
OMEGA, PHASE, SQUARE, SINE, COSINE, TURN_SINE, TURN_COSINE = range(BLOCK, BLOCK * TONE_ROWS, BLOCK)
"""Where the rows of a tone begin, counted from that of its amplitude: what it is, its waves now
(times the amplitude), and the rotation by which they go on."""

TONE = BLOCK * TONE_ROWS
"""How far apart tones are."""


class Clock(NamedTuple):
    """Times of an ensemble."""

    period: float
    samples: int
    plant_steps: int
    residual_from: float


class LaneLimits(NamedTuple):
    """Limits as plain numbers, infinite where there are none."""

    tau1: float
    tau2: float
    speed: float
    turn_rate: float
    x_min: float
    x_max: float
    y_min: float
    y_max: float


class Sensing(NamedTuple):
    """Latency in samples, and the noise of the five states."""

    delay: int
    deviations: tuple[float, float, float, float, float]

    @property
    def exact(self) -> bool:
        """Whether measurements are without noise and latency."""
        return self.delay == 0 and not any(self.deviations)


class KernelKind(TypedDict):
    """What a kernel is compiled for; see `parkproof.simulation.lanes.kernel.kernel_of`."""

    law_name: str
    implicit: bool
    exact: bool
    robot: RobotKind
    camera: bool


Shared = tuple[LawParameters, Clock, LaneLimits, Sensing]
"""Numbers that all trials of a kernel's call share."""
