"""Compiled lanes against the plain reference, and the accuracy of their primitives."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numba
import numpy as np
import pytest

from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.model.signals import Adversary, Constant, Noise, Sine
from parkproof.model.truth import Truth
from parkproof.scalar import sine, spow, spow_begun, spow_ended, spows_begun
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.simulation.compiler import OPTIONS, register
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import Run, simulate

Make = Callable[..., Scenario]
COARSE = {"control_period": 2e-3, "plant_step": 2e-3}
HEADINGS = (0.1, 1.45, 2.0, -3.1)
TRUTHS = ("sines", "adversary", "noise", "squares")
HOMOGENEOUS = Gains(
    ellipsoid=(0.074812464, 0.066401839, 0.025390644, 0.079551713, 0.031872429, 0.018868936),
    feedback=(-3.8494493, -5.1332745, -2.6799631),
)

register()


@numba.njit(**OPTIONS)  # type: ignore[untyped-decorator]
def compiled_power(x: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
    for i in range(x.size):
        out[i] = spow(x[i], p[i])


@numba.njit(**OPTIONS)  # type: ignore[untyped-decorator]
def compiled_sine(x: np.ndarray, out: np.ndarray) -> None:
    for i in range(x.size):
        out[i] = sine(x[i])


def powers(x: Any, p: Any) -> np.ndarray:
    x, p = np.broadcast_arrays(np.asarray(x, float), np.asarray(p, float))
    out = np.empty(x.shape)
    compiled_power(np.ascontiguousarray(x), np.ascontiguousarray(p), out)
    return out


def sines_of(x: np.ndarray) -> np.ndarray:
    out = np.empty(x.shape)
    compiled_sine(x, out)
    return out


# -------------------------------------------------------------------------------------- primitives


def test_polynomial_power_agrees_with_the_library_to_2e_14() -> None:
    rng = np.random.default_rng(1)
    n = 400_000
    x = 10.0 ** rng.uniform(-12.0, 6.0, n) * rng.choice([-1.0, 1.0], n)
    p = rng.uniform(0.0, 3.0, n)
    p[p == 0.0] = 3.0
    exact = np.copysign(np.abs(x) ** p, x)
    assert np.max(np.abs(powers(x, p) / exact - 1.0)) < 2e-14


def test_polynomial_power_of_special_numbers() -> None:
    assert powers([1.0, -1.0, 4.0, -8.0], [0.37, 2.2, 0.5, 1.0]) == pytest.approx(
        [1.0, -1.0, 2.0, -8.0], rel=1e-15
    )
    for p in (1e-3, 1 / 3, 1.0, 3.0):
        assert not powers([0.0, -0.0, 5e-324, -1e-310], p).any()
        assert powers([2.3e-308, -2.3e-308], p) == pytest.approx(
            [spow(2.3e-308, p), spow(-2.3e-308, p)], rel=1e-12, abs=1e-300
        )


@pytest.mark.parametrize("p", [0.2, 1.0, 11 / 7])
def test_the_halves_of_a_power_make_the_power(p: float) -> None:
    """In loops of their own, as lanes go through them, and in plain Python."""

    @numba.njit(**OPTIONS)  # type: ignore[untyped-decorator]
    def in_two_loops(x: np.ndarray, begun: np.ndarray, out: np.ndarray) -> None:
        for i in range(x.size):
            begun[i] = spow_begun(x[i], p)
        for i in range(x.size):
            out[i] = spow_ended(begun[i], x[i], p)

    rng = np.random.default_rng(3)
    x = np.array([0.0, -1e-310, *(10.0 ** rng.uniform(-12.0, 6.0, 300) * rng.choice([-1, 1], 300))])
    out = np.empty(x.size)
    in_two_loops(x, np.empty(x.size), out)
    assert out.tolist() == powers(x, p).tolist()
    assert not out[:2].any()
    assert out[2:] == pytest.approx([spow(number, p) for number in x[2:]], rel=2e-14, abs=0.0)
    for number in (*x.tolist(), 1e150, math.inf):
        assert spow_ended(spow_begun(number, p), number, p) == spow(number, p)


def test_two_powers_that_share_a_division_are_as_exact_whatever_the_other_is() -> None:
    @numba.njit(**OPTIONS)  # type: ignore[untyped-decorator]
    def pairs(x: np.ndarray, p: np.ndarray, other: np.ndarray, out: np.ndarray) -> None:
        for i in range(x.size):
            first, _ = spows_begun(x[i], p[i], other[i], 0.5)
            _, second = spows_begun(other[i], 0.5, x[i], p[i])
            out[0, i], out[1, i] = spow_ended(first, x[i], p[i]), spow_ended(second, x[i], p[i])

    rng = np.random.default_rng(9)
    n = 60_000
    p, out = rng.uniform(1e-3, 1.0, n), np.empty((2, n))
    unusual = [0.0, -0.0, 5e-324, -1e-310, 1e300, math.inf, -math.inf, math.nan]
    for least, error in ((-12.0, 2e-14), (-300.0, 2e-13)):
        x = 10.0 ** rng.uniform(least, 6.0, n) * rng.choice([-1.0, 1.0], n)
        exact = np.copysign(np.abs(x) ** p, x)
        for other in (rng.normal(size=n), rng.choice(unusual, n)):
            pairs(x, p, other, out)
            assert np.max(np.abs(out / exact - 1.0)) < error


def test_a_power_of_1_is_its_base_whatever_was_begun() -> None:
    @numba.njit(**OPTIONS)  # type: ignore[untyped-decorator]
    def ended(begun: float, x: float) -> float:
        return spow_ended(begun, x, 1.0)  # type: ignore[no-any-return]

    for x in (-1.7e308, -0.3, 1e-200, 5.0):
        assert [ended(begun, x) for begun in (0.0, 5e3, -math.inf)] == [x, x, x]


def test_powers_of_tiny_numbers_keep_twelve_digits() -> None:
    rng = np.random.default_rng(5)
    x = 10.0 ** rng.uniform(-300.0, -12.0, 20_000) * rng.choice([-1.0, 1.0], 20_000)
    p = rng.uniform(0.05, 1.0, x.size)
    exact = np.copysign(np.abs(x) ** p, x)
    assert np.max(np.abs(powers(x, p) / exact - 1.0)) < 2e-13


def test_powers_beyond_all_doubles_stay_huge_or_tiny_and_keep_their_sign() -> None:
    huge, tiny = powers([1e300, -1e300], 3.0), powers([1e-300, -1e-300], 3.0)
    assert (huge[0] > 1e307, huge[1] < -1e307) == (True, True)
    assert (0.0 < tiny[0] < 1e-307, -1e-307 < tiny[1] < 0.0) == (True, True)


def test_polynomial_sine_agrees_with_the_library_to_1e_15() -> None:
    rng = np.random.default_rng(2)
    multiples = np.arange(-30_000, 30_001) * math.pi
    x = np.concatenate(
        [rng.uniform(-1e5, 1e5, 300_000), rng.uniform(-4.0, 4.0, 100_000), multiples,
         multiples + 0.5 * math.pi]
    )  # fmt: skip
    x = x[np.abs(x) < 1e5]
    assert np.max(np.abs(sines_of(x) - np.sin(x))) < 1e-15


def test_polynomial_sine_of_special_numbers() -> None:
    x = np.array([0.0, -0.0, 5e-324, -1e-310, 1e-8])
    assert np.array_equal(sines_of(x), np.sin(x))
    y = np.linspace(-50.0, 50.0, 1001)
    assert np.array_equal(sines_of(-y), -sines_of(y))


# ---------------------------------------------------------------------- against the plain reference


def trials(section4: Make, truths: dict[str, Truth], law: str, **run: Any) -> list[Scenario]:
    """Starts in the chart and, for laws that turn, outside it, each under four truths."""
    starts = [
        Start(state=(-0.2, 0.3, -0.5, 5.6, 0.8)),
        Start(pose=(1.5, -0.4, -0.7), velocity=(-0.3, 0.2)),
        *(Start(pose=(-1.0, 0.5, a), velocity=(0.5, 0.1)) for a in HEADINGS if law != "published"),
    ]
    corners = ((0.5, 1.5), (1.5, 0.5), (0.7, 1.3), (1.0, 1.0))
    return [
        section4(
            law,
            gains=HOMOGENEOUS if law == "homogeneous" else Gains(),
            start=start,
            truth=msgspec.structs.replace(truths[name], alpha=alpha),
            **(COARSE | run),
        )
        for start in starts
        for name, alpha in zip(TRUTHS, corners, strict=True)
    ]


def values_of(run: Run) -> dict[str, float | None]:
    """A reference run in the names of an ensemble's results."""
    m, ends = run.metrics, run.settling_time.steps
    return {
        "total": run.settling_time.total,
        **{f"end{i}": ends.get(str(i)) for i in range(4)},
        "returns": run.returns,
        "residual": m.residual,
        **{f"peak_tau{i + 1}": m.peak_tau[i] for i in range(2)},
        **{f"rms_tau{i + 1}": m.rms_tau[i] for i in range(2)},
        **{f"total_variation_tau{i + 1}": m.total_variation_tau[i] for i in range(2)},
        "excursion": m.excursion,
        "path_length": m.path_length,
        "ended": run.ended,
        **{f"max_{name}": value for name, value in m.max_abs.items()},
        "max_speed": m.max_speed,
        "max_turn_rate": m.max_turn_rate,
        "max_heading": math.radians(90.0 - m.least_distance_to_90_deg),
        "least_x0": m.x0_range[0],
        "largest_x0": m.x0_range[1],
        **m.final,
    }


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("law", ["published", "corrected", "homogeneous"])
def test_short_lanes_are_the_reference_pointwise(
    section4: Make, truths: dict[str, Truth], law: str, discretisation: str
) -> None:
    given = [
        scenario
        for scenario in trials(section4, truths, law, duration=0.3, discretisation=discretisation)
        if scenario.truth.gamma != truths["squares"].gamma
    ]
    lanes = simulate_ensemble(given)
    for i, scenario in enumerate(given):
        run = simulate(scenario)
        assert lanes["outcome"][i] is run.outcome
        turning = run.trajectory["step"][-1] == 0
        for name, value in values_of(run).items():
            # outside the chart the final state is x, y, θ, v, ω; a path counts every plant step
            if turning and name in ("x2", "u0", "u1"):
                continue
            if value is None:
                assert math.isnan(lanes[name][i]), name
            else:
                assert lanes[name][i] == pytest.approx(value, rel=1e-9, abs=1e-9), (name, i)
        if turning:
            last = [float(run.trajectory[name][-1]) for name in ("theta", "v", "omega")]
            assert [lanes[name][i] for name in ("x2", "u0", "u1")] == pytest.approx(last, rel=1e-9)


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
@pytest.mark.parametrize("law", ["published", "corrected", "homogeneous"])
def test_long_lanes_end_as_the_reference_does(
    section4: Make, truths: dict[str, Truth], law: str, discretisation: str
) -> None:
    """Sign-based traces differ in the last bits; outcomes, times and bands do not."""
    given = trials(section4, truths, law, duration=13.0, discretisation=discretisation)
    lanes = simulate_ensemble(given)
    compared = []
    for i, scenario in enumerate(given):
        run = simulate(scenario)
        assert lanes["outcome"][i] is run.outcome
        assert lanes["returns"][i] == run.returns
        for step in range(4):
            end, lane_end = run.settling_time.steps.get(str(step)), lanes[f"end{step}"][i]
            assert math.isnan(lane_end) == (end is None)
            if end is not None:
                compared.append(abs(lane_end - end) <= COARSE["control_period"] * 1.01)
        if run.outcome is Outcome.PARKED:
            assert lanes["residual"][i] == pytest.approx(run.metrics.residual, rel=0.5, abs=1e-3)
            assert lanes["total"][i] == lanes["end3"][i]
            assert lanes["excursion"][i] == pytest.approx(run.metrics.excursion, rel=1e-2)
    assert len(compared) > 10
    assert sum(compared) >= 0.99 * len(compared)


def test_lanes_reach_the_outcomes_of_the_reference(section4: Make) -> None:
    start = Start(state=(-0.2, 0.3, -0.5, 2.6, 0.8))
    reached = set()
    for limits in (
        Limits(view=(-0.5, 0.5, -0.5, 0.5)),
        Limits(tau=(50.0, 5.0)),
        Limits(speed=2.0),
        Limits(turn_rate=0.7),
        Limits(tau=(20.0, 20.0), saturate=True),
    ):
        given = [section4(start=start, limits=limits, duration=5.0, **COARSE)]
        lanes, run = simulate_ensemble(given), simulate(given[0])
        assert lanes["outcome"][0] is run.outcome
        assert lanes["ended"][0] == pytest.approx(run.ended)
        for name in ("peak_tau2", "rms_tau1", "total_variation_tau1", "path_length"):
            assert lanes[name][0] == pytest.approx(values_of(run)[name], rel=2e-2), name
        reached.add(run.outcome)
    assert reached == {
        Outcome.OUT_OF_VIEW, Outcome.INPUT_LIMIT, Outcome.SPEED_LIMIT, Outcome.PARKED
    }  # fmt: skip


def test_rms_and_variation_of_a_trial_that_left_the_view_are_those_of_its_samples(
    section4: Make,
) -> None:
    limits = Limits(view=(-0.5, 0.5, -0.5, 0.5))
    scenario = section4(start=Start(state=(-0.4, 0.3, 0.0, 2.0, 0.0)), limits=limits, **COARSE)
    lanes, run = simulate_ensemble([scenario]), simulate(scenario)
    assert run.outcome is Outcome.OUT_OF_VIEW
    for name in ("rms_tau1", "rms_tau2", "total_variation_tau1", "total_variation_tau2"):
        assert lanes[name][0] == pytest.approx(values_of(run)[name], rel=1e-9), name


# ------------------------------------------------------------------------------- gains that vary

VARYING = {
    "sines": Truth(
        alpha=(Sine(mean=1.0, amplitude=0.4, omega=3.0), 0.7),
        b2=Sine(mean=1.0, amplitude=0.2, omega=5.0, phase=1.0),
    ),
    "noise": Truth(
        alpha=(1.2, Noise(mean=1.0, amplitude=0.4, bandwidth=9.0, seed=1)),
        gamma=(Sine(mean=1.5, amplitude=0.5, omega=4.0), Constant(1.0)),
        b2=Noise(mean=1.0, amplitude=0.2, bandwidth=20.0, seed=2),
    ),
    "constant": Truth(alpha=(1.1, 0.9), b2=0.8),
    "adversary": Truth(alpha=(Adversary(), Adversary()), b2=Adversary()),
    "plain": Truth(),
}


def varying(section4: Make, names: Sequence[str] = tuple(VARYING), **run: Any) -> list[Scenario]:
    known = Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5, b2=(0.8, 1.2))
    return [
        section4(truth=VARYING[name], bounds=known, start=start, **COARSE, **run)
        for start in (
            Start(state=(-0.2, 0.3, -0.5, 1.6, 0.8)),
            Start(pose=(-1.0, 0.5, 2.0), velocity=(0.5, 0.1)),
        )
        for name in names
    ]


def test_lanes_follow_gains_that_vary_as_the_reference_does(section4: Make) -> None:
    given = varying(section4, duration=0.3)
    lanes = simulate_ensemble(given)
    for i, scenario in enumerate(given):
        run = simulate(scenario)
        for name, value in values_of(run).items():
            turning = run.trajectory["step"][-1] == 0
            if value is not None and not (turning and name in ("x2", "u0", "u1")):
                assert lanes[name][i] == pytest.approx(value, rel=1e-9, abs=1e-9), (name, i)
        assert lanes["max_heading"][i] > 0.0
    headings = lanes["x2"][len(VARYING) :]  # of the same turn under five truths
    assert len({round(float(theta), 6) for theta in headings}) == len(VARYING) - 1
    assert headings[2] == pytest.approx(headings[3]), "constant 0.8, and the adversary's lowest"


def test_a_lane_with_constant_gains_is_the_same_beside_one_whose_gains_vary(section4: Make) -> None:
    mixed, constant = varying(section4, duration=1.0), ("constant", "adversary", "plain")
    alone = varying(section4, constant, duration=1.0)
    places = [mixed.index(scenario) for scenario in alone]
    assert same(simulate_ensemble(alone), simulate_ensemble(mixed), places) == []


# --------------------------------------------------------------------- a lane is a lane everywhere


@pytest.fixture(scope="module")
def crowd(section4: Make, truths: dict[str, Truth]) -> list[Scenario]:
    """More than two blocks of trials, some turning, some with noise of eight tones."""
    rng = np.random.default_rng(5)
    return [
        section4(
            start=Start(pose=(x, y, theta if i % 3 == 0 else 0.3 * theta), velocity=(0.2, 0.1)),
            truth=truths[TRUTHS[i % 4]],
            duration=2.0,
            **COARSE,
        )
        for i, (x, y, theta) in enumerate(rng.uniform([-2, -1, -3.1], [2, 1, 3.1], (150, 3)))
    ]


@pytest.fixture(scope="module")
def crowd_results(crowd: list[Scenario]) -> dict[str, Any]:
    return simulate_ensemble(crowd)


def same(one: dict[str, Any], other: dict[str, Any], of_other: Any) -> list[str]:
    """Names of the results that differ in any bit."""
    names = [name for name in one if name != "outcome"]
    differing = [n for n in names if not np.array_equal(one[n], other[n][of_other], equal_nan=True)]
    return differing + ([] if list(one["outcome"]) == list(other["outcome"][of_other]) else ["o"])


def test_a_lane_does_not_depend_on_its_place(
    crowd: list[Scenario], crowd_results: dict[str, Any]
) -> None:
    order = np.random.default_rng(6).permutation(len(crowd))
    assert same(simulate_ensemble([crowd[i] for i in order]), crowd_results, order) == []


def test_a_lane_does_not_depend_on_its_company(
    crowd: list[Scenario], crowd_results: dict[str, Any]
) -> None:
    for i in (0, 1, 2, 3, 70, 149):
        assert same(simulate_ensemble([crowd[i]]), crowd_results, [i]) == []
    in_chart = [i for i, s in enumerate(crowd) if abs(s.start_pose[2]) < 1.3]
    assert same(simulate_ensemble([crowd[i] for i in in_chart]), crowd_results, in_chart) == []


def test_a_lane_does_not_depend_on_the_number_of_threads(
    crowd: list[Scenario], crowd_results: dict[str, Any]
) -> None:
    assert same(simulate_ensemble(crowd, threads=3), crowd_results, slice(None)) == []


@pytest.mark.parametrize(
    ("limits", "outcome"),
    [
        (Limits(view=(0.3, 3.0, -2.0, 2.0)), Outcome.OUT_OF_VIEW),
        (Limits(speed=1.3), Outcome.SPEED_LIMIT),
    ],
)
def test_lanes_that_ended_leave_the_others_alone(
    section4: Make, limits: Limits, outcome: Outcome
) -> None:
    """They idle at the goal, in one case out of view, among lanes of other steps."""
    rng = np.random.default_rng(8)
    given = [
        section4(start=Start(pose=tuple(pose)), limits=limits, duration=0.8, **COARSE)
        for pose in rng.uniform([0.5, -1.0, -0.6], [2.0, 1.0, 0.6], (40, 3))
    ]
    together = simulate_ensemble(given)
    ended = [found is outcome for found in together["outcome"]]
    assert 5 < sum(ended) < 40, sorted(together["ended"])
    for i, scenario in enumerate(given):
        assert same(simulate_ensemble([scenario]), together, [i]) == [], i


def test_a_lane_s_plant_step_is_its_own(section4: Make) -> None:
    """Square waves need smaller steps, whatever the company needs."""
    given = [section4(truth=name, duration=1.0) for name in ("sines", "squares", "sines")]
    together = simulate_ensemble(given)
    for i, scenario in enumerate(given):
        assert same(simulate_ensemble([scenario]), together, [i]) == []
        assert together["path_length"][i] == pytest.approx(
            simulate(scenario).metrics.path_length, rel=1e-2
        )


# --------------------------------------------------------------------------------- what is refused


def test_an_ensemble_of_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="no trials"):
        simulate_ensemble([])


@pytest.mark.parametrize(
    "change",
    [
        {"gains": Gains(lambda1=2.0)},
        {"limits": Limits(speed=3.0)},
        {"run": RunSettings(duration=1.0)},
    ],
)
def test_trials_that_differ_in_more_than_start_and_truth_are_refused(
    section4: Make, change: dict[str, Any]
) -> None:
    with pytest.raises(InputError, match="differ in more than start and truth"):
        simulate_ensemble([section4(), section4(**change)])
