"""Runs: the plant, its integration, outcomes, metrics, and the corrected law parking."""

import itertools
import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws.controller import Command, measured_pose, measured_state
from parkproof.laws.gains import Gains, Switching
from parkproof.model.chained import ChainedState
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import image_of
from parkproof.model.signals import Adversary, Constant, Sine, Square
from parkproof.model.truth import Truth, channel, scales
from parkproof.model.unicycle import Pose
from parkproof.scenario import Robot, Scenario, Start
from parkproof.simulation.metrics import metrics_of
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.plant import Plant
from parkproof.simulation.run import COLUMNS, Recorder, Run, plant_steps, simulate

Make = Callable[..., Scenario]
STATES = ("x0", "x1", "x2", "u0", "u1")
COARSE = {"control_period": 2e-3, "plant_step": 2e-3}
WITHIN = Switching(tolerance=(1e-2, 1e-2, 1e-2))
ALLOWED = {
    "published": {(1, 2), (2, 3), (3, 4)},
    "corrected": {(0, 1), (0, 3), (1, 2), (2, 3), (3, 4), (3, 1), (4, 1)},
}


def transitions(run: Run) -> set[tuple[int, int]]:
    steps = [int(step) for step in run.trajectory["step"]]
    return {(a, b) for a, b in itertools.pairwise(steps) if a != b}


# ----------------------------------------------------------------------- the corrected law parks


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("truth", ["sines", "squares", "noise", "adversary"])
def test_corrected_law_parks_at_every_corner_of_the_bounds(
    section4: Make, truths: dict[str, Truth], truth: str, discretisation: str
) -> None:
    for alpha in itertools.product((0.5, 1.5), (0.5, 1.5)):
        run = simulate(
            section4(
                truth=msgspec.structs.replace(truths[truth], alpha=alpha),
                discretisation=discretisation,
                switching=WITHIN,
                duration=20.0,
                **COARSE,
            )
        )
        assert run.outcome is Outcome.PARKED, alpha
        assert run.returns <= 2
        assert transitions(run) <= ALLOWED["corrected"]
        assert run.metrics.residual <= 0.01


HEADINGS = [0.0, 1.45, 0.5 * math.pi, -0.5 * math.pi, 2.5, math.pi, -math.pi]


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("kind", ["chained", "torque", "velocity"])
def test_corrected_law_parks_from_any_heading(
    section4: Make, bounds: Bounds, kind: str, discretisation: str
) -> None:
    commanded_by_velocity = kind == "velocity"
    for theta in HEADINGS:
        run = simulate(
            section4(
                bounds=Bounds(alpha=(0.5, 1.5)) if commanded_by_velocity else bounds,
                truth="undisturbed" if commanded_by_velocity else "sines",
                start=Start(pose=(-1.0, 0.5, theta), velocity=(0.5, 0.2)),
                robot=Robot(kind=kind),  # type: ignore[arg-type]  # a parameter of the test
                discretisation=discretisation,
                switching=WITHIN,
                duration=12.0,
                **COARSE,
            )
        )
        assert run.outcome is Outcome.PARKED, theta
        assert run.returns == 0
        assert transitions(run) <= ALLOWED["corrected"]
        beyond_limit = abs(theta) > math.radians(80.0)
        assert (run.trajectory["step"][0] == 0) == beyond_limit
        assert ("0" in run.settling_time.steps) == beyond_limit


def test_velocity_commanded_robot_parks_at_30_hz(section4: Make) -> None:
    for theta, alpha in ((0.1, (0.5, 1.5)), (-3.1, (1.5, 0.5))):
        run = simulate(
            section4(
                bounds=Bounds(alpha=(0.5, 1.5)),
                truth=Truth(alpha=alpha),
                start=Start(pose=(-1.0, 0.5, theta)),
                robot=Robot(kind="velocity"),
                control_period=1 / 30,
                discretisation="implicit",
                duration=20.0,
            )
        )
        assert run.outcome is Outcome.PARKED
        assert run.metrics.residual < 5e-4


def test_implicit_form_does_not_chatter(section4: Make) -> None:
    explicit, implicit = (
        simulate(section4(discretisation=form, duration=8.0)) for form in ("explicit", "implicit")
    )
    assert explicit.outcome is implicit.outcome is Outcome.PARKED
    for rough, smooth in zip(
        explicit.metrics.total_variation_tau, implicit.metrics.total_variation_tau, strict=True
    ):
        assert smooth < rough / 50.0


def going_back(section4: Make, *, duration: float) -> Scenario:
    return section4(
        truth="adversary",
        discretisation="implicit",
        control_period=0.01,
        duration=duration,
        switching=Switching(tolerance=(1e-2, 5e-2, 5e-2), hysteresis=1.2),
    )


def test_going_back_to_the_run_up_happens_few_times_and_ends(section4: Make) -> None:
    """An adversary at 10 ms pushes x1 out once; the run-up is repeated and the robot parks."""
    run = simulate(going_back(section4, duration=25.0))
    assert run.outcome is Outcome.PARKED
    steps = run.trajectory["step"]
    assert run.returns == int(np.sum(np.diff(steps) < 0)) == 1
    assert transitions(run) <= ALLOWED["corrected"]


def test_going_back_takes_back_the_ends_of_the_steps(section4: Make) -> None:
    whole = simulate(going_back(section4, duration=25.0)).trajectory
    back = float(whole["t"][1:][np.diff(whole["step"]) < 0][0])
    before, after = (simulate(going_back(section4, duration=back + wait)) for wait in (-0.02, 0.02))
    assert (before.returns, after.returns) == (0, 1)
    assert before.settling_time.steps["2"] is not None
    assert after.trajectory["step"][-1] == 1
    assert after.settling_time.steps == {"1": None, "2": None, "3": None}


def test_what_follows_step_2_is_counted_from_its_first_end(section4: Make) -> None:
    """Also where the law goes back and ends Step 2 again."""
    run = simulate(going_back(section4, duration=25.0))
    step = run.trajectory["step"]
    ends = np.flatnonzero((step[:-1] == 2) & (step[1:] == 3)) + 1
    assert len(ends) == 2
    first, last = (
        {name: float(np.abs(run.trajectory[name][end:]).max()) for name in STATES} for end in ends
    )
    assert run.metrics.max_abs_after_step2 == first != last


@pytest.mark.parametrize("law", ["published", "corrected"])
def test_steps_follow_each_other_in_order(section4: Make, law: str) -> None:
    run = simulate(section4(law, switching=WITHIN, duration=12.0, **COARSE))
    assert transitions(run) == {(1, 2), (2, 3), (3, 4)}
    ends = [run.settling_time.steps[str(i)] for i in (1, 2, 3)]
    assert None not in ends
    assert ends == sorted(ends, key=lambda end: end or 0.0)
    steps, t = run.trajectory["step"], run.trajectory["t"]
    assert ends == [pytest.approx(t[np.argmax(steps == i)]) for i in (2, 3, 4)]


# --------------------------------------------------------------------------- Step 1's settling time


@pytest.mark.parametrize(("u0", "q0", "lambda1"), [(5.6, "1/3", 1.0), (-1.0, "3/5", 2.0)])
@pytest.mark.parametrize("law", ["published", "corrected"])
def test_step_1_settles_within_the_paper_s_bound_and_an_adversary_reaches_it(
    section4: Make, law: str, u0: float, q0: str, lambda1: float
) -> None:
    exponent = float(msgspec.structs.asdict(Gains(q0=q0))["q0"])
    bound = abs(u0 - 1.0) ** (1.0 - exponent) / (lambda1 * (1.0 - exponent))
    # time left inside the tolerance at which the step ends
    rest = 1e-2 ** (1.0 - exponent) / (lambda1 * (1.0 - exponent))
    ends = {}
    for truth in ("adversary", "sines", "squares", "noise"):
        run = simulate(
            section4(
                law,
                truth=truth,
                start=Start(state=(0.0, 0.3, 0.0, u0, 0.0)),
                gains=Gains(q0=q0, lambda1=lambda1, direction="forward"),
                switching=WITHIN,
                duration=bound + 0.1,
                **COARSE,
            )
        )
        end = run.settling_time.steps["1"]
        assert end is not None
        ends[truth] = end
    assert ends["adversary"] == pytest.approx(bound - rest, abs=0.01)
    assert max(ends["sines"], ends["squares"], ends["noise"]) < 0.8 * bound


# -------------------------------------------------------------------------------------- symmetries


def mirrored_truth(amplitude1: float, amplitude2: float) -> Truth:
    return Truth(
        alpha=(0.7, 1.3),
        gamma=(
            Sine(mean=1.5, amplitude=0.5, omega=1.0),
            Sine(mean=1.5, amplitude=0.5, omega=2.0, phase=1.0),
        ),
        disturbance=(
            Sine(amplitude=amplitude1, omega=1.3),
            Sine(amplitude=amplitude2, omega=1.7, phase=0.4),
        ),
    )


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("law", ["published", "corrected"])
def test_a_run_mirrored_left_to_right_is_the_mirrored_run(
    section4: Make, law: str, discretisation: str
) -> None:
    settings = {"duration": 5.0, "discretisation": discretisation, "switching": WITHIN, **COARSE}
    one, other = (
        simulate(
            section4(
                law,
                truth=mirrored_truth(2.5, side * 2.5),
                start=Start(state=(-0.2, side * 0.3, side * -0.5, 2.6, side * 0.8)),
                **settings,
            )
        ).trajectory
        for side in (1.0, -1.0)
    )
    for name in ("x0", "u0", "tau1", "step"):
        assert np.array_equal(one[name], other[name])
    for name in ("x1", "x2", "u1", "tau2", "theta", "omega"):
        assert np.array_equal(one[name], -other[name])


@pytest.mark.parametrize("theta", [0.5, 2.5])
def test_a_turning_run_mirrored_left_to_right_is_the_mirrored_run(
    section4: Make, theta: float
) -> None:
    one, other = (
        simulate(
            section4(
                truth=mirrored_truth(2.5, side * 2.5),
                start=Start(pose=(-1.0, side * 0.3, side * theta), velocity=(0.2, side * 0.1)),
                switching=WITHIN,
                duration=4.0,
                **COARSE,
            )
        ).trajectory
        for side in (1.0, -1.0)
    )
    assert np.array_equal(one["step"], other["step"])
    assert np.array_equal(one["xm"], other["xm"])
    assert np.array_equal(one["ym"], -other["ym"])
    assert np.array_equal(one["theta"], -other["theta"])


def test_a_run_mirrored_front_to_back_drives_in_the_other_direction(section4: Make) -> None:
    one, other = (
        simulate(
            section4(
                truth=mirrored_truth(side * 2.5, 2.5),
                start=Start(state=(side * -1.2, side * 0.3, -0.5, side * 0.6, 0.8)),
                switching=WITHIN,
                duration=5.0,
                **COARSE,
            )
        ).trajectory
        for side in (1.0, -1.0)
    )
    for name in ("x2", "u1", "tau2", "step"):
        assert np.array_equal(one[name], other[name])
    for name in ("x0", "x1", "u0", "tau1"):
        assert np.array_equal(one[name], -other[name])


@pytest.mark.parametrize("kappa", [0.5, 2.0])
def test_scaled_gains_give_the_same_run_in_scaled_time(section4: Make, kappa: float) -> None:
    """x1(κt), κx2(κt), κ²u1(κt), κ³τ2(κt) for l1κ, l2κ^(1/q1), l3κ^(1/(2q1−1))."""
    q = 9 / 11
    runs = []
    for k in (1.0, kappa):
        l = (2.0 * k, 4.2 * k ** (1 / q), 21.0 * k ** (1 / (2 * q - 1)))  # noqa: E741
        runs.append(
            simulate(
                section4(
                    "published",
                    bounds=Bounds(),
                    truth=Truth(),
                    start=Start(state=(0.0, 0.3, -0.5 * k, 1.0, 0.8 * k**2)),
                    gains=Gains(l=l),
                    switching=Switching(to_step3=100.0),
                    duration=1.5 / k,
                    control_period=2e-3 / k,
                    plant_step=1e-3 / k,
                )
            ).trajectory
        )
    one, scaled = runs
    for name, power in (("x1", 0), ("x2", 1), ("u1", 2), ("tau2", 3)):
        assert scaled[name] == pytest.approx(one[name] * kappa**power, rel=1e-6, abs=1e-9)


# --------------------------------------------------------------------------------------- the plant


def plant_of(kind: str, truth: Truth, bounds: Bounds, **start: object) -> Plant:
    return Plant(
        robot=kind,  # type: ignore[arg-type]  # a parameter of the test
        channels=(channel(0, truth, bounds), channel(1, truth, bounds)),
        scales=scales(truth, bounds),
        **start,  # type: ignore[arg-type]
    )


SMOOTH = Truth(
    alpha=(0.7, 1.3),
    gamma=(
        Sine(mean=1.5, amplitude=0.5, omega=3.0),
        Sine(mean=1.5, amplitude=0.5, omega=4.0, phase=1.0),
    ),
    disturbance=(Sine(amplitude=2.5, omega=5.0), Sine(amplitude=2.5, omega=3.0, phase=0.5)),
)
WAVES = Truth(
    alpha=(
        Sine(mean=1.0, amplitude=0.4, omega=3.0),
        Sine(mean=1.0, amplitude=0.3, omega=2.0, phase=2.0),
    ),
    gamma=SMOOTH.gamma,
    disturbance=SMOOTH.disturbance,
    b2=Sine(mean=1.0, amplitude=0.5, omega=4.0, phase=1.0),
)


@pytest.mark.parametrize("truth", [SMOOTH, WAVES])
@pytest.mark.parametrize(
    ("kind", "command"),
    [
        ("chained", Command(2, 1.0, -2.0)),
        ("chained", Command(0, 1.0, -2.0)),
        ("torque", Command(2, 0.0, 0.0, acceleration=1.0, turn_acceleration=-2.0)),
        ("velocity", Command(2, 0.0, 0.0, speed=1.0, turn_rate=-2.0)),
    ],
)
def test_integration_is_of_fourth_order_on_smooth_signals(
    bounds: Bounds, kind: str, command: Command, truth: Truth
) -> None:
    def end(steps: int) -> np.ndarray:
        plant = plant_of(kind, truth, bounds, pose=(0.1, -0.2, 0.4), velocity=(0.8, 0.3))
        plant.advance(command, 0.0, 1.0, steps)
        m = plant.measurement(1.0)
        return np.array([m.x0, m.x1, m.theta, m.v, m.omega])

    exact = end(512)
    errors = [float(np.abs(end(n) - exact).max()) for n in (8, 16, 32)]
    orders = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert all(3.7 < order < 4.6 for order in orders), orders


@pytest.mark.parametrize("turning", [False, True])
def test_b2_turns_the_heading_and_alpha_scales_the_path_as_they_vary(turning: bool) -> None:
    """With u0, u1 (or v, ω) kept there are integrals in closed form."""
    truth = Truth(
        alpha=(Sine(mean=1.0, amplitude=0.4, omega=3.0), 1.0),
        b2=Sine(mean=1.1, amplitude=0.5, omega=4.0),
    )
    pose, velocity = ((0.0, 0.0, 2.0), (0.0, 0.3)) if turning else ((0.0, 0.0, 0.0), (1.0, 0.3))
    plant = plant_of("chained", truth, Bounds(), pose=pose, velocity=velocity)
    plant.advance(Command(0 if turning else 2, 0.0, 0.0), 0.0, 1.5, 60)
    m = plant.measurement(1.5)
    angle = 0.3 * (1.1 * 1.5 + 0.5 * (1.0 - math.cos(6.0)) / 4.0)
    assert (m.theta if turning else m.x2) == pytest.approx(2.0 + angle if turning else angle)
    along = 0.0 if turning else 1.5 + 0.4 * (1.0 - math.cos(4.5)) / 3.0
    assert m.x0 == pytest.approx(along)
    assert m.omega == pytest.approx(0.3 if turning else 0.3 / (1.0 + angle**2))


@pytest.mark.parametrize("name", ["alpha", "b2"])
def test_gains_that_jump_are_integrated_in_smaller_steps(section4: Make, name: str) -> None:
    jumps = Square(mean=1.0, amplitude=0.2, omega=3.0)
    truth = Truth(b2=jumps) if name == "b2" else Truth(alpha=(1.0, jumps))
    known = Bounds(alpha=(0.8, 1.2), b2=(0.8, 1.2))
    assert plant_steps(section4(truth=truth, bounds=known, control_period=1e-2)) == 50


@pytest.mark.parametrize("truth", ["sines", "squares", "noise"])
@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
def test_settling_times_do_not_depend_on_the_plant_s_step(
    section4: Make, truth: str, discretisation: str
) -> None:
    settings = {
        "truth": truth,
        "discretisation": discretisation,
        "control_period": 5e-3,
        "duration": 6.0,
        "switching": Switching(tolerance=(2e-2, 2e-2, 2e-2)),
    }
    scenario = section4(**settings)
    step = 5e-3 / plant_steps(scenario)
    default, finer = simulate(scenario), simulate(section4(plant_step=step / 4, **settings))
    assert default.outcome is finer.outcome is Outcome.PARKED
    for name, end in default.settling_time.steps.items():
        assert end == pytest.approx(finer.settling_time.steps[name], abs=5.1e-3)


def test_square_waves_are_integrated_in_smaller_steps(section4: Make) -> None:
    assert plant_steps(section4(truth="sines", control_period=1e-2)) == 10
    assert plant_steps(section4(truth="squares", control_period=1e-2)) == 50
    assert plant_steps(section4(truth="squares", control_period=1e-2, plant_step=5e-3)) == 2
    assert plant_steps(section4(control_period=3.3e-4)) == 1


def test_error_of_a_jump_shrinks_with_the_step(bounds: Bounds, truths: dict[str, Truth]) -> None:
    """∫φ of a square wave over one period of it is 0; its jumps cost at most a step each."""

    def drift(steps: int) -> float:
        plant = plant_of(
            "chained",
            msgspec.structs.replace(truths["squares"], gamma=Truth().gamma),
            bounds,
            pose=(0.0, 0.0, 0.0),
            velocity=(0.0, 0.0),
        )
        plant.advance(Command(2, 0.0, 0.0), 0.0, 2.0 * math.pi / 3.0, steps)
        return abs(plant.measurement(0.0).u0)

    assert drift(100) <= 2.0 * 2.5 * 2.0 * math.pi / 300
    assert drift(1000) <= 2.0 * 2.5 * 2.0 * math.pi / 3000


def test_velocity_robot_drives_arcs_scaled_by_the_camera(bounds: Bounds) -> None:
    plant = plant_of(
        "velocity", Truth(alpha=(0.7, 1.3)), bounds, pose=(1.0, 2.0, 0.3), velocity=(0.0, 0.0)
    )
    plant.advance(Command(2, 0.0, 0.0, speed=0.8, turn_rate=-0.5), 0.0, 2.0, 20)
    m = plant.measurement(2.0)
    assert m.theta == pytest.approx(0.3 - 1.0)
    assert m.x0 == pytest.approx(1.0 + 0.7 * 0.8 / -0.5 * (math.sin(-0.7) - math.sin(0.3)))
    assert m.x1 == pytest.approx(2.0 - 1.3 * 0.8 / -0.5 * (math.cos(-0.7) - math.cos(0.3)))
    assert (m.v, m.omega) == (0.8, -0.5)


@pytest.mark.parametrize("kind", ["chained", "torque"])
def test_turning_robot_that_still_rolls_is_scaled_by_the_camera(bounds: Bounds, kind: str) -> None:
    plant = plant_of(kind, Truth(alpha=(0.7, 1.3)), bounds, pose=(0, 0, 2.0), velocity=(0.5, 0.0))
    plant.advance(Command(0, 0.0, 0.0, acceleration=0.0, turn_acceleration=0.0), 0.0, 2.0, 4)
    m = plant.measurement(2.0)
    assert (m.x0, m.x1) == pytest.approx((0.7 * math.cos(2.0), 1.3 * math.sin(2.0)))
    assert (m.theta, m.v, m.omega) == pytest.approx((2.0, 0.5, 0.0))


@pytest.mark.parametrize("kind", ["chained", "torque", "velocity"])
def test_start_turns_the_heading_in_the_image_whatever_the_camera_makes_of_it(kind: str) -> None:
    """Under ψ̇ = βω the robot's wheels start at ω/β, and keep it while nothing accelerates them."""
    mirrored = Homography((0.5, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0))
    plant = Plant(
        robot=kind,  # type: ignore[arg-type]  # a parameter of the test
        channels=(channel(0, Truth(), Bounds()), channel(1, Truth(), Bounds())),
        camera=mirrored.entries,
        pose=(1.0, 2.0, 2.0),
        velocity=(0.5, 0.3),
    )
    start = plant.measurement(0.0)
    floor = image_of(mirrored, Pose(1.0, 2.0, 2.0))
    assert (start.v, start.omega, start.beta) == pytest.approx((0.5, 0.3, 1.0 / floor.beta))
    assert start.beta < 0.0
    rate = 0.3 / start.beta
    coast = Command(0, 0.0, 0.0, 0.5, rate, acceleration=0.0, turn_acceleration=0.0)
    plant.advance(coast, 0.0, 0.4, 400)
    end = plant.measurement(0.4)
    if kind == "chained":
        assert end.theta == pytest.approx(2.0 + 0.4 * 0.3), "whose ω is that of the image"
    else:
        turned = image_of(mirrored, Pose(end.x0, end.x1, end.theta)).pose.theta - floor.pose.theta
        assert turned == pytest.approx(0.4 * rate)
    assert end.v == pytest.approx(0.5)


def test_velocity_robot_stands_still_drives_straight_and_turns_on_the_spot(bounds: Bounds) -> None:
    ends = []
    for v, omega in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
        plant = plant_of("velocity", Truth(), bounds, pose=(1.0, 2.0, 3.0), velocity=(0.4, 0.4))
        plant.advance(Command(2, 0.0, 0.0, speed=v, turn_rate=omega), 0.0, 1.0, 10)
        m = plant.measurement(1.0)
        ends.append((m.x0, m.x1, m.theta))
    assert ends[0] == (1.0, 2.0, 3.0)
    assert ends[1] == pytest.approx((1.0 + math.cos(3.0), 2.0 + math.sin(3.0), 3.0))
    assert ends[2] == pytest.approx((1.0, 2.0, 4.0 - 2.0 * math.pi))


@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 5), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)
)  # fmt: skip
def test_chained_plant_without_uncertainty_is_a_polynomial_in_time(
    state: tuple[float, float, float, float, float], tau1: float, tau2: float
) -> None:
    truth, h = Truth(alpha=(0.7, 1.3)), 0.4
    plant = plant_of(
        "chained",
        truth,
        Bounds(alpha=(0.5, 1.5)),
        pose=(0.0, 0.0, 0.0),
        velocity=(0.0, 0.0),
        chained=ChainedState(*state),
    )
    plant.advance(Command(2, tau1, tau2), 0.0, h, 1)
    x0, x1, x2, u0, u1 = state
    m = plant.measurement(h)
    # ẋ1 = α2 (x2 + u1 t + ½τ2 t²)(u0 + τ1 t)
    cubic = [
        x2 * u0,
        u1 * u0 + x2 * tau1,
        0.5 * tau2 * u0 + u1 * tau1,
        0.5 * tau1 * tau2,
    ]
    moved = sum(c * h ** (i + 1) / (i + 1) for i, c in enumerate(cubic))
    expected = (
        x0 + 0.7 * (u0 * h + 0.5 * tau1 * h**2),
        x1 + 1.3 * moved,
        x2 + u1 * h + 0.5 * tau2 * h**2,
        u0 + tau1 * h,
        u1 + tau2 * h,
    )
    assert (m.x0, m.x1, m.x2, m.u0, m.u1) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_adversary_takes_the_smallest_gain_and_opposes_the_input(bounds: Bounds) -> None:
    truth = Truth(gamma=(Adversary(),) * 2, disturbance=(Adversary(),) * 2)
    plant = plant_of("chained", truth, bounds, pose=(0.0, 0.0, 0.0), velocity=(0.0, 0.0))
    plant.advance(Command(2, 4.0, -3.0), 0.0, 1.0, 4)
    m = plant.measurement(1.0)
    assert (m.u0, m.u1) == pytest.approx((4.0 - 2.5, -3.0 + 2.5))


# ------------------------------------------------------------------------------------- the outcomes


OUTCOMES: dict[Outcome, tuple[str, dict[str, object]]] = {
    Outcome.PARKED: ("corrected", {}),
    Outcome.MISSED: ("published", {}),
    Outcome.STILL_MOVING: ("corrected", {"duration": 1.0}),
    Outcome.OUT_OF_VIEW: ("corrected", {"limits": Limits(view=(-0.5, 0.5, -0.5, 0.5))}),
    Outcome.LEFT_CHART: (
        "published",
        {
            "start": Start(state=(0.0, 0.3, 3.0, 5.6, 20.0)),
            "robot": Robot(kind="torque"),
            "truth": Truth(disturbance=(Constant(0.0), Constant(2.5))),
        },
    ),
    Outcome.INPUT_LIMIT: ("corrected", {"limits": Limits(tau=(50.0, 5.0))}),
    Outcome.SPEED_LIMIT: ("corrected", {"limits": Limits(speed=5.0)}),
    Outcome.DIVERGED: (
        "corrected",
        {"truth": Truth(disturbance=(Constant(1e7), Constant(0.0)), outside_bounds=True)},
    ),
}


@pytest.mark.parametrize("outcome", list(Outcome))
def test_every_outcome_is_reached_by_some_run(section4: Make, outcome: Outcome) -> None:
    law, changes = OUTCOMES[outcome]
    run = simulate(section4(law, **({"switching": WITHIN, "duration": 8.0, **COARSE} | changes)))
    assert run.outcome is outcome
    assert (run.settling_time.total is not None) == (outcome is Outcome.PARKED)
    ended_early = outcome not in (Outcome.PARKED, Outcome.MISSED, Outcome.STILL_MOVING)
    assert (run.ended < run.scenario.run.duration - 1e-9) == ended_early
    assert outcome.sentence.endswith(".")


def test_parked_means_within_hysteresis_times_tolerance_while_holding(section4: Make) -> None:
    """At 2 ms the explicit form chatters by some 5e-4 in x2."""
    for hysteresis, outcome in ((2.0, Outcome.MISSED), (20.0, Outcome.PARKED)):
        switching = Switching(tolerance=(1e-2, 1e-4, 1e-2), hysteresis=hysteresis)
        run = simulate(section4(switching=switching, duration=14.0, **COARSE))
        assert run.trajectory["step"][-1] == 4
        assert 2e-4 < run.metrics.residual < 2e-3
        assert run.outcome is outcome


def test_turn_rate_limit_ends_a_run(section4: Make) -> None:
    run = simulate(section4(limits=Limits(turn_rate=0.7), **COARSE))
    assert run.outcome is Outcome.SPEED_LIMIT
    assert abs(run.trajectory["omega"][-1]) > 0.7
    assert np.abs(run.trajectory["omega"][:-1]).max(initial=0.0) <= 0.7


def test_turn_rates_kept_and_limited_are_those_of_the_robot_s_wheels(section4: Make) -> None:
    """Under ψ̇ = βω with β = −2."""
    recorder = Recorder(section4(limits=Limits(turn_rate=0.5)))
    command = Command(1, 0.0, 0.0)
    turning = {
        omega: measured_pose(0.0, -1.0, 0.3, 0.2, omega=omega, beta=-2.0)
        for omega in (0.9, -0.9, 1.1, -1.1)
    }
    for measurement in turning.values():
        recorder.record(measurement, command)
    ended = {omega: recorder.end_after(command, m) for omega, m in turning.items()}
    limit = Outcome.SPEED_LIMIT
    assert ended == {0.9: None, -0.9: None, 1.1: limit, -1.1: limit}
    kept = recorder.finish(None, 0.0).trajectory["omega"]
    assert kept == pytest.approx([-0.45, 0.45, -0.55, 0.55])


@pytest.mark.parametrize(
    ("inside", "outside"),
    [
        ((-0.99, 0.0), (-1.01, 0.0)),
        ((1.99, 0.0), (2.01, 0.0)),
        ((0.0, -2.99), (0.0, -3.01)),
        ((0.0, 3.99), (0.0, 4.01)),
    ],
)
def test_view_can_be_left_through_each_of_its_sides(
    section4: Make, inside: tuple[float, float], outside: tuple[float, float]
) -> None:
    recorder = Recorder(section4(limits=Limits(view=(-1.0, 2.0, -3.0, 4.0))))
    within, beyond = (measured_pose(0.0, *place, 0.1) for place in (inside, outside))
    assert recorder.end_before(within, within) is None
    assert recorder.end_before(within, beyond) is None, "the truth counts, not what is measured"
    assert recorder.end_before(beyond, within) is Outcome.OUT_OF_VIEW


@pytest.mark.parametrize(
    ("held", "outcome"),
    [
        ((-0.029, -0.019, 0.019), Outcome.PARKED),
        ((0.031, 0.0, 0.0), Outcome.MISSED),
        ((0.0, -0.021, 0.0), Outcome.MISSED),
        ((0.0, 0.0, 0.021), Outcome.MISSED),
    ],
)
def test_each_of_the_pose_must_hold_for_a_run_to_be_parked(
    section4: Make, held: tuple[float, float, float], outcome: Outcome
) -> None:
    """Ever since holding began, and only since; here the limits are 0.03, 0.02 and 0.02."""
    tolerance = (1e-2, 1e-2, 1.5e-2)
    recorder = Recorder(section4(switching=Switching(tolerance=tolerance, hysteresis=2.0)))
    still = (0.0, 0.0, 0.0)
    for t, step, pose in ((0, 3, (0.1, 0.1, 0.1)), (1, 4, still), (2, 4, held), (9, 4, still)):
        x0, x1, x2 = pose
        m = measured_state(float(t), ChainedState(x0, x1, x2, 0.0, 0.0))
        recorder.record(m, Command(step, 0.0, 0.0))
    run = recorder.finish(None, 9.0)
    assert run.outcome is outcome
    assert run.settling_time.total == (1.0 if outcome is Outcome.PARKED else None)


FAR = 0.9e6


@pytest.mark.parametrize("law", ["published", "corrected"])
@pytest.mark.parametrize(
    "state",
    [
        (FAR, 0.0, 0.0, 0.0, 0.0),
        (0.0, -FAR, 0.0, 0.0, 0.0),
        (0.0, 0.0, FAR, 0.0, 0.0),
        (0.0, 0.1, 0.0, FAR, 0.0),
        (0.0, 0.0, 0.0, 0.0, FAR),
    ],
)
def test_a_run_from_any_start_that_is_accepted_ends_with_an_outcome(
    section4: Make, law: str, state: tuple[float, float, float, float, float]
) -> None:
    run = simulate(section4(law, start=Start(state=state), duration=0.1, **COARSE))
    assert len(run.trajectory["t"]) >= 1
    assert run.outcome in (Outcome.DIVERGED, Outcome.STILL_MOVING)


@pytest.mark.parametrize("state", [(2e6, 0, 0, 0, 0), (0, 0, -2e6, 0, 0), (0, 0, 1e4, 1e4, 0)])
def test_a_start_that_would_end_the_run_at_once_is_refused(
    section4: Make, state: tuple[float, float, float, float, float]
) -> None:
    with pytest.raises(InputError, match="below 1e"):
        section4(start=Start(state=state))


@pytest.mark.parametrize("kind", ["chained", "torque", "velocity"])
def test_saturation_clips_what_the_robot_is_given(section4: Make, kind: str) -> None:
    """u0 and u1 change no faster than the limit, whatever the robot is commanded by."""
    limits = Limits(tau=(0.8, 0.6), saturate=True)
    run = simulate(
        section4(
            bounds=Bounds(),
            truth=Truth(),
            start=Start(state=(-1.0, 0.3, 0.2, 0.0, 0.0)),
            robot=Robot(kind=kind),  # type: ignore[arg-type]  # a parameter of the test
            limits=limits,
            duration=1.0,
            **COARSE,
        )
    )
    assert run.outcome is Outcome.STILL_MOVING
    assert run.metrics.peak_tau == [0.8, 0.6]
    # the torque robot holds an acceleration, not u̇, over a period: hence the slack
    for name, limit in (("u0", 0.8), ("u1", 0.6)):
        rates = np.abs(np.diff(run.trajectory[name])) / 2e-3
        assert rates.max() <= limit * 1.05


def test_a_saturated_run_goes_on_where_a_limited_one_ends(section4: Make) -> None:
    settings = {"duration": 6.0, "switching": WITHIN, **COARSE}
    ended = simulate(section4(limits=Limits(tau=(20.0, 20.0)), **settings))
    clipped = simulate(section4(limits=Limits(tau=(20.0, 20.0), saturate=True), **settings))
    assert ended.outcome is Outcome.INPUT_LIMIT
    assert abs(ended.trajectory["tau2"][-1]) > 20.0
    assert clipped.ended == 6.0
    assert max(clipped.metrics.peak_tau) == 20.0


@pytest.mark.parametrize("period", [0.013, 0.019])
def test_a_run_may_end_with_the_sample_at_which_it_settles(period: float) -> None:
    """The end of a step, rounded for display, may lie after the last sample."""
    settled = None
    for x in np.arange(-1.0, -2.0, -0.02):
        start, switching = Start(pose=(float(x), 0.1, 0.0)), Switching(tolerance=(0.01, 0.02, 0.05))
        coarse = {"control_period": period, "plant_step": 0.02}
        make = {"law": "corrected", "start": start, "switching": switching}
        whole = simulate(scenario_of(make, duration=9.0, **coarse))
        total = whole.settling_time.total
        if total is not None and round(total / period) * period < total:
            settled = simulate(scenario_of(make, duration=total, **coarse))
            break
    assert settled is not None
    assert settled.trajectory["step"][-1] == 4
    assert settled.outcome is Outcome.PARKED


def scenario_of(parts: dict[str, object], **run: float) -> Scenario:
    return msgspec.convert({**msgspec.to_builtins(parts), "run": run}, Scenario)


# -------------------------------------------------------------------------- trajectory and metrics


def test_trajectory_has_a_row_a_sample_and_agrees_with_itself(section4: Make) -> None:
    run = simulate(section4(duration=3.0, **COARSE))
    columns = run.trajectory
    assert tuple(columns) == COLUMNS
    assert {len(column) for column in columns.values()} == {1501}
    assert columns["t"] == pytest.approx(np.arange(1501) * 2e-3)
    assert columns["x2"] == pytest.approx(np.tan(columns["theta"]))
    assert columns["u0"] == pytest.approx(columns["v"] * np.cos(columns["theta"]))
    assert columns["u1"] == pytest.approx(columns["omega"] / np.cos(columns["theta"]) ** 2)
    assert np.array_equal(columns["x0"], columns["xm"])
    assert np.array_equal(columns["x1"], columns["ym"])
    assert [columns[name][0] for name in STATES] == [-0.2, 0.3, -0.5, 5.6, 0.8]


def test_progress_is_told_from_0_to_1(section4: Make) -> None:
    told: list[float] = []
    simulate(section4(duration=1.0, **COARSE), progress=told.append)
    assert told == sorted(told)
    assert told[0] == 0.0
    assert told[-1] == 1.0
    assert len(told) <= 251


def hand_made() -> dict[str, np.ndarray]:
    t = np.arange(0.0, 5.0)  # five samples a second apart: the last three lie within 2 s
    zero = np.zeros(5)
    return {
        "t": t,
        "x0": np.array([9.0, 5.0, -0.3, 0.2, 0.1]),
        "x1": np.array([3.0, 4.0, 0.0, 0.0, -0.4]),
        "x2": np.array([np.nan, 2.0, 0.1, 0.1, 0.1]),
        "u0": np.array([np.nan, -7.0, 6.0, 0.0, 0.0]),
        "u1": zero,
        "v": np.array([1.0, -8.0, 6.0, 0.0, 0.0]),
        "omega": np.array([0.0, 0.0, -3.0, 0.0, 0.0]),
        "tau1": np.array([0.0, 3.0, -4.0, 0.0, 0.0]),
        "tau2": np.array([1.0, 1.0, 1.0, 1.0, 3.0]),
        "xm": np.array([0.0, 3.0, 3.0, 0.0, 0.0]),
        "ym": np.array([0.0, 4.0, 0.0, 0.0, 0.0]),
        "theta": np.radians([100.0, -60.0, 5.0, 5.0, 5.0]),
        "step": np.array([0, 1, 2, 3, 4]),
    }


def test_metrics_of_a_trajectory_made_by_hand() -> None:
    m = metrics_of(hand_made(), end_of_step2=3.0)
    assert m.residual == 0.4
    assert m.residual_by_state == {"x0": 0.3, "x1": 0.4, "x2": 0.1, "u0": 6.0, "u1": 0.0}
    assert m.peak_tau == [4.0, 3.0]
    assert m.rms_tau == pytest.approx([math.sqrt(25.0 / 5.0), math.sqrt(13.0 / 5.0)])
    assert m.total_variation_tau == pytest.approx([(3.0 + 7.0 + 4.0) / 4.0, 2.0 / 4.0])
    assert m.excursion == 5.0
    assert m.path_length == 5.0 + 4.0 + 3.0
    assert m.least_distance_to_90_deg == pytest.approx(-10.0)
    assert (m.max_speed, m.max_turn_rate) == (8.0, 3.0)
    assert m.x0_range == [-0.3, 9.0]
    assert m.max_abs == {"x0": 9.0, "x1": 4.0, "x2": 2.0, "u0": 7.0, "u1": 0.0}
    assert m.max_abs_after_step2 == {"x0": 0.2, "x1": 0.4, "x2": 0.1, "u0": 0.0, "u1": 0.0}
    assert m.final == {"x0": 0.1, "x1": -0.4, "x2": 0.1, "u0": 0.0, "u1": 0.0}


def test_metrics_of_a_single_sample_and_of_a_run_that_never_ended_step_2() -> None:
    single = {name: column[-1:] for name, column in hand_made().items()}
    m = metrics_of(single, end_of_step2=None)
    assert m.total_variation_tau == [0.0, 0.0]
    assert m.path_length == 0.0
    assert m.max_abs_after_step2 is None


def test_metrics_of_a_run_count_from_the_first_end_of_step_2(section4: Make) -> None:
    run = simulate(section4("published", switching=WITHIN, duration=8.0, **COARSE))
    end = run.settling_time.steps["2"]
    assert end is not None
    later = run.trajectory["t"] >= end - 1e-6
    expected = {name: float(np.abs(run.trajectory[name][later]).max()) for name in STATES}
    assert run.metrics.max_abs_after_step2 == expected
