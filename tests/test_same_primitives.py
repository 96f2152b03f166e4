"""Lanes and the plain run with the same primitives: not alike, but the same numbers."""

import functools
import sys
from collections.abc import Callable
from typing import Any

import numba
import pytest

from parkproof import scalar
from parkproof.laws.gains import Gains
from parkproof.model import signals as model_signals
from parkproof.model.signals import Sine
from parkproof.model.truth import Truth
from parkproof.scenario import Scenario, Start
from parkproof.simulation import plant
from parkproof.simulation.compiler import OPTIONS, register
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.lanes import kernel, signals
from parkproof.simulation.run import simulate
from parkproof.simulation.steps import chained_euler_step, time_in_period

Make = Callable[..., Scenario]
COARSE = {"control_period": 2e-3, "plant_step": 2e-3}
STARTS = ((-0.2, 0.3, -0.5, 2.6, 0.8), (0.5, -0.4, 0.3, 0.2, -0.1), (-1.0, 0.05, 0.0, 1.0, 0.0))
ENDS = ("outcome", "returns", "end1", "end2", "end3", "ended")
EXACT = (*ENDS, "x0", "x1", "x2", "u0", "u1", "peak_tau1", "peak_tau2", "least_x0", "max_u1")

register()


def compiled(name: str) -> Callable[..., float]:
    """A primitive as lanes have it."""
    primitive = getattr(scalar, name)
    made: Callable[..., float] = numba.njit(lambda *numbers: primitive(*numbers), **OPTIONS)  # noqa: PLW0108  # not compiled itself
    return made


@pytest.fixture
def same_primitives(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let plain Python call the primitives of lanes."""
    for name in ("spow", "spow_begun", "spows_begun", "spow_ended", "sine", "tangent"):
        plain, other = getattr(scalar, name), compiled(name)
        for module in list(sys.modules.values()):
            if module.__name__.startswith("parkproof") and vars(module).get(name) is plain:
                monkeypatch.setattr(module, name, other)


class Turned:
    """Waves as lanes have them: turned on from those at the start of every 32nd step.

    ``turns`` is how often they turn in an integration step.
    """

    def __init__(self, turns: int) -> None:
        self.turns = turns
        self.known: dict[tuple[float, float, float, int], tuple[float, float]] = {}
        self.period = self.steps = 0.0

    def waves(self, amplitude: float, omega: float, phase: float, m: int) -> tuple[float, float]:
        """Sine and cosine, times the amplitude, after so many turns."""
        wave = amplitude, omega, phase
        if (*wave, m) not in self.known:
            step = max(m - 1, 0) // 2 if self.turns == 2 else m
            anchor = step // signals.RENEWED * signals.RENEWED
            if m == self.turns * anchor:
                s, c = self.anew(*wave, anchor)
            else:
                before = m - 1 == self.turns * anchor
                s, c = self.anew(*wave, anchor) if before else self.waves(*wave, m - 1)
                angle = omega * (self.period / self.steps / self.turns)
                s, c = scalar.rotated(s, c, scalar.sine(angle), scalar.cosine(angle))
            self.known[*wave, m] = s, c
        return self.known[*wave, m]

    def anew(self, amplitude: float, omega: float, phase: float, step: int) -> tuple[float, float]:
        """Sine and cosine, times the amplitude, at the start of a step."""
        k, i = divmod(step, int(self.steps))
        t = k * self.period
        angle = omega * time_in_period(t, (k + 1) * self.period - t, i, self.steps) + phase
        return amplitude * scalar.sine(angle), amplitude * scalar.cosine(angle)

    def value(self, amplitude: float, omega: float, phase: float, square: float, t: float) -> float:
        """What takes the place of `tone_value`."""
        if square > 0.0:
            return amplitude * scalar.sign(scalar.sine(omega * t + phase))
        turns = t * self.turns * self.steps / self.period
        return self.waves(amplitude, omega, phase, round(turns))[0]


@pytest.fixture
def turned(monkeypatch: pytest.MonkeyPatch) -> Turned:
    """Let plain Python find its waves as lanes do."""
    made, advance = Turned(2), plant.Plant.advance

    def noting(self: plant.Plant, command: Any, t: float, h: float, steps: int) -> None:
        if t == 0.0:
            made.known.clear()
            made.period, made.steps = h, steps
        advance(self, command, t, h, steps)

    monkeypatch.setattr(plant.Plant, "advance", noting)
    monkeypatch.setattr(model_signals, "tone_value", made.value)
    return made


def results_of(scenario: Scenario) -> dict[str, Any]:
    run = simulate(scenario)
    ends = {f"end{i}": run.settling_time.steps.get(str(i)) for i in range(4)}
    return {
        "outcome": run.outcome,
        "returns": run.returns,
        **ends,
        "ended": run.ended,
        **run.metrics.final,
        **{f"peak_tau{i + 1}": run.metrics.peak_tau[i] for i in range(2)},
        "least_x0": run.metrics.x0_range[0],
        "max_u1": run.metrics.max_abs["u1"],
    }


def assert_same(given: list[Scenario], names: tuple[str, ...] = EXACT) -> None:
    lanes = simulate_ensemble(given)
    for i, scenario in enumerate(given):
        plain = results_of(scenario)
        for name in names:
            value = lanes[name][i]
            if name.startswith("end"):  # times of a summary are rounded to 9 places
                value = None if value != value else round(float(value), 9)  # noqa: PLR0124
                plain[name] = None if plain[name] is None else round(plain[name], 9)
            assert value == plain[name], (name, i)


def varying() -> Truth:
    return Truth(
        alpha=(Sine(mean=1.0, amplitude=0.4, omega=3.0), 0.7),
        gamma=(Sine(mean=1.5, amplitude=0.5, omega=2.0), Sine(mean=1.5, amplitude=0.5, omega=7.0)),
        disturbance=(Sine(amplitude=2.5, omega=1.0), Sine(amplitude=2.5, omega=3.0, phase=1.0)),
    )


@pytest.mark.usefixtures("same_primitives", "turned")
@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("law", ["published", "corrected", "homogeneous"])
def test_with_the_same_primitives_a_lane_is_the_plain_run_to_the_last_bit(
    section4: Make, law: str, discretisation: str
) -> None:
    gains = Gains(
        ellipsoid=(0.074812464, 0.066401839, 0.025390644, 0.079551713, 0.031872429, 0.018868936),
        feedback=(-3.8494493, -5.1332745, -2.6799631),
    )
    assert_same(
        [
            section4(
                law, gains=gains if law == "homogeneous" else Gains(), start=Start(state=start),
                truth=truth, duration=6.0, discretisation=discretisation, **COARSE,
            )
            for start, truth in zip(STARTS, (varying(), "noise", "squares"), strict=True)
        ]
    )  # fmt: skip


@pytest.mark.usefixtures("same_primitives", "turned")
def test_so_is_one_that_turns_first(section4: Make) -> None:
    start = Start(pose=(-1.0, 0.5, 2.0), velocity=(0.5, 0.1))
    assert_same([section4(start=start, truth=varying(), duration=6.0, **COARSE)])


@pytest.mark.usefixtures("same_primitives")
def test_so_is_one_integrated_by_euler_s_method(
    section4: Make, turned: Turned, monkeypatch: pytest.MonkeyPatch
) -> None:
    turned.turns = 1

    def step(x0, x1, x2, u0, u1, scales, _m, _e, rate1, _m1, _e1, rate2, _m2, _e2, h):  # type: ignore[no-untyped-def]
        return chained_euler_step(x0, x1, x2, u0, u1, scales, rate1, rate2, h)

    given = [
        section4(start=Start(state=start), truth=varying(), duration=3.0, **COARSE)
        for start in STARTS
    ]
    fourth = [results_of(scenario)["x1"] for scenario in given]
    monkeypatch.setattr(plant, "chained_step", step)
    monkeypatch.setattr(kernel, "kernel_of", functools.partial(kernel.kernel_of, euler=True))
    assert_same(given)
    assert [results_of(scenario)["x1"] for scenario in given] != fourth
