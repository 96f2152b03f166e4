"""The homogeneous law: V, its input, its form in sampled time, and runs of it."""

import itertools
import math
import tomllib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws import homogeneous_parameters
from parkproof.laws.controller import Controller, measured_state
from parkproof.laws.corrected import corrected_channels
from parkproof.laws.ellipsoid import checked_ellipsoid, lowest_level, widest
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.homogeneous import homogeneous_channels, homogeneous_direct, level_at
from parkproof.laws.inputs import with_direct
from parkproof.laws.parameters import LawParameters, law_parameters
from parkproof.model.chained import ChainedState
from parkproof.model.truth import Truth
from parkproof.proof.checker.ellipsoid import Ellipsoid
from parkproof.proof.homogeneous_rate import proven_rate
from parkproof.results import notes_of
from parkproof.scenario import Scenario, Start
from parkproof.scenario_file import read_gains_file, scenario_from_dict, template
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import simulate

Make = Callable[..., Scenario]
PAPER = Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5)
DESIGNED = {
    20: (
        (0.074812464, 0.066401839, 0.025390644, 0.079551713, 0.031872429, 0.018868936),
        (-3.8494493, -5.1332745, -2.6799631),
    ),
    60: (
        (0.27077674, 0.13250589, 0.028728403, 0.083847895, 0.018974066, 0.0059128762),
        (-22.295422, -15.815416, -4.5252076),
    ),
}
GAINS = {limit: Gains(ellipsoid=P, feedback=k) for limit, (P, k) in DESIGNED.items()}
H = np.diag([3.0, 2.0, 1.0])


def matrix_of(numbers: tuple[float, ...]) -> np.ndarray:
    a, b, c, d, e, f = numbers
    return np.array([[a, b, c], [b, d, e], [c, e, f]])


def parameters(gains: Gains, period: float = 1e-9, *, implicit: bool = False) -> LawParameters:
    return law_parameters(
        bounds=PAPER,
        gains=gains,
        switching=Switching(),
        control_period=period,
        discretisation="implicit" if implicit else "explicit",
    )


def states_at(P: np.ndarray, levels: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Random states with V as given: x = D(V)z for z on the ellipsoid."""
    y = rng.normal(size=(levels.size, 3))
    z = (y / np.linalg.norm(y, axis=1)[:, None]) @ np.linalg.inv(np.linalg.cholesky(P))
    return z * levels[:, None] ** np.array([3.0, 2.0, 1.0])


# ------------------------------------------------------------------------------------------- V


@pytest.mark.parametrize("limit", DESIGNED)
def test_the_level_solves_its_equation_from_1e_6_to_1e_3(limit: int) -> None:
    rng = np.random.default_rng(limit)
    levels = 10.0 ** rng.uniform(-6.0, 3.0, 4000)
    p = parameters(GAINS[limit])
    states = states_at(matrix_of(DESIGNED[limit][0]), levels, rng)
    found = [level_at(*map(float, state), p) for state in states]
    assert np.max(np.abs(found / levels - 1.0)) < 1e-12


def test_the_level_is_found_for_every_admissible_form_however_badly_conditioned() -> None:
    rng = np.random.default_rng(7)
    tried = 0
    while tried < 40:
        half = rng.normal(size=(3, 3))
        P = half @ half.T
        if np.linalg.eigvalsh(H @ P + P @ H)[0] < 1e-3 * np.linalg.eigvalsh(P)[0]:
            continue
        tried += 1
        numbers = tuple(float(P[i, j]) for i in range(3) for j in range(i, 3))
        p = parameters(Gains(ellipsoid=numbers, feedback=(-1.0, -1.0, -1.0)))  # type: ignore[arg-type]
        levels = 10.0 ** rng.uniform(-3.0, 3.0, 300)
        found = [level_at(*map(float, x), p) for x in states_at(P, levels, rng)]
        assert np.max(np.abs(found / levels - 1.0)) < 1e-4


def test_the_level_never_falls_below_its_floor_and_is_it_at_the_goal() -> None:
    p = parameters(GAINS[20], 0.01)
    assert level_at(0.0, 0.0, 0.0, p) == p.level_min
    for size in (1e-300, 1e-30, 1e-9, 1e-4):
        assert level_at(size**3, -(size**2), size, p) == p.level_min
    rng = np.random.default_rng(8)
    levels = p.level_min * 10.0 ** rng.uniform(-1.0, 1.0, 500)
    states = states_at(matrix_of(DESIGNED[20][0]), levels, rng)
    found = [level_at(*map(float, state), p) for state in states]
    assert found == pytest.approx(np.maximum(levels, p.level_min))


def test_what_one_state_alone_says_of_the_level_encloses_it() -> None:
    """The bracket in which the level is looked for."""
    for numbers, _ in DESIGNED.values():
        P = matrix_of(numbers)
        z = states_at(P, np.ones(100_000), np.random.default_rng(9))
        alone = np.max(
            (np.sqrt(np.diag(P)) * np.abs(z)) ** np.array([1.0 / 3.0, 1.0 / 2.0, 1.0]), axis=1
        )
        assert alone.min() > 1.0 / 3.0
        assert alone.max() < widest(numbers)


# --------------------------------------------------------------------------------- the law itself


@pytest.mark.parametrize("limit", DESIGNED)
def test_the_input_never_exceeds_what_it_was_designed_for_and_comes_near(limit: int) -> None:
    rng = np.random.default_rng(limit)
    for period in (1e-9, 1e-2):
        p = parameters(GAINS[limit], period)
        levels = 10.0 ** rng.uniform(-4.0, 2.0, 5000)
        states = states_at(matrix_of(DESIGNED[limit][0]), levels, rng)
        inputs = [abs(homogeneous_direct(2.0, 1.0, *map(float, x), p)) for x in states]
        assert 0.98 * limit < max(inputs) <= limit


@given(
    st.tuples(*[st.floats(-10.0, 10.0)] * 3),
    st.floats(0.1, 10.0),
    st.sampled_from([1.0, -1.0]),
)
def test_the_input_is_homogeneous_of_degree_0_odd_and_turns_with_the_direction(
    state: tuple[float, float, float], scale: float, way: float
) -> None:
    p = parameters(GAINS[20])
    x1, x2, u1 = state
    if max(abs(x1), abs(x2), abs(u1)) < 1e-3:
        return
    tau = homogeneous_direct(2.0, way, x1, x2, u1, p)
    scaled = (scale**3 * x1, scale**2 * x2, scale * u1)
    assert homogeneous_direct(2.0, way, *scaled, p) == pytest.approx(tau, rel=1e-7, abs=1e-7)
    assert homogeneous_direct(2.0, way, -x1, -x2, -u1, p) == pytest.approx(-tau)
    assert homogeneous_direct(2.0, -way, -x1, x2, u1, p) == tau


def test_only_step_2_differs_from_the_corrected_law_without_steering() -> None:
    p = parameters(GAINS[20])
    unsteered = parameters(replace(GAINS[20], return_steering=False))
    for step, way in itertools.product((1.0, 3.0, 4.0), (1.0, -1.0)):
        state = (-1.0, 0.004, 0.2, 0.5)
        expected = corrected_channels(step, way, *state, unsteered)
        assert homogeneous_channels(step, way, *state, p) == expected
        assert homogeneous_direct(step, way, 0.3, 0.2, 0.1, p) == 0.0
    first, second = homogeneous_channels(2.0, -1.0, -1.0, 0.3, 0.2, 0.5, p)
    assert first == corrected_channels(2.0, -1.0, -1.0, 0.3, 0.2, 0.5, unsteered)[0]
    assert second[0] == 0.0


def test_a_given_saturation_clips_the_input() -> None:
    p = homogeneous_parameters()._replace(tau_max2=3.0)
    assert [with_direct(0.0, tau, p) for tau in (-9.0, 2.0, 9.0)] == [-3.0, 2.0, 3.0]


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
def test_a_controller_is_at_the_predicted_state_in_the_implicit_form_only(
    discretisation: Any,
) -> None:
    h = 0.02
    controller = Controller(
        law="homogeneous",
        bounds=PAPER,
        gains=GAINS[20],
        switching=Switching(tolerance=(9.0, 1e-3, 1e-3)),
        control_period=h,
        discretisation=discretisation,
    )
    _, x1, x2, u0, u1 = state = ChainedState(-1.0, 0.5, -0.4, 1.0, 0.7)
    commands = [controller.step(measured_state(h * k, state)) for k in range(2)]
    ahead = h if discretisation == "implicit" else 0.0
    end = x2 + ahead * u1
    tau = homogeneous_direct(2.0, 1.0, x1 + ahead * u0 * end, end, u1, controller.parameters)
    assert [command.step for command in commands] == [1, 2]
    assert commands[1].tau2 == pytest.approx(tau)


# ---------------------------------------------------------------------------------- sampled time


@pytest.mark.parametrize("limit", DESIGNED)
@pytest.mark.parametrize("implicit", [False, True])
def test_below_the_floor_the_sampled_loop_is_stable_at_every_corner_of_the_bounds(
    limit: int, implicit: bool
) -> None:
    """Eigenvalues of the loop from sample to sample; u1 alone never changes its sign."""
    h = 0.01
    p = parameters(GAINS[limit], h, implicit=implicit)
    v = p.level_min
    k = np.array([p.feedback1 / v**3, p.feedback2 / v**2, p.feedback3 / v])
    for b1, gamma in itertools.product((0.5, 1.5), (1.0, 2.0)):
        rows = []
        for x1, x2, u1 in np.eye(3):
            end = x2 + p.lookahead * u1
            tau = gamma * float(k @ [x1 + p.lookahead * end, end, u1])
            mid = x1 + b1 * (h * x2 + h**2 * u1 / 2.0 + h**3 * tau / 6.0)
            rows.append([mid, x2 + h * u1 + h**2 * tau / 2.0, u1 + h * tau])
        loop = np.array(rows).T
        assert np.max(np.abs(np.linalg.eigvals(loop))) < 0.99
        own = 1.0 + h * gamma * (k[2] + p.lookahead * k[1])
        assert -1e-12 <= own < 1.0


def test_the_floor_grows_with_period_gain_and_lookahead() -> None:
    k = (-3.0, -8.0, -4.0)
    assert lowest_level(k, 2.0, 0.01, 0.0) == pytest.approx(0.08)
    assert lowest_level(k, 2.0, 0.02, 0.0) == pytest.approx(0.16)
    assert lowest_level(k, 2.0, 0.01, 0.01) == pytest.approx(0.1)


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("name", ["sines", "adversary", "noise", "squares", "constant"])
def test_runs_park_within_the_input_that_was_designed_for(
    section4: Make, truths: dict[str, Truth], name: str, discretisation: str
) -> None:
    for alpha in ((0.5, 1.5), (1.5, 0.5)):
        scenario = section4(
            "homogeneous",
            gains=GAINS[20],
            truth=replace(truths[name], alpha=alpha),
            start=Start(pose=(-0.8, 0.4, -0.3)),
            discretisation=discretisation,
            duration=16.0,
            control_period=2e-3,
        )
        run = simulate(scenario)
        assert run.outcome is Outcome.PARKED
        approach = run.trajectory["step"] == 2
        assert approach.any()
        assert np.max(np.abs(run.trajectory["tau2"][approach])) <= 20.0


def test_the_implicit_form_does_not_chatter(section4: Make) -> None:
    """While Step 2 goes on at the goal, as its end is a time."""
    variation = {}
    for discretisation in ("explicit", "implicit"):
        run = simulate(
            section4(
                "homogeneous",
                gains=GAINS[20],
                start=Start(state=(0.0, 0.3, -0.5, 1.0, 0.8)),
                switching=Switching(to_step3=8.0, tolerance=(0.02, 0.05, 0.05)),
                discretisation=discretisation,
                duration=7.0,
                control_period=2e-3,
            )
        )
        late = run.trajectory["t"] > 5.0
        assert (run.trajectory["step"][late] == 2).all()
        for state in ("x1", "x2", "u1"):
            assert np.max(np.abs(run.trajectory[state][late])) < 0.02
        variation[discretisation] = float(np.abs(np.diff(run.trajectory["tau2"][late])).sum()) / 2.0
    # sines of 2.5 and γ between 1 and 2 alone ask for a variation of a few per second
    assert max(variation.values()) < 8.0


def test_step_2_ends_within_the_proven_time(section4: Make, truths: dict[str, Truth]) -> None:
    P, k = DESIGNED[20]
    proved = proven_rate(P, k, b1=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5)
    assert proved is not None
    x = (0.64, 1.7, 3.01)
    level = float(Ellipsoid(P, k).level([(value, value) for value in x]))
    for name, alpha2 in itertools.product(("adversary", "squares", "constant"), (0.5, 1.5)):
        run = simulate(
            section4(
                "homogeneous",
                gains=replace(GAINS[20], direction="forward"),
                truth=replace(truths[name], alpha=(1.0, alpha2)),
                start=Start(state=(0.0, *x[:2], 1.0, x[2])),
                duration=9.0,
            )
        )
        steps = run.settling_time.steps
        assert steps["2"] is not None
        assert steps["2"] <= level / proved[0] < 8.1


# ------------------------------------------------------------------------------ files and refusals


@pytest.mark.parametrize(
    ("P", "message"),
    [
        ((1.0, 2.0, 0.0, 1.0, 0.0, 1.0), "matrix P is not positive definite"),
        ((1.0, 0.99, 0.98, 1.0, 0.995, 1.0), r"matrix HP \+ PH .* is not positive definite"),
        ((math.nan, 0.0, 0.0, 1.0, 0.0, 1.0), "ellipsoid"),
    ],
)
def test_a_form_that_defines_no_level_is_refused(P: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Gains(ellipsoid=P, feedback=(-1.0, -1.0, -1.0))


def test_definiteness_is_judged_like_the_eigenvalues() -> None:
    rng = np.random.default_rng(11)
    seen = set()
    for _ in range(300):
        half = rng.normal(size=(3, 3))
        P = half @ half.T + rng.uniform(-0.3, 0.3) * np.eye(3)
        sound = min(np.linalg.eigvalsh(P)[0], np.linalg.eigvalsh(H @ P + P @ H)[0]) > 0.0
        numbers = [float(P[i, j]) for i in range(3) for j in range(i, 3)]
        seen.add(sound)
        if sound:
            assert list(checked_ellipsoid(numbers)) == numbers
        else:
            with pytest.raises(InputError):
                checked_ellipsoid(numbers)
    assert seen == {True, False}


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"ellipsoid": DESIGNED[20][0]}, "belong together"),
        ({"feedback": DESIGNED[20][1]}, "belong together"),
        ({"ellipsoid": DESIGNED[20][0], "feedback": (-1.0, -1.0, 1.0)}, "feedback"),
    ],
)
def test_gains_that_do_not_fit_together_are_refused(gains: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Gains(**gains)


def test_the_law_is_refused_without_its_gains_and_with_those_of_a_steering(
    section4: Make, tmp_path: Any
) -> None:
    with pytest.raises(InputError, match=r"needs ellipsoid = .* and feedback ="):
        section4("homogeneous")
    with pytest.raises(InputError, match="needs ellipsoid"):
        Controller(law="homogeneous", bounds=PAPER, control_period=0.01)
    with pytest.raises(InputError, match="never steers in Step 3"):
        section4("homogeneous", gains=replace(GAINS[20], steering_speeds=(0.1, 1.0)))
    path = tmp_path / "gains.toml"
    path.write_text('law = "homogeneous"\n[bounds]\nalpha = [0.5, 1.5]\n[gains]\nq1 = "9/11"\n')
    with pytest.raises(InputError, match="needs ellipsoid"):
        read_gains_file(path)


def test_a_tolerance_below_what_the_floor_allows_is_noted(section4: Make) -> None:
    for period, noted in ((1e-3, False), (0.01, True)):
        scenario = section4("homogeneous", gains=GAINS[20], control_period=period)
        step2 = [note for note in notes_of(scenario) if "tolerance[1]" in note]
        assert bool(step2) == noted
    assert "below the band 0.05" in step2[0]


def test_the_gains_of_the_template_are_proved_as_its_comment_says() -> None:
    scenario = scenario_from_dict(tomllib.loads(template("homogeneous")), where="homogeneous")
    P, k = scenario.gains.ellipsoid, scenario.gains.feedback
    assert P is not None
    assert k is not None
    proof = Ellipsoid(P, k)
    proved = proven_rate(P, k, b1=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5)
    assert proved is not None
    level = proof.level([(1.0, 1.0), (0.0, 0.0), (0.0, 0.0)])
    assert float(level) / proved[0] <= 8.1
    assert proof.input_bound() <= 20
    assert scenario.limits == Limits()
