"""The controller used by hand: what it may know, what it remembers, what it answers."""

import inspect
import math
from collections.abc import Callable

import numpy as np
import pytest

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.chains import ChannelLaw
from parkproof.laws.controller import Command, Controller, measured_pose, measured_state
from parkproof.laws.corrected import corrected_channels
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.inputs import explicit_inputs, implicit_inputs
from parkproof.laws.parameters import Discretisation
from parkproof.laws.published import published_channels
from parkproof.laws.turn import turn_channels
from parkproof.model.chained import ChainedState, body_inputs
from parkproof.model.signals import Signal
from parkproof.model.truth import Truth
from parkproof.scenario import Robot, Scenario, Start
from parkproof.simulation.run import simulate

VELOCITY_BOUNDS = Bounds(alpha=(0.5, 1.5))
UNCERTAIN = Bounds(alpha=((0.5, 0.9), (1.0, 1.6)), gamma=(1.0, 2.0), disturbance=0.5)


def velocity_controller(period: float = 1 / 30) -> Controller:
    return Controller(
        law="corrected", bounds=VELOCITY_BOUNDS, control_period=period, robot="velocity"
    )


# -------------------------------------------------------------------------------- what it may know


def test_a_controller_is_made_from_bounds_and_never_from_the_truth() -> None:
    parameters = inspect.signature(Controller.__init__).parameters
    known = {"bounds", "gains", "switching", "saturation"}
    chosen = {"law", "control_period", "discretisation", "robot"}
    assert set(parameters) - {"self"} <= known | chosen
    assert Truth.__name__ not in str([p.annotation for p in parameters.values()])
    assert set(inspect.signature(Controller.step).parameters) == {"self", "measurement"}


def test_equal_measurements_give_equal_commands_whatever_is_true(
    section4: Callable[..., Scenario],
) -> None:
    """A run's measurements, shown to a second controller, give the run's commands."""
    for truth in ("sines", "adversary"):
        scenario = section4(truth=truth, duration=8.0, control_period=0.01, plant_step=0.01)
        columns = simulate(scenario).trajectory
        again = Controller(law="corrected", bounds=scenario.bounds, control_period=0.01)
        for k in range(len(columns["t"])):
            state = ChainedState(*(float(columns[n][k]) for n in ("x0", "x1", "x2", "u0", "u1")))
            command = again.step(measured_state(float(columns["t"][k]), state))
            assert (command.step, command.tau1, command.tau2) == (
                columns["step"][k],
                columns["tau1"][k],
                columns["tau2"][k],
            )


# --------------------------------------------------------------------------- around one's own plant


def value(signal: Signal, t: float) -> float:
    mean, tones = signal.mean_and_tones  # type: ignore[union-attr]  # sines here
    return float(mean + sum(a * math.sin(w * t + f) for a, w, f, _ in tones))


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("law", ["published", "corrected"])
def test_a_loop_written_by_hand_gives_the_run(
    section4: Callable[..., Scenario], truths: dict[str, Truth], law: str, discretisation: str
) -> None:
    truth, h, steps = truths["sines"], 5e-3, 5
    scenario = section4(law, duration=3.0, control_period=h, discretisation=discretisation)
    expected = simulate(scenario).trajectory
    controller = Controller(
        law=law,
        bounds=scenario.bounds,
        control_period=h,
        discretisation=discretisation,  # type: ignore[arg-type]  # a parameter of the test
    )
    state = np.array(scenario.start.state)

    def rates(t: float, s: np.ndarray, command: Command) -> np.ndarray:
        _, _, x2, u0, u1 = s
        (gamma1, gamma2), (phi1, phi2) = (
            [value(signal, t) for signal in pair] for pair in (truth.gamma, truth.disturbance)
        )
        return np.array(
            [u0, x2 * u0, u1, gamma1 * command.tau1 + phi1, gamma2 * command.tau2 + phi2]
        )

    for k in range(601):
        command = controller.step(measured_state(k * h, ChainedState(*map(float, state))))
        seen = [expected[name][k] for name in ("x0", "x1", "x2", "u0", "u1", "tau1", "tau2")]
        assert [*state, command.tau1, command.tau2] == pytest.approx(seen, rel=1e-6, abs=1e-8)
        assert command.step == expected["step"][k]
        part = h / steps
        for i in range(steps):
            t = k * h + i * part
            a = rates(t, state, command)
            b = rates(t + part / 2, state + part / 2 * a, command)
            c = rates(t + part / 2, state + part / 2 * b, command)
            d = rates(t + part, state + part * c, command)
            state = state + part / 6 * (a + 2 * b + 2 * c + d)


# --------------------------------------------------------------------------------- kinds of robots


def test_torque_robot_is_told_accelerations_that_feed_the_quadratic_terms_forward() -> None:
    """D7: u̇0 = v̇ cos θ − vω sin θ, u̇1 = ω̇/cos²θ + 2ω² tan θ/cos²θ come out as τ1, τ2."""
    controller = Controller(law="corrected", bounds=Bounds(), control_period=1e-3, robot="torque")
    v, omega, theta = 0.8, -0.7, 0.9
    command = controller.step(measured_pose(0.0, -1.0, 0.3, theta, v=v, omega=omega))
    c, s = math.cos(theta), math.sin(theta)
    u0_rate = command.acceleration * c - v * omega * s
    u1_rate = (command.turn_acceleration + 2.0 * omega**2 * math.tan(theta)) / c**2
    assert u0_rate == pytest.approx(command.tau1)
    assert u1_rate == pytest.approx(command.tau2)


@pytest.mark.parametrize(("theta", "step"), [(0.9, 1), (2.5, 0)])
def test_torque_robot_feeds_forward_in_a_mirrored_image(theta: float, step: int) -> None:
    """With ψ̇ = βω and β < 0 the command turns the robot the other way, in the chart or not."""
    plain, mirrored = (
        Controller(law="corrected", bounds=Bounds(), control_period=1e-3, robot="torque").step(
            measured_pose(0.0, -1.0, 0.3, theta, v=0.8, omega=-0.7, beta=beta)
        )
        for beta in (1.0, -2.0)
    )
    assert plain.step == mirrored.step == step
    assert mirrored.acceleration == pytest.approx(plain.acceleration)
    assert mirrored.turn_acceleration == pytest.approx(plain.turn_acceleration / -2.0)


def test_velocity_robot_integrates_its_inputs_in_the_controller() -> None:
    controller, h, theta = velocity_controller(0.05), 0.05, 0.4
    x2 = math.tan(theta)
    first = controller.step(measured_pose(0.0, -1.0, 0.2, theta))
    assert (first.speed, first.turn_rate) == pytest.approx(
        body_inputs(h * first.tau1, h * first.tau2, x2)
    )
    second = controller.step(measured_pose(h, -1.0, 0.2, theta))
    u0, u1 = h * (first.tau1 + second.tau1), h * (first.tau2 + second.tau2)
    assert (second.speed, second.turn_rate) == pytest.approx(body_inputs(u0, u1, x2))


def test_velocity_robot_ignores_measured_velocities() -> None:
    commands = [
        velocity_controller().step(measured_pose(0.0, -1.0, 0.2, 0.4, v=v, omega=omega))
        for v, omega in ((0.0, 0.0), (3.0, -2.0))
    ]
    assert commands[0] == commands[1]


def test_velocity_robot_sends_turn_rates_of_its_own_wheels() -> None:
    plain, mirrored = (
        velocity_controller().step(measured_pose(0.0, -1.0, 0.2, 2.5, beta=beta))
        for beta in (1.0, -0.5)
    )
    assert mirrored.turn_rate == pytest.approx(plain.turn_rate / -0.5)
    assert mirrored.speed == plain.speed


@pytest.mark.parametrize("degrees", [89.8, 91.0])
def test_velocity_robot_that_leaves_the_chart_goes_on_from_what_it_was_sent(degrees: float) -> None:
    """u0 and u1 are not v and ω: near 90° they differ by cos θ and cos² θ."""
    controller, h = velocity_controller(0.05), 0.05
    controller.hold_velocity(1.0, 1.0)
    sent = controller.step(measured_pose(0.0, -1.0, 0.2, math.radians(79.0)))
    outside = controller.step(measured_pose(h, -1.0, 0.2, math.radians(degrees)))
    assert (sent.step, outside.step) == (1, 0)
    assert outside.speed == pytest.approx(sent.speed + h * outside.tau1)
    assert outside.turn_rate == pytest.approx(sent.turn_rate + h * outside.tau2)


def test_velocity_robot_that_enters_the_chart_goes_on_from_what_it_was_sent() -> None:
    h, theta = 0.01, 0.02
    controller = Controller(
        law="corrected",
        bounds=VELOCITY_BOUNDS,
        switching=Switching(turn_tolerance=1.0),
        control_period=h,
        robot="velocity",
    )
    controller.hold_velocity(0.5, -0.3)
    sent = controller.step(measured_pose(0.0, -1.0, 0.2, 2.0))
    inside = controller.step(measured_pose(h, -1.0, 0.2, theta))
    assert (sent.step, inside.step) == (0, 1)
    c = math.cos(theta)
    assert inside.speed == pytest.approx(sent.speed + h * inside.tau1 / c)
    assert inside.turn_rate == pytest.approx(sent.turn_rate + h * inside.tau2 * c**2)


@pytest.mark.parametrize("theta", [0.5 * math.pi, -0.5 * math.pi, math.pi, -math.pi, 2.0])
def test_corrected_law_turns_first_and_published_law_says_that_it_cannot(theta: float) -> None:
    outside = measured_pose(0.0, -1.0, 0.2, theta)
    corrected = Controller(law="corrected", bounds=Bounds(), control_period=0.01)
    command = corrected.step(outside)
    assert command.step == 0
    assert command.tau2 * outside.theta < 0.0
    published = Controller(law="published", bounds=Bounds(), control_period=0.01)
    with pytest.raises(InputError, match="outside the chart"):
        published.step(outside)


@pytest.mark.parametrize(("discretisation", "ahead"), [("explicit", 0.0), ("implicit", 0.05)])
def test_implicit_turn_looks_one_period_ahead_of_its_heading(
    discretisation: Discretisation, ahead: float
) -> None:
    h, theta, v, omega = 0.05, 2.5, 0.8, -0.7
    controller = Controller(
        law="corrected", bounds=UNCERTAIN, control_period=h, discretisation=discretisation
    )
    command = controller.step(measured_pose(0.0, -1.0, 0.3, theta, v=v, omega=omega))
    p = controller.parameters
    form = implicit_inputs if ahead else explicit_inputs
    taus = {
        shift: form(*turn_channels(theta + shift * omega, p), v, omega, p)
        for shift in (-0.05, 0.0, 0.05)
    }
    assert command.step == 0
    assert (command.tau1, command.tau2) == pytest.approx(taus.pop(ahead))
    assert min(abs(command.tau2 - other) for _, other in taus.values()) > 0.01


@pytest.mark.parametrize(("discretisation", "ahead"), [("explicit", 0.0), ("implicit", 0.05)])
@pytest.mark.parametrize(
    ("law", "channels"), [("published", published_channels), ("corrected", corrected_channels)]
)
@pytest.mark.parametrize("step", [2, 3])
def test_implicit_law_looks_one_period_ahead_in_the_chart(
    law: str,
    channels: Callable[..., tuple[ChannelLaw, ChannelLaw]],
    step: int,
    discretisation: Discretisation,
    ahead: float,
) -> None:
    """At u as measured; x1 moves with the x2 of the period's end."""
    x0, x1, x2, u0, u1 = state = ChainedState(-1.0, 0.5, -0.4, 0.6, 0.7)
    controller = Controller(
        law=law,
        bounds=UNCERTAIN,
        gains=Gains(direction="forward"),
        # every step before the one looked at ends at once
        switching=Switching(tolerance=(9.0, 9.0 if step == 3 else 1e-3, 1e-3)),
        control_period=0.05,
        discretisation=discretisation,
    )
    commands = [controller.step(measured_state(0.05 * k, state)) for k in range(step)]
    p = controller.parameters
    form = implicit_inputs if ahead else explicit_inputs
    taus = {}
    for shift in (-0.05, 0.0, 0.05):
        end = x2 + shift * u1
        positions = (x0 + shift * 0.7 * u0, x1 + shift * 1.3 * u0 * end, end)
        taus[shift] = form(*channels(float(step), 1.0, *positions, u0, p), u0, u1, p)
    last = commands[-1]
    assert last.step == step
    assert (last.tau1, last.tau2) == pytest.approx(taus.pop(ahead))
    assert min(abs(last.tau2 - other) for _, other in taus.values()) > 0.01


def test_direction_of_travel_is_the_one_asked_for() -> None:
    ways = {}
    for direction in ("forward", "backward", "auto"):
        controller = Controller(
            law="corrected", bounds=Bounds(), gains=Gains(direction=direction), control_period=0.01
        )
        controller.step(measured_pose(0.0, 2.0, 0.1, 0.0))
        ways[direction] = controller.way
    assert ways == {"forward": 1.0, "backward": -1.0, "auto": -1.0}


def test_going_back_chooses_the_direction_anew() -> None:
    controller = Controller(
        law="corrected",
        bounds=Bounds(),
        switching=Switching(tolerance=(0.1, 0.1, 0.1)),
        control_period=0.01,
    )
    states = [
        ChainedState(-2.0, 0.3, 0.0, 1.0, 0.0),
        ChainedState(-2.0, 0.3, 0.0, 1.0, 0.0),
        ChainedState(-2.0, 0.0, 0.0, 1.0, 0.0),
        ChainedState(0.0, 0.0, 0.0, 0.0, 0.0),
        ChainedState(2.0, 0.5, 0.0, 0.0, 0.0),
    ]
    seen = []
    for k, state in enumerate(states):
        step = controller.step(measured_state(0.01 * k, state)).step
        seen.append((step, controller.way))
    assert seen == [(1, 1.0), (2, 1.0), (3, 1.0), (4, 1.0), (1, -1.0)]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": "printed"}, "there is no such law"),
        ({"control_period": 0.0}, "control_period"),
        ({"control_period": math.nan}, "control_period"),
        ({"robot": "velocity", "bounds": Bounds(disturbance=1.0)}, "velocity-commanded"),
        ({"robot": "velocity", "bounds": Bounds(gamma=(1.0, 2.0))}, "velocity-commanded"),
    ],
)
def test_a_controller_that_cannot_work_is_refused(change: dict[str, object], message: str) -> None:
    arguments = {"law": "corrected", "bounds": Bounds(), "control_period": 0.01} | change
    with pytest.raises(InputError, match=message):
        Controller(**arguments)  # type: ignore[arg-type]  # wrong on purpose


def test_gains_whose_powers_overflow_are_refused() -> None:
    with pytest.raises(InputError, match="must lie between 1e-9 and 1e9"):
        Controller(
            law="corrected",
            bounds=Bounds(),
            gains=Gains(l=(1e300, 1e300, 1.0)),
            control_period=0.01,
        )


def test_a_run_can_be_repeated_by_another_controller_of_the_same_settings(
    section4: Callable[..., Scenario],
) -> None:
    scenario = section4(
        bounds=VELOCITY_BOUNDS,
        truth="undisturbed",
        start=Start(pose=(-1.0, 0.4, 2.8)),
        robot=Robot(kind="velocity"),
        duration=9.0,
        control_period=0.033,
    )
    columns = simulate(scenario).trajectory
    controller = velocity_controller(0.033)
    for k in range(len(columns["t"])):
        pose = (float(columns[name][k]) for name in ("t", "xm", "ym", "theta"))
        command = controller.step(measured_pose(*pose))
        assert command.step == columns["step"][k]
        assert (command.tau1, command.tau2) == (columns["tau1"][k], columns["tau2"][k])
