"""A specification to prove or to design for: what is uncertain, the limits, and the starts."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import msgspec
from msgspec.structs import force_setattr

from parkproof.bounds import Bounds, Interval, Limits
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.scenario import Scenario
from parkproof.scenario_file.overrides import apply_overrides
from parkproof.scenario_file.read import converted, named_with, scenario_from_dict
from parkproof.scenario_file.toml import load_toml
from parkproof.validate import increasing, not_negative, positive

LARGEST_START = 1e3
"""No start may lie beyond this."""

LEAST, LARGEST = 1e-9, 1e9
"""Bounds and limits lie between them, so that their powers stay within the floats."""

SHORTEST_PERIOD, LONGEST_PERIOD, LONGEST_LATENCY, LARGEST_NOISE = 1e-5, 1.0, 1.0, 1e3
"""What the runs beside a proof can be carried out with; known before the long search for it."""


class Starts(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The box of starts: ranges of a chained state, or of a pose with a velocity.

    Parameters
    ----------
    x0, x1, x2, u0, u1 : pairs of floats
        Ranges [low, high] of a state; u0 and u1 are 0 if not given.
    x, y, theta, v, omega : pairs of floats
        Ranges of a pose in the goal's image frame and of a velocity, for any heading; v and omega
        are 0 if not given.

    Raises
    ------
    InputError
        If states and poses are mixed, one of the first three ranges is missing, or a range is
        crossed.

    Examples
    --------
    >>> Starts(x0=(-1, 1), x1=(-0.5, 0.5), x2=(0, 0)).ranges["u0"]
    (0.0, 0.0)
    """

    x0: Interval | None = None
    x1: Interval | None = None
    x2: Interval | None = None
    u0: Interval | None = None
    u1: Interval | None = None
    x: Interval | None = None
    y: Interval | None = None
    theta: Interval | None = None
    v: Interval | None = None
    omega: Interval | None = None

    def __post_init__(self) -> None:
        given = [name for name in self.__struct_fields__ if getattr(self, name) is not None]
        names = self._names
        if mixed := [name for name in given if name not in names]:
            raise InputError(
                f"[starts] {mixed[0]} does not go with {names[0]}: give ranges of x0, x1, x2 "
                "(u0, u1), or of x, y, theta (v, omega)"
            )
        if missing := [name for name in names[:3] if name not in given]:
            raise InputError(
                f"[starts] {missing[0]} is missing; write for example {missing[0]} = [-0.5, 0.5]"
            )
        for name in given:
            low, high = increasing(name, getattr(self, name))
            if max(abs(low), abs(high)) > LARGEST_START:
                raise InputError(
                    f"[starts] {name} = [{low:g}, {high:g}]: must lie within {LARGEST_START:g}; "
                    "scale the units"
                )
            force_setattr(self, name, (low, high))
        largest = 3.1416
        if self.theta is not None and max(abs(end) for end in self.theta) > largest:
            raise InputError(
                f"[starts] theta = {list(self.theta)}: must lie within one turn; write "
                f"theta = [-{largest}, {largest}] for every heading"
            )

    @property
    def _names(self) -> tuple[str, ...]:
        pose = any(getattr(self, name) is not None for name in ("x", "y", "theta"))
        return ("x", "y", "theta", "v", "omega") if pose else ("x0", "x1", "x2", "u0", "u1")

    @property
    def ranges(self) -> dict[str, Interval]:
        """All five ranges."""
        return {name: getattr(self, name) or (0.0, 0.0) for name in self._names}


AT_REST = Starts(x0=(-1.0, 1.0), x1=(-0.5, 0.5), x2=(-0.5, 0.5))
"""The starts where a file names none."""


class Aim(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a design is to find.

    Parameters
    ----------
    engine : "best", "paper" or "homogeneous"
        The corrected law with the paper's Step 2, the homogeneous law, or the better of both.
    aim : "time", "input" or "travel"
        What is made least: the proven time, the largest input, or the way from the goal.
    time_limit : float, optional
        Longest proven time in s; needed by the aims "input" and "travel".
    tolerance : float
        |x1|, |x2|, |u1| at which Step 2 ends, and |x0|, |u0| at which Step 3 does.
    x1_at_rest : float
        Largest |x1| that a parked robot may be left with.
    control_period, noise, latency : float
        Sampling in s, standard deviation of the measured states, and delay in s for the residual
        band, which is measured beside the proof.

    Raises
    ------
    InputError
        If a number is not positive (noise and latency: negative).

    Examples
    --------
    >>> Aim(engine="paper").aim
    'time'
    """

    engine: Literal["best", "paper", "homogeneous"] = "best"
    aim: Literal["time", "input", "travel"] = "time"
    time_limit: float | None = None
    tolerance: float = 0.01
    x1_at_rest: float = 0.05
    control_period: float = 1e-3
    noise: float = 0.0
    latency: float = 0.0

    def __post_init__(self) -> None:
        for name in ("tolerance", "x1_at_rest", "control_period"):
            force_setattr(self, name, positive(name, getattr(self, name), example=0.01))
        for name in ("noise", "latency"):
            force_setattr(self, name, not_negative(name, getattr(self, name)))
        between = {
            "control_period": (SHORTEST_PERIOD, LONGEST_PERIOD),
            "latency": (0.0, LONGEST_LATENCY),
            "noise": (0.0, LARGEST_NOISE),
        }
        for name, (low, high) in between.items():
            if not low <= (value := getattr(self, name)) <= high:
                raise InputError(
                    f"[design] {name} = {value:g}: must lie between {low:g} and {high:g}; write "
                    f"for example {name} = 0.001"
                )
        if self.time_limit is not None:
            force_setattr(self, "time_limit", positive("time_limit", self.time_limit, example=20))
        elif self.aim != "time":
            raise InputError(
                f'[design] aim = "{self.aim}" needs a time_limit, or the slowest run would be the '
                "best; write for example time_limit = 20.0"
            )
        if not self.x1_at_rest > self.tolerance:
            raise InputError(
                f"[design] x1_at_rest = {self.x1_at_rest:g}: must exceed tolerance = "
                f"{self.tolerance:g}, as x1 still drifts in the return"
            )


class Spec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is to be proved, or designed for.

    Parameters
    ----------
    bounds : Bounds
        What is uncertain; in a proof α, too, may vary in time.
    starts : Starts
        From where. Default: at rest, |x0| ≤ 1, |x1| ≤ 0.5, |x2| ≤ 0.5.
    limits : Limits
        Inputs, speeds and view that must be kept.
    design : Aim
        What a design is to find.
    gains : Gains, optional
        Gains to certify; a design finds its own.
    switching : Switching, optional
        When the law switches; found where it is not given.
    law : "corrected" or "homogeneous", optional
        The law to certify; default "corrected".
    title : str
        For reports.

    Raises
    ------
    InputError
        If a limit is beyond all measure.

    Examples
    --------
    >>> Spec(bounds=Bounds(alpha=(0.5, 1.5))).starts.ranges["x0"]
    (-1.0, 1.0)
    """

    bounds: Bounds
    starts: Starts = AT_REST
    limits: Limits = Limits()
    design: Aim = Aim()
    gains: Gains | None = None
    switching: Switching | None = None
    law: Literal["published", "corrected", "homogeneous"] | None = None
    title: str = ""

    def __post_init__(self) -> None:
        known = self.bounds
        for name, values in (
            ("alpha", (*known.alpha_of(0), *known.alpha_of(1))),
            ("gamma", (*known.gamma_of(0), *known.gamma_of(1))),
            ("disturbance", [LEAST + known.disturbance_of(i) for i in range(2)]),
            ("b2", known.b2),
        ):
            if min(values) < LEAST or max(values) > LARGEST:
                raise InputError(
                    f"[bounds] {name} = {getattr(known, name)}: must lie between {LEAST:g} and "
                    f"{LARGEST:g}; scale the units"
                )
        limits = self.limits
        for name in ("tau", "speed", "turn_rate", "view"):
            given = getattr(limits, name)
            values = given if isinstance(given, tuple) else (given or 0.0,)
            if max(map(abs, values)) > LARGEST:
                raise InputError(
                    f"[limits] {name} = {given}: must lie within {LARGEST:g}; leave it out where "
                    "nothing is limited"
                )


def read_spec(path: Path, *, overrides: Sequence[str] = ()) -> Spec:
    r"""Read a specification, or take one from a scenario, whose start is then a box of one point.

    Parameters
    ----------
    path : Path
        A TOML file.
    overrides : sequence of str
        As for `parkproof.read_scenario`.

    Returns
    -------
    Spec
        Checked.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or is no valid specification.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "spec.toml"
    ...     _ = path.write_text('[bounds]\nalpha = [0.5, 1.5]\n[limits]\ntau = [40.0, 40.0]\n')
    ...     read_spec(path).limits.tau
    (40.0, 40.0)
    """
    data = load_toml(Path(path), kind="design")
    root = Scenario if "start" in data else Spec
    apply_overrides(data, overrides, root)
    where = named_with(path, overrides)
    if root is Spec:
        return converted(data, Spec, where)
    scenario = scenario_from_dict(data, where=where)
    return Spec(
        bounds=scenario.bounds,
        starts=_point(scenario),
        limits=scenario.limits,
        gains=scenario.gains,
        switching=scenario.switching if "switching" in data else None,
        law=scenario.law,
        title=scenario.title,
    )


def _point(scenario: Scenario) -> Starts:
    """A scenario's start as a box."""
    start = scenario.start
    if scenario.camera is not None or scenario.robot.kind == "torque":
        raise InputError(
            "[camera] and torque-commanded robots: certificates are about the paper's model (6); "
            "write a specification with [bounds] of alpha and b2 and [starts] in the image"
        )
    if start.state is not None:
        names = ("x0", "x1", "x2", "u0", "u1")
        return Starts(**{name: (x, x) for name, x in zip(names, start.state, strict=True)})
    numbers = (*(start.pose or ()), *(start.velocity or (0.0, 0.0)))
    names = ("x", "y", "theta", "v", "omega")
    return Starts(**{name: (x, x) for name, x in zip(names, numbers, strict=True)})
