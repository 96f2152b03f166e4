"""The laws against a plain transcription of the paper, and their exact symmetries."""

import inspect
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from parkproof.bounds import Bounds
from parkproof.laws.chains import (
    one_chain,
    three_chain,
    three_chain_surface,
    two_chain,
    two_chain_surface,
)
from parkproof.laws.corrected import corrected_begin, corrected_nominal, corrected_switch
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.inputs import inputs, predicted
from parkproof.laws.parameters import LawParameters, law_parameters
from parkproof.laws.published import published_nominal, published_switch
from parkproof.laws.robustify import robust, robust_implicit
from parkproof.laws.turn import turn_nominal
from parkproof.scenario import Scenario
from parkproof.simulation.run import simulate

# ---------------------------------------------------------------- section 3 of the paper, plainly


def odd(x: float, p: float) -> float:
    """⌈x⌋^p."""
    side = float(x > 0.0) - float(x < 0.0)
    return math.pow(abs(x), p) * side


def theorem1(wanted: float, phi: float, gamma_m: float) -> float:
    """τ = (τ̃ + φ sign τ̃)/γ."""
    if wanted > 0.0:
        return (wanted + phi) / gamma_m
    return (wanted - phi) / gamma_m if wanted < 0.0 else 0.0


class Plain(NamedTuple):
    """Gains of section 3 as drawn by hypothesis."""

    q0: float
    q1: float
    q2: float
    lambda1: float
    l1: float
    l2: float
    l3: float
    kk1: float
    kk3: float
    hold1: float
    hold3: float
    speed: float

    def step1(self, u0: float, target: float) -> float:
        return -self.lambda1 * odd(u0 - target, self.q0)

    def step2(self, x1: float, x2: float, u1: float) -> float:
        q = self.q1
        xi1 = odd(x2, 1 / q) + self.l1 ** (1 / q) * x1
        xi2 = odd(u1, 1 / (2 * q - 1)) + self.l2 ** (1 / (2 * q - 1)) * xi1
        return -self.l3 * odd(xi2, 3 * q - 2)

    def step3(self, x0: float, u0: float) -> float:
        q = self.q2
        return -self.kk3 * odd(odd(u0, 1 / q) + self.kk1 ** (1 / q) * x0, 2 * q - 1)

    def hold(self, x2: float, u1: float) -> float:
        q = self.q2
        return -self.hold3 * odd(odd(u1, 1 / q) + self.hold1 ** (1 / q) * x2, 2 * q - 1)

    def gains(self) -> Gains:
        return Gains(
            q0=self.q0,
            q1=self.q1,
            q2=self.q2,
            lambda1=self.lambda1,
            l=(self.l1, self.l2, self.l3),
            k=(self.kk1, self.kk3),
            hold=(self.hold1, self.hold3),
            runup_speed=self.speed,
        )


POSITIVE = st.floats(0.1, 30.0)
PLAIN = st.builds(
    Plain,
    q0=st.floats(0.05, 0.95),
    q1=st.floats(0.68, 0.98),
    q2=st.floats(0.52, 0.98),
    lambda1=POSITIVE,
    l1=st.floats(0.1, 5.0),
    l2=st.floats(0.1, 5.0),
    l3=POSITIVE,
    kk1=st.floats(0.1, 5.0),
    kk3=POSITIVE,
    hold1=st.floats(0.1, 5.0),
    hold3=POSITIVE,
    speed=st.floats(0.2, 2.0),
)
NUMBER = st.floats(-10.0, 10.0)
STATES = st.tuples(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER)
UNCERTAIN = st.builds(
    lambda low, factor, phi: Bounds(gamma=(low, low * factor), disturbance=phi),
    st.floats(0.2, 2.0),
    st.floats(1.0, 3.0),
    st.floats(0.0, 5.0),
)
WAYS = st.sampled_from([1.0, -1.0])


def parameters(plain: Plain, bounds: Bounds, period: float = 0.0) -> LawParameters:
    """Parameters of the explicit form, or of the implicit form at a period."""
    return law_parameters(
        bounds=bounds,
        gains=plain.gains(),
        switching=Switching(),
        control_period=period or 1e-3,
        discretisation="implicit" if period else "explicit",
    )


def explicit_inputs(
    nominal: Callable[..., tuple[float, float, float, float]],
    step: float,
    way: float,
    state: tuple[float, ...],
    p: LawParameters,
) -> tuple[float, float]:
    x0, x1, x2, u0, u1 = state
    ahead = predicted(x0, x1, x2, u0, u1, p)
    return inputs(*nominal(step, way, *ahead, u0, u1, p), u0, u1, p)


@given(PLAIN, UNCERTAIN, STATES, st.sampled_from([1, 2, 3, 4]))
def test_published_law_is_section_3_as_printed(
    plain: Plain, bounds: Bounds, state: tuple[float, ...], step: int
) -> None:
    x0, x1, x2, u0, u1 = state
    gamma_m, phi = bounds.gamma_of(0)[0], bounds.disturbance_of(0)
    wanted1 = {
        1: plain.step1(u0, 1.0),
        2: plain.step1(u0, 1.0),
        3: plain.step3(x0, u0),
        4: 0.0,
    }[step]
    wanted2 = plain.step2(x1, x2, u1) if step in (2, 3) else 0.0
    tau = explicit_inputs(published_nominal, step, 1.0, state, parameters(plain, bounds))
    assert tau[0] == pytest.approx(theorem1(wanted1, phi, gamma_m), rel=1e-9, abs=1e-12)
    assert tau[1] == pytest.approx(theorem1(wanted2, phi, gamma_m), rel=1e-9, abs=1e-12)


@given(PLAIN, UNCERTAIN, STATES, st.sampled_from([1, 2, 3, 4]), WAYS)
def test_corrected_law_is_the_paper_s_with_its_defects_mended(
    plain: Plain, bounds: Bounds, state: tuple[float, ...], step: int, way: float
) -> None:
    x0, x1, x2, u0, u1 = state
    gamma_m, phi = bounds.gamma_of(0)[0], bounds.disturbance_of(0)
    wanted1 = plain.step1(u0, way * plain.speed) if step <= 2 else plain.step3(x0, u0)
    # D3: correct x1 with the sign that u0 really has, where |u0| is neither small nor large
    in_window = 0.1 * plain.speed <= abs(u0) <= plain.speed
    if step == 2:
        wanted2 = plain.step2(way * x1, x2, u1)
    elif step == 3 and in_window:
        wanted2 = plain.step2(math.copysign(1.0, u0) * x1, x2, u1)
    else:
        wanted2 = plain.hold(x2, u1)
    tau = explicit_inputs(corrected_nominal, step, way, state, parameters(plain, bounds))
    assert tau[0] == pytest.approx(theorem1(wanted1, phi, gamma_m), rel=1e-9, abs=1e-12)
    assert tau[1] == pytest.approx(theorem1(wanted2, phi, gamma_m), rel=1e-9, abs=1e-12)


@given(PLAIN, UNCERTAIN, st.floats(-math.pi, math.pi), NUMBER, NUMBER)
def test_turn_stops_v_as_step_1_and_takes_theta_to_zero_as_step_3(
    plain: Plain, bounds: Bounds, theta: float, v: float, omega: float
) -> None:
    p = parameters(plain, bounds)
    wanted1, surface1, wanted2, surface2 = turn_nominal(theta, v, omega, p)
    assert wanted1 == pytest.approx(plain.step1(v, 0.0), rel=1e-9)
    assert wanted2 == pytest.approx(plain.hold(theta, omega), rel=1e-9, abs=1e-12)
    assert surface1 == 0.0
    assert surface2 == pytest.approx(-plain.hold1 * odd(theta, plain.q2), rel=1e-9)


@pytest.mark.parametrize("law", ["published", "corrected"])
def test_inputs_of_a_whole_run_are_those_of_the_transcription(
    section4: Callable[..., Scenario], law: str
) -> None:
    """Every sample of a run, with the step that a transcription of the switching puts in force."""
    run = simulate(section4(law, duration=8.0, control_period=2e-3, plant_step=2e-3))
    plain = Plain(1 / 3, 9 / 11, 7 / 9, 1.0, 2.0, 4.2, 21.0, 1.5, 6.5, 1.5, 6.5, 1.0)
    columns = run.trajectory
    step, way, steps_seen = 1, 1.0, set()
    for k in range(len(columns["t"])):
        x0, x1, x2, u0, u1 = (float(columns[n][k]) for n in ("x0", "x1", "x2", "u0", "u1"))
        if k == 0 and law == "corrected":
            way = -1.0  # u0 = 5.6 carries the robot past the goal
        if k > 0:
            if step == 1 and abs(u0 - way) <= 1e-3:
                step = 2
            elif step == 2 and max(abs(x1), abs(x2), abs(u1)) <= 1e-2:
                step = 3
            elif step == 3 and max(abs(x0), abs(u0)) <= 1e-2:
                step = 4
        assert int(columns["step"][k]) == step
        steps_seen.add(step)
        if law == "published":
            wanted1 = (0.0, plain.step1(u0, 1.0), plain.step1(u0, 1.0), plain.step3(x0, u0), 0.0)
            step2 = plain.step2(x1, x2, u1)
            wanted2 = (0.0, 0.0, step2, step2, 0.0)
        else:
            cruise, back, hold = plain.step1(u0, way), plain.step3(x0, u0), plain.hold(x2, u1)
            side = math.copysign(1.0, u0)
            steered = 0.1 <= abs(u0) <= 1.0
            wanted1 = (0.0, cruise, cruise, back, back)
            third = plain.step2(side * x1, x2, u1) if steered else hold
            wanted2 = (0.0, hold, plain.step2(way * x1, x2, u1), third, hold)
        for name, wanted in (("tau1", wanted1), ("tau2", wanted2)):
            assert columns[name][k] == pytest.approx(theorem1(wanted[step], 2.5, 1.0), rel=1e-9)
    assert steps_seen == {1, 2, 3, 4}


# ------------------------------------------------------------------------------------ switching


def switched(
    switch: Callable[..., float],
    step: float,
    state: tuple[float, ...],
    *,
    way: float = 1.0,
    t: float = 1.0,
    **switching: Any,
) -> float:
    p = law_parameters(
        bounds=Bounds(), gains=Gains(), switching=Switching(**switching), control_period=1e-3
    )
    return switch(step, way, t, *state, p)


SETTLED = {
    1.0: (5.0, 3.0, 0.4, 1.0005, 2.0),
    2.0: (5.0, 0.005, -0.005, 1.0, 0.009),
    3.0: (0.005, 0.0, 0.0, -0.005, 0.0),
}
NEARLY = {
    1.0: [(5.0, 3.0, 0.4, 1.0015, 2.0), (0.0, 0.0, 0.0, -1.0, 0.0)],
    2.0: [
        (5.0, 0.011, 0.0, 1.0, 0.0),
        (5.0, 0.0, -0.011, 1.0, 0.0),
        (5.0, 0.0, 0.0, 1.0, 0.011),
    ],
    3.0: [(0.011, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.011, 0.0)],
}


@pytest.mark.parametrize("switch", [published_switch, corrected_switch])
@pytest.mark.parametrize("step", [1.0, 2.0, 3.0])
def test_a_step_ends_at_the_first_sample_inside_its_tolerance(
    switch: Callable[..., float], step: float
) -> None:
    assert switched(switch, step, SETTLED[step]) == step + 1.0
    assert [switched(switch, step, state) for state in NEARLY[step]] == [step] * len(NEARLY[step])


def test_published_law_switches_at_a_given_time_whatever_the_state() -> None:
    far = (5.0, 3.0, 0.4, 4.0, 2.0)
    assert switched(published_switch, 1.0, far, t=0.999, to_step2=1.0) == 1.0
    assert switched(published_switch, 1.0, far, t=1.0, to_step2=1.0) == 2.0
    assert switched(published_switch, 2.0, far, t=24.999, to_step3=25.0) == 2.0
    assert switched(published_switch, 2.0, far, t=25.0, to_step3=25.0) == 3.0


def test_corrected_law_leaves_a_step_at_a_given_time_only_if_settled() -> None:
    assert switched(corrected_switch, 2.0, SETTLED[2.0], t=24.0, to_step3=25.0) == 2.0
    assert switched(corrected_switch, 2.0, NEARLY[2.0][0], t=26.0, to_step3=25.0) == 2.0
    assert switched(corrected_switch, 2.0, SETTLED[2.0], t=26.0, to_step3=25.0) == 3.0


def test_corrected_run_up_settles_at_the_speed_of_its_direction() -> None:
    backward = (0.0, 1.0, 0.0, -1.0, 0.0)
    assert switched(corrected_switch, 1.0, backward, way=-1.0) == 2.0
    assert switched(corrected_switch, 1.0, backward, way=1.0) == 1.0


@pytest.mark.parametrize("step", [3.0, 4.0])
def test_corrected_law_goes_back_once_x1_exceeds_hysteresis_times_tolerance(step: float) -> None:
    outside = {x1: (1.0, x1, 0.0, -1.0, 0.0) for x1 in (0.029, -0.029, 0.031, -0.031)}
    back = {
        x1: switched(corrected_switch, step, state, hysteresis=3.0) for x1, state in outside.items()
    }
    assert back == {0.029: step, -0.029: step, 0.031: 1.0, -0.031: 1.0}


@pytest.mark.parametrize("step", [1.0, 2.0, 3.0, 4.0])
def test_corrected_law_turns_again_half_way_from_the_chart_limit_to_90_degrees(step: float) -> None:
    inside = (0.0, 0.0, math.tan(math.radians(84.9)), 0.5, 0.0)
    outside = (0.0, 0.0, -math.tan(math.radians(85.1)), 0.5, 0.0)
    assert switched(corrected_switch, step, inside, chart_limit=80.0) == step
    assert switched(corrected_switch, step, outside, chart_limit=80.0) == 0.0


def test_corrected_law_begins_with_a_turn_outside_the_chart_limit() -> None:
    p = law_parameters(
        bounds=Bounds(), gains=Gains(), switching=Switching(chart_limit=70.0), control_period=1e-3
    )
    begins = [corrected_begin(math.tan(math.radians(a)), p) for a in (-71.0, -69.0, 69.0, 71.0)]
    assert begins == [0.0, 1.0, 1.0, 0.0]
    assert corrected_begin(math.inf, p) == 0.0


# ------------------------------------------------------------------------------------- surfaces


@given(PLAIN, NUMBER, NUMBER, st.floats(1e-5, 10.0), WAYS)
def test_nominal_inputs_change_sign_exactly_across_their_surfaces(
    plain: Plain, x1: float, x2: float, offset: float, side: float
) -> None:
    p = parameters(plain, Bounds())

    def away(surface: float) -> float:
        return surface + side * offset * (1.0 + abs(surface))

    surface = three_chain_surface(x1, x2, p.L1, p.l2, p.inv_q1, p.e1)
    three = three_chain(x1, x2, away(surface), p.L1, p.L2, p.l3, p.inv_q1, p.inv_e1, p.r1)
    two = two_chain(x2, away(two_chain_surface(x2, p.k1, p.q2)), p.K1, p.k3, p.inv_q2, p.r2)
    one = one_chain(away(1.0) - 1.0, p.lambda1, p.q0)
    assert [value * side < 0.0 for value in (three, two, one)] == [True] * 3


@given(PLAIN, STATES, st.sampled_from([1.0, 2.0, 3.0, 4.0]), WAYS, WAYS, st.floats(1e-5, 1.0))
def test_surfaces_of_both_laws_are_where_their_inputs_change_sign(
    plain: Plain, state: tuple[float, ...], step: float, way: float, side: float, offset: float
) -> None:
    p = parameters(plain, Bounds())
    x0, x1, x2, u0, u1 = state
    # in Step 3 u1* depends on whether |u0| is in the window, so each channel is moved by itself
    for nominal in (published_nominal, corrected_nominal):
        _, at1, _, at2 = nominal(step, way, x0, x1, x2, u0, u1, p)
        moved1 = at1 + side * offset * (1.0 + abs(at1))
        moved2 = at2 + side * offset * (1.0 + abs(at2))
        wanted1 = nominal(step, way, x0, x1, x2, moved1, u1, p)[0]
        wanted2 = nominal(step, way, x0, x1, x2, u0, moved2, p)[2]
        if nominal is published_nominal and step == 4.0:
            assert wanted1 == 0.0
            assert at1 == u0
        else:
            assert wanted1 * side < 0.0
        if nominal is published_nominal and step in (1.0, 4.0):
            assert wanted2 == 0.0
            assert at2 == u1
        else:
            assert wanted2 * side < 0.0


@given(
    st.floats(-30.0, 30.0),
    NUMBER,
    NUMBER,
    st.floats(0.0, 5.0),
    st.floats(0.2, 2.0),
    st.floats(1.0, 4.0),
    st.floats(1e-4, 0.1),
    st.floats(0.0, 1.0),
)
def test_implicit_input_never_overshoots_its_surface_and_never_exceeds_the_explicit_one(
    size: float, u: float, surface: float, phi: float, low: float, ratio: float, h: float, at: float
) -> None:
    nominal = math.copysign(size, surface - u)
    high = low * ratio
    gamma = low + at * (high - low)
    tau = robust_implicit(nominal, surface, u, phi, low, high, h)
    after = u + h * gamma * tau
    assert (after - surface) * (u - surface) >= -1e-12 * (1.0 + abs(u) + abs(surface))
    assert abs(after - surface) <= abs(u - surface) * (1.0 + 1e-12)
    assert abs(tau) <= (abs(nominal) + phi) / low
    if nominal != 0.0:
        assert abs(tau) <= abs(robust(nominal, phi, low)) * (1.0 + 1e-12)


@given(PLAIN, UNCERTAIN, STATES, st.sampled_from([1.0, 2.0, 3.0, 4.0]), WAYS)
def test_implicit_form_far_from_its_surface_is_the_explicit_form_at_the_predicted_positions(
    plain: Plain, bounds: Bounds, state: tuple[float, ...], step: float, way: float
) -> None:
    h = 1e-3
    p = parameters(plain, bounds, h)
    x0, x1, x2, u0, u1 = state
    ahead2 = x2 + h * u1
    ahead = (x0 + h * u0, x1 + h * u0 * ahead2, ahead2)
    n1, s1, n2, s2 = corrected_nominal(step, way, *ahead, u0, u1, p)
    tau = explicit_inputs(corrected_nominal, step, way, state, p)
    for value, wanted, surface, u, i in ((tau[0], n1, s1, u0, 0), (tau[1], n2, s2, u1, 1)):
        gamma_m, gamma_max = bounds.gamma_of(i)
        full = theorem1(wanted, bounds.disturbance_of(i), gamma_m)
        far = abs(surface - u) >= h * gamma_max * abs(full)
        expected = full if far else (surface - u) / (h * gamma_max)
        assert value == pytest.approx(expected, rel=1e-9, abs=1e-9)


# ----------------------------------------------------- the exact inclusion of theory as an oracle


def inclusion_input(
    wanted: Callable[[float], float], surface: float, u: float, phi: float, h: float
) -> float:
    """(u⁺ − u)/h for u⁺ + h(−ũ(u⁺) + φ Sgn(u⁺ − u*)) ∋ u, whose left side is strictly monotone."""
    if abs(u - surface) <= h * phi:
        return (surface - u) / h
    side = math.copysign(1.0, u - surface)
    low, high = min(surface, u), max(surface, u)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle - h * wanted(middle) + h * phi * side > u:
            high = middle
        else:
            low = middle
    return (0.5 * (low + high) - u) / h


def step2_loop(period: float, *, exact: bool, duration: float = 12.0) -> tuple[float, float, float]:
    """Steady max |x1|, max |x2| and total variation of τ2 a second, of Step 2 at u0 = 1."""
    gamma_max, phi, fine = 2.0, 2.5, 20
    p = law_parameters(
        bounds=Bounds(alpha=(1.0, 1.0), gamma=(1.0, gamma_max), disturbance=phi),
        gains=Gains(),
        switching=Switching(),
        control_period=period,
        discretisation="implicit",
    )
    x1, x2, u1 = 0.3, -0.5, 0.8
    rows = []
    n = round(duration / period)
    for k in range(n):
        x2_ahead = x2 + period * u1
        x1_ahead = x1 + period * x2_ahead
        surface = three_chain_surface(x1_ahead, x2_ahead, p.L1, p.l2, p.inv_q1, p.e1)

        def wanted(u: float, x1: float = x1_ahead, x2: float = x2_ahead) -> float:
            return three_chain(x1, x2, u, p.L1, p.L2, p.l3, p.inv_q1, p.inv_e1, p.r1)

        if exact:
            tau = inclusion_input(wanted, surface, u1, phi, period * gamma_max)
        else:
            tau = robust_implicit(wanted(u1), surface, u1, phi, 1.0, gamma_max, period)
        rows.append((abs(x1), abs(x2), tau))
        part = period / fine
        for i in range(fine):
            t = (k + i / fine) * period
            gamma = 1.5 + 0.5 * math.sin(0.7 * t)
            disturbance = 2.0 * math.sin(1.3 * t) + 0.4
            x1, x2, u1 = x1 + part * x2, x2 + part * u1, u1 + part * (gamma * tau + disturbance)
    steady = np.array(rows[n // 2 :])
    variation = float(np.sum(np.abs(np.diff(steady[:, 2])))) / (0.5 * duration)
    return float(steady[:, 0].max()), float(steady[:, 1].max()), variation


@pytest.mark.parametrize("period", [0.01, 0.033])
def test_closed_form_does_as_well_as_the_exact_inclusion(period: float) -> None:
    closed, exact = step2_loop(period, exact=False), step2_loop(period, exact=True)
    assert closed[0] <= 1.25 * exact[0]
    assert closed[1] <= 1.25 * exact[1]
    assert closed[2] <= 1.25 * exact[2]
    assert closed[2] < 5.0  # the explicit form: some 700 and 590


def test_the_oracle_has_the_bands_that_theory_reports() -> None:
    band1, band2, variation = step2_loop(0.01, exact=True)
    assert 2e-4 < band1 < 6e-4
    assert 2e-4 < band2 < 7e-4
    assert variation < 2.0


# ------------------------------------------------------------------------------------ symmetries


@given(PLAIN, STATES, st.sampled_from([1.0, 2.0, 3.0, 4.0]), WAYS, UNCERTAIN, st.booleans())
def test_laws_are_odd_in_the_lateral_states(
    plain: Plain,
    state: tuple[float, ...],
    step: float,
    way: float,
    bounds: Bounds,
    implicit: bool,
) -> None:
    p = parameters(plain, bounds, 1e-2 if implicit else 0.0)
    x0, x1, x2, u0, u1 = state
    mirrored = (x0, -x1, -x2, u0, -u1)
    for nominal in (published_nominal, corrected_nominal):
        tau1, tau2 = explicit_inputs(nominal, step, way, state, p)
        assert explicit_inputs(nominal, step, way, mirrored, p) == (tau1, -tau2)


@given(PLAIN, STATES, st.sampled_from([1.0, 2.0, 3.0, 4.0]), WAYS, UNCERTAIN, st.booleans())
def test_corrected_law_is_the_same_in_either_direction_of_travel(
    plain: Plain,
    state: tuple[float, ...],
    step: float,
    way: float,
    bounds: Bounds,
    implicit: bool,
) -> None:
    """Driving backward seen in a mirror, x0 → −x0 and x1 → −x1, is driving forward."""
    p = parameters(plain, bounds, 1e-2 if implicit else 0.0)
    x0, x1, x2, u0, u1 = state
    tau1, tau2 = explicit_inputs(corrected_nominal, step, way, state, p)
    mirrored = explicit_inputs(corrected_nominal, step, -way, (-x0, -x1, x2, -u0, u1), p)
    assert mirrored == (-tau1, tau2)


def not_cancelling(a: float, b: float) -> bool:
    """Whether a + b keeps most of its digits, so that its small powers can be compared."""
    return abs(a + b) > 1e-6 * (abs(a) + abs(b))


@given(PLAIN, NUMBER, NUMBER, NUMBER, st.floats(0.01, 100.0))
def test_step_2_and_its_chain_are_homogeneous(
    plain: Plain, x1: float, x2: float, u1: float, scale: float
) -> None:
    """F(Λx) = λ^(q−1) ΛF(x) with weights (1, q, 2q−1): τ̃2 then has the weight 3q−2."""
    q, e = plain.q1, 2.0 * plain.q1 - 1.0
    p = parameters(plain, Bounds())
    xi1 = odd(x2, 1 / q) + p.L1 * x1
    assume(not_cancelling(odd(x2, 1 / q), p.L1 * x1))
    assume(not_cancelling(odd(u1, 1 / e), p.L2 * xi1))

    def tau(x1: float, x2: float, u1: float) -> float:
        return three_chain(x1, x2, u1, p.L1, p.L2, p.l3, p.inv_q1, p.inv_e1, p.r1)

    scaled = (scale * x1, scale**q * x2, scale**e * u1)
    degree = scale ** (q - 1.0)
    assert scaled[1] == pytest.approx(degree * scale * x2)
    assert scaled[2] == pytest.approx(degree * scale**q * u1)
    assert tau(*scaled) == pytest.approx(degree * scale**e * tau(x1, x2, u1), rel=1e-6)
    surface = three_chain_surface(x1, x2, p.L1, p.l2, p.inv_q1, p.e1)
    scaled_surface = three_chain_surface(scaled[0], scaled[1], p.L1, p.l2, p.inv_q1, p.e1)
    assert scaled_surface == pytest.approx(scale**e * surface, rel=1e-6)


@given(PLAIN, NUMBER, NUMBER, st.floats(0.01, 100.0))
def test_step_3_and_its_chain_are_homogeneous(
    plain: Plain, x0: float, u0: float, scale: float
) -> None:
    """Weights (1, q), degree q − 1: τ̃1 has the weight 2q−1."""
    q = plain.q2
    p = parameters(plain, Bounds())
    assume(not_cancelling(odd(u0, 1 / q), p.K1 * x0))
    tau = two_chain(x0, u0, p.K1, p.k3, p.inv_q2, p.r2)
    scaled = two_chain(scale * x0, scale**q * u0, p.K1, p.k3, p.inv_q2, p.r2)
    assert scaled == pytest.approx(scale ** (2.0 * q - 1.0) * tau, rel=1e-6)


@given(PLAIN, NUMBER, NUMBER, NUMBER, st.floats(0.2, 5.0))
def test_gains_scale_with_time(plain: Plain, x1: float, x2: float, u1: float, kappa: float) -> None:
    """Faster by κ: x2 scales with κ, u1 with κ², τ2 with κ³; x1 not at all."""
    q, e = plain.q1, 2.0 * plain.q1 - 1.0
    p = parameters(plain, Bounds())
    assume(not_cancelling(odd(x2, 1 / q), p.L1 * x1))
    assume(not_cancelling(odd(u1, 1 / e), p.L2 * (odd(x2, 1 / q) + p.L1 * x1)))
    faster = parameters(
        plain._replace(
            l1=kappa * plain.l1, l2=kappa ** (1 / q) * plain.l2, l3=kappa ** (1 / e) * plain.l3
        ),
        Bounds(),
    )
    slow = published_nominal(2.0, 1.0, 0.0, x1, x2, 1.0, u1, p)
    fast = published_nominal(2.0, 1.0, 0.0, x1, kappa * x2, 1.0, kappa**2 * u1, faster)
    assert fast[2] == pytest.approx(kappa**3 * slow[2], rel=1e-6)
    assert fast[3] == pytest.approx(kappa**2 * slow[3], rel=1e-6)


# --------------------------------------------------------------------------- what a law may know


def test_laws_are_made_from_what_may_be_known_only() -> None:
    knowable = {"bounds", "gains", "switching", "control_period", "discretisation"}
    assert set(inspect.signature(law_parameters).parameters) == knowable


def test_laws_take_measured_numbers_and_parameters_only() -> None:
    measured = {"step", "way", "t", "x0", "x1", "x2", "u0", "u1", "p"}
    for law in (published_nominal, published_switch, corrected_nominal, corrected_switch):
        assert set(inspect.signature(law).parameters) <= measured
    assert all(annotation is float for annotation in LawParameters.__annotations__.values())
