"""The gains of the switching controller, and what it switches on."""

import math
from typing import Annotated, Literal

import msgspec
from msgspec import Meta
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.laws.ellipsoid import checked_ellipsoid
from parkproof.validate import Ratio, not_negative, positive

Exponent = Annotated[float | str, Meta(description='A number, or a ratio such as "9/11"')]
Moment = Annotated[
    float | Literal["settled"], Meta(description='"settled", or a time in seconds from the start')
]


def exponent(name: str, value: float | str, low: float, low_text: str) -> Ratio:
    """Read an exponent and check that it lies in (low, 1).

    Parameters
    ----------
    name : str
        "q0", "q1" or "q2".
    value : float or str
        A number or a ratio such as "9/11".
    low : float
        Open lower end of the interval.
    low_text : str
        The lower end as the paper writes it.

    Returns
    -------
    Ratio
        The exponent.

    Raises
    ------
    InputError
        If it cannot be read or lies outside the interval.

    Examples
    --------
    >>> str(exponent("q1", "9/11", 2 / 3, "2/3"))
    '9/11'
    """
    ratio = Ratio(value, name)
    if not low < ratio < 1.0:
        example = {"q0": "1/3", "q1": "9/11", "q2": "7/9"}.get(name, "9/11")
        raise InputError(
            f'{name} = {value}: must lie in ({low_text}, 1); write for example {name} = "{example}"'
        )
    return ratio


def gain(name: str, value: float) -> float:
    """Check that a gain is positive and of a size whose powers stay within the floats.

    Parameters
    ----------
    name : str
        What the gain is called.
    value : float
        The gain.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    InputError
        If it lies outside [1e-9, 1e9].

    Examples
    --------
    >>> gain("lambda1", 2)
    2.0
    """
    if not 1e-9 <= positive(name, value) <= 1e9:
        raise InputError(f"{name} = {value:g}: must lie between 1e-9 and 1e9; scale the units")
    return float(value)


class Gains(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains of the paper's switching controller (section 3), with those of the corrected law.

    Parameters
    ----------
    q0, q1, q2 : float or str
        Exponents of Steps 1, 2 and 3: q0 in (0, 1), q1 in (2/3, 1), q2 in (1/2, 1).
    lambda1 : float
        Gain λ1 > 0 of Step 1.
    l : three floats
        Gains l1, l2, l3 > 0 of Step 2.
    k : two floats
        Gains k̃1, k̃3 > 0 of Step 3.
    hold : two floats, optional
        The corrected law's gains for holding (x2, u1) and for turning (θ, ω), of the same form as
        ``k``. Default: the values of ``k``.
    runup_speed : float
        The corrected law's |u0| in Steps 1 and 2; the paper's is 1.
    direction : "auto", "toward", "forward" or "backward"
        The corrected law's direction of travel in Steps 1 and 2: the one that is estimated to leave
        less to undo, the one toward x0 = 0, or a given one; the paper drives forward.
    steering_speeds : two floats, optional
        The range of |u0| in which the corrected law goes on correcting x1 in Step 3; outside it
        holds the heading. Default (0.1, 1.0) times ``runup_speed``.
    return_steering : bool
        Whether the corrected law corrects x1 in Step 3 at all; if not, it holds the heading.
    ellipsoid : six floats, optional
        The homogeneous law's P11, P12, P13, P22, P23, P33 of Step 2, in place of ``q1`` and ``l``.
    feedback : three floats, optional
        The homogeneous law's k1, k2, k3 < 0 of Step 2.

    Raises
    ------
    InputError
        If an exponent lies outside its interval, a gain outside [1e-9, 1e9], speeds are given for a
        steering that is switched off, or P defines no V.

    Examples
    --------
    >>> gains = Gains(q1="9/11", l=(2.0, 4.2, 21.0), k=(1.5, 6.5))
    >>> str(gains.q1), gains.l[2]
    ('9/11', 21.0)
    """

    q0: Exponent = "1/3"
    q1: Exponent = "9/11"
    q2: Exponent = "7/9"
    lambda1: float = 1.0
    l: tuple[float, float, float] = (2.0, 4.2, 21.0)  # noqa: E741  (the paper's name)
    k: tuple[float, float] = (1.5, 6.5)
    hold: tuple[float, float] | None = None
    runup_speed: float = 1.0
    direction: Literal["auto", "toward", "forward", "backward"] = "auto"
    steering_speeds: tuple[float, float] | None = None
    return_steering: bool = True
    ellipsoid: tuple[float, float, float, float, float, float] | None = None
    feedback: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        force_setattr(self, "q0", exponent("q0", self.q0, 0.0, "0"))
        force_setattr(self, "q1", exponent("q1", self.q1, 2.0 / 3.0, "2/3"))
        force_setattr(self, "q2", exponent("q2", self.q2, 0.5, "1/2"))
        force_setattr(self, "lambda1", gain("lambda1", self.lambda1))
        force_setattr(self, "runup_speed", gain("runup_speed", self.runup_speed))
        for name in ("l", "k", "hold", "steering_speeds"):
            if (given := getattr(self, name)) is not None:
                force_setattr(self, name, tuple(gain(name, value) for value in given))
        if self.steering_speeds is not None:
            self._check_steering(*self.steering_speeds)
        if (self.ellipsoid is None) != (self.feedback is None):
            raise InputError(
                "ellipsoid and feedback belong together: write both, or leave both out"
            )
        if self.ellipsoid is not None:
            force_setattr(self, "ellipsoid", checked_ellipsoid(self.ellipsoid))
        if self.feedback is not None:
            sizes = tuple(gain("-feedback", -value) for value in self.feedback)
            force_setattr(self, "feedback", tuple(-size for size in sizes))

    def check_law(self, law: str) -> None:
        """Check that the gains are those that a law needs.

        Parameters
        ----------
        law : str
            Its name.

        Raises
        ------
        InputError
            If it is the homogeneous law and its gains are missing, or are those of a steering that
            it does not have.
        """
        if law != "homogeneous":
            return
        if self.ellipsoid is None:
            raise InputError(
                'law = "homogeneous" needs ellipsoid = [P11, P12, P13, P22, P23, P33] and '
                "feedback = [k1, k2, k3] in [gains]; write those that a design gives"
            )
        if self.steering_speeds is not None:
            raise InputError(
                'steering_speeds: the law "homogeneous" never steers in Step 3; leave them out'
            )

    def _check_steering(self, low: float, high: float) -> None:
        if not self.return_steering:
            raise InputError(
                f"steering_speeds = [{low}, {high}] with return_steering = false: Step 3 then "
                "never steers; leave one of them out"
            )
        if low >= high:
            raise InputError(
                f"steering_speeds = [{low}, {high}]: must be [low, high] with low < high; "
                f"write steering_speeds = [{high}, {low}]"
            )

    @property
    def exponents(self) -> tuple[Ratio, Ratio, Ratio]:
        """The exponents q0, q1, q2 as numbers."""
        return Ratio(self.q0), Ratio(self.q1), Ratio(self.q2)


class Switching(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the controller goes from step to step.

    Parameters
    ----------
    to_step2, to_step3 : "settled" or float
        A step ends at the first sample inside its tolerance, or at a given time in s. The corrected
        law leaves a step at a given time only if it is inside its tolerance, else as soon as it is.
    tolerance : three floats
        Step 1: |u0 − target|; Step 2: max(|x1|, |x2|, |u1|); Step 3: max(|x0|, |u0|).
    hysteresis : float
        The corrected law goes back to Step 1 when |x1| exceeds this many times its tolerance.
    turn_tolerance : float
        The corrected law's turn ends when |θ|, |ω| and |v| are below it (rad, rad/s, speed).
    chart_limit : float
        Heading in degrees, 0 < chart_limit < 90, beyond which the corrected law turns first. Later
        it turns again only where the heading has gone 19/20 of the way from there to 90°.

    Raises
    ------
    InputError
        If a tolerance is not positive, a time is negative or out of order, or the hysteresis does
        not exceed 1.

    Examples
    --------
    >>> Switching(to_step3=25.0).to_step3
    25.0
    """

    to_step2: Moment = "settled"
    to_step3: Moment = "settled"
    tolerance: tuple[float, float, float] = (1e-3, 1e-2, 1e-2)
    hysteresis: float = 2.0
    turn_tolerance: float = 0.05
    chart_limit: float = 80.0

    def __post_init__(self) -> None:
        for name in ("to_step2", "to_step3"):
            moment = getattr(self, name)
            if isinstance(moment, str) and moment != "settled":
                raise InputError(f'{name} = "{moment}": must be "settled" or a time in s')
            if not isinstance(moment, str):
                force_setattr(self, name, not_negative(name, moment))
        if (
            not isinstance(self.to_step2, str)
            and not isinstance(self.to_step3, str)
            and self.to_step2 >= self.to_step3
        ):
            raise InputError(
                f"to_step2 = {self.to_step2} and to_step3 = {self.to_step3}: the steps must follow "
                "each other; write a to_step3 after to_step2"
            )
        values = tuple(positive("tolerance", value, example=0.01) for value in self.tolerance)
        force_setattr(self, "tolerance", values)
        force_setattr(self, "turn_tolerance", positive("turn_tolerance", self.turn_tolerance))
        if not positive("hysteresis", self.hysteresis, example=2.0) > 1.0:
            raise InputError(
                f"hysteresis = {self.hysteresis}: must exceed 1, or the law would dither; write 2.0"
            )
        if not 0.0 < positive("chart_limit", self.chart_limit, example=80.0) < 90.0:
            raise InputError(
                f"chart_limit = {self.chart_limit}: must lie between 0 and 90 degrees; write 80.0"
            )

    @property
    def times(self) -> tuple[float, float]:
        """The times to_step2 and to_step3 in s, −1 where a step ends when settled."""

        def time(moment: float | str) -> float:
            return -1.0 if isinstance(moment, str) else moment

        return time(self.to_step2), time(self.to_step3)

    @property
    def chart_tangents(self) -> tuple[float, float]:
        """|x2| at the chart limit, and 19/20 of the way from there to 90°, where it turns again."""
        leave = self.chart_limit + 0.95 * (90.0 - self.chart_limit)
        return math.tan(math.radians(self.chart_limit)), math.tan(math.radians(leave))
