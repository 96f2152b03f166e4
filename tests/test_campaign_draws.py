"""What a campaign draws: distributions, keys, and lanes without a scenario a trial."""

import time
import tomllib
from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from parkproof.campaign.definition import (
    MOST_SOBOL,
    Campaign,
    campaign_from_dict,
    check_trials,
    plain_of,
)
from parkproof.campaign.distributions import Choice, LogUniform, Normal, Uniform
from parkproof.campaign.draw import drawn_values, unit_numbers
from parkproof.campaign.lanes import trials_from
from parkproof.campaign.prepare import Prepared, prepare
from parkproof.errors import InputError
from parkproof.scenario_file import template
from parkproof.simulation.trials import Trials, trials_of

Data = dict[str, Any]

BOUNDS = {"alpha": [0.5, 1.5], "gamma": [1.0, 2.0], "disturbance": 2.5}
SINE = {"kind": "sine", "mean": 1.5, "amplitude": 0.1, "omega": 1.0}


def uniform(low: float, high: float) -> Data:
    return {"kind": "uniform", "low": low, "high": high}


def data_of(distributions: Data, **changes: Any) -> Data:
    base: Data = {
        "law": "corrected",
        "bounds": BOUNDS,
        "start": {"pose": [-1.0, 0.2, 0.0], "velocity": [0.1, 0.0]},
        "truth": {"gamma": [SINE, SINE]},
        "trials": 100,
        "seed": 3,
        "distributions": distributions,
    }
    return deepcopy(base | changes)


def made(distributions: Data, **changes: Any) -> Prepared:
    return prepare(campaign_from_dict(data_of(distributions, **changes), where="c"), where="c")


def refused(distributions: Data, **changes: Any) -> str:
    with pytest.raises(InputError) as caught:
        made(distributions, **changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# ------------------------------------------------------------------------------- numbers


@pytest.mark.parametrize("draws", ["sobol", "independent"])
def test_numbers_of_a_trial_do_not_depend_on_how_many_are_asked_for(draws: Any) -> None:
    whole = unit_numbers(7, 0, 300, seed=11, draws=draws)
    assert ((whole >= 0.0) & (whole < 1.0)).all()
    for begin, end in ((0, 1), (0, 37), (37, 38), (64, 300), (299, 300)):
        part = unit_numbers(7, begin, end, seed=11, draws=draws)
        assert np.array_equal(part, whole[:, begin:end])
    assert not np.array_equal(unit_numbers(7, 0, 300, seed=12, draws=draws), whole)


def test_sobol_numbers_fill_the_space_evenly() -> None:
    """In each of 256 intervals of each dimension there is just one of the first 256 points."""
    points = unit_numbers(5, 0, 256, seed=0, draws="sobol")
    for row in points:
        assert sorted(np.floor(256 * row).astype(int)) == list(range(256))


def test_independent_numbers_are_uniform_and_unrelated() -> None:
    numbers = unit_numbers(6, 0, 20_000, seed=5, draws="independent")
    assert np.abs(numbers.mean(axis=1) - 0.5).max() < 0.01
    assert np.abs(np.corrcoef(numbers) - np.eye(6)).max() < 0.03


def test_values_have_their_distribution_and_keep_inside_its_ends() -> None:
    numbers = (np.arange(10_000) + 0.5) / 10_000
    flat = Uniform(low=-1.0, high=3.0).values(numbers)
    assert flat.mean() == pytest.approx(1.0)
    assert flat.std() == pytest.approx(4.0 / 12**0.5, rel=1e-3)
    log = LogUniform(low=0.1, high=10.0).values(numbers)
    assert np.log(log).mean() == pytest.approx(0.0, abs=1e-9)
    bell = Normal(mean=2.0, deviation=0.5, low=1.0, high=2.5).values(numbers)
    assert float(np.mean(bell < 2.0)) == pytest.approx(
        (0.5 - 0.02275) / (0.84134 - 0.02275), abs=1e-3
    )
    for values, (low, high) in ((flat, (-1, 3)), (log, (0.1, 10)), (bell, (1.0, 2.5))):
        assert values.min() >= low
        assert values.max() <= high
    counts = np.bincount(Choice(values=("a", "b", "c")).indices(numbers))
    assert counts.max() - counts.min() <= 1
    whole = Uniform(low=3.0, high=5.0).whole_values(numbers)
    assert sorted(set(whole.tolist())) == [3.0, 4.0, 5.0]


# ------------------------------------------------------------------------------- lanes


def arrays_of(prepared: Prepared, begin: int, end: int) -> Trials:
    """Trials of the only ensemble, straight from what is drawn."""
    drawn = drawn_values(prepared.campaign, begin, end)
    return trials_from(prepared.group(0), prepared.numbers_of(drawn), range(begin, end))


def assert_same_as_scenarios(prepared: Prepared) -> None:
    assert prepared.splitting == ()
    arrays = arrays_of(prepared, 20, 60)
    for begin in (20, 33, 59):
        one = trials_of([prepared.scenario_of(begin)])
        mine = arrays.some(slice(begin - 20, begin - 19))
        for name in Trials.__dataclass_fields__:
            assert np.array_equal(getattr(one, name), getattr(mine, name)), (name, begin)


def test_the_template_draws_what_its_scenarios_say() -> None:
    data = tomllib.loads(template("campaign"))
    assert_same_as_scenarios(prepare(campaign_from_dict(data, where="c"), where="c"))


def test_every_number_of_start_and_truth_can_be_drawn() -> None:
    noise = {"kind": "noise", "mean": 1.5, "amplitude": 0.2, "bandwidth": 5.0, "seed": 4}
    square = {"kind": "square", "mean": 0.0, "amplitude": 1.0, "omega": 3.0}
    truth = {
        "alpha": [1.0, {**SINE, "mean": 1.0}],
        "b2": 1.0,
        "gamma": [noise, {"kind": "constant", "value": 1.2}],
        "disturbance": [square, {"kind": "adversary"}],
    }
    seeds = {"kind": "choice", "values": [1, 2, 30]}
    normal = {"kind": "normal", "mean": 1.0, "deviation": 0.1, "low": 0.8, "high": 1.2}
    log = {"kind": "log-uniform", "low": 0.2, "high": 20.0}
    signals = {
        "truth.alpha[0]": normal,
        "truth.alpha[1].mean": uniform(0.8, 1.2),
        "truth.alpha[1].phase": uniform(0.0, 6.0),
        "truth.b2": uniform(0.9, 1.1),
        "truth.gamma[0].mean": uniform(1.4, 1.6),
        "truth.gamma[0].amplitude": uniform(0.0, 0.3),
        "truth.gamma[0].bandwidth": log,
        "truth.gamma[0].seed": uniform(0, 9),
        "truth.gamma[1].value": uniform(1.0, 2.0),
        "truth.disturbance[0].mean": uniform(-0.5, 0.5),
        "truth.disturbance[0].amplitude": uniform(0.0, 2.0),
        "truth.disturbance[0].omega": log,
        "run.seed": seeds,
    }
    starts = (
        {"pose": [-1.0, 0.2, 0.0], "velocity": [0.1, 0.0]},
        {"state": [-1.0, 0.2, 0.1, 0.5, 0.1]},
    )
    bounds = BOUNDS | {"b2": [0.9, 1.1]}
    for start in starts:
        places = {
            f"start.{name}[{i}]": uniform(-4.0, 4.0)
            for name, values in start.items()
            for i in range(len(values))
        }
        assert_same_as_scenarios(
            made(signals | places, start=start, truth=truth, bounds=bounds, draws="independent")
        )


CAMERA = {
    "kind": "pinhole", "height": 3.0, "focal_length": 300.0, "tilt_deg": 10.0, "unit": 90.0,
    "goal": [0.2, 0.1, 0.2],
}  # fmt: skip
DRAWN_CAMERAS = {
    "camera.height": uniform(2.8, 3.2),
    "camera.roll_deg": uniform(-180.0, 180.0),
    "camera.goal[2]": uniform(-0.5, 0.5),
}


def test_a_camera_s_numbers_can_be_drawn() -> None:
    known = {"alpha": [0.3, 2.5]}
    for start in ({"floor_pose": [-0.5, 0.2, 0.1]}, {"pose": [-0.8, 0.2, 0.1]}):
        ((key, _),) = start.items()
        drawn = DRAWN_CAMERAS | {f"start.{key}[1]": uniform(-0.2, 0.2)}
        prepared = made(drawn, start=start, truth={}, bounds=known, camera=CAMERA)
        assert_same_as_scenarios(prepared)
        assert len(np.unique(arrays_of(prepared, 0, 8).camera[0])) == 8


def test_a_camera_that_does_not_see_its_start_is_refused() -> None:
    with pytest.raises(InputError, match=r"outside the picture|horizon"):
        made(
            DRAWN_CAMERAS | {"camera.height": uniform(0.3, 3.2)},
            start={"pose": [-4.0, 0.2, 0.1]},
            truth={},
            bounds={"alpha": [0.01, 50.0]},
            camera=CAMERA,
        )


def test_each_trial_has_noise_of_its_own() -> None:
    prepared = made({"start.pose[0]": uniform(-2, -1)}, run={"noise": 0.001, "seed": 40})
    assert prepared.scenario_of(33).run.seed == 73
    assert_same_as_scenarios(prepared)


def test_a_million_trials_become_lanes_in_seconds() -> None:
    data = tomllib.loads(template("campaign"))
    prepared = prepare(campaign_from_dict(data, where="c"), where="c")
    arrays_of(prepared, 0, 8)  # imports
    begun = time.process_time()
    arrays_of(prepared, 950_000, 1_000_000)
    assert 20.0 * (time.process_time() - begun) < 20.0


def test_choices_of_what_lanes_share_split_the_trials() -> None:
    signals = [{"kind": "adversary"}, *({"kind": "constant", "value": v} for v in (2.0, 0.0))]
    prepared = made(
        {
            "start.pose[0]": uniform(-2.0, -1.0),
            "run.latency": {"kind": "choice", "values": [0.0, 0.03]},
            "truth.disturbance[0]": {"kind": "choice", "values": signals},
            "truth.alpha[1]": {"kind": "choice", "values": [0.6, 1.4]},
        }
    )
    assert [q.key for q in prepared.splitting] == ["run.latency", "truth.disturbance[0]"]
    assert prepared.groups == 6
    found = [prepared.group(i) for i in range(6)]
    assert [s.run.latency for s in found] == [0.0] * 3 + [0.03] * 3
    assert len({str(s.truth.disturbance[0]) for s in found}) == 3
    assert {prepared.scenario_of(i).truth.alpha[1] for i in range(20)} == {0.6, 1.4}


def test_a_campaign_is_repeated_by_what_it_says_of_itself() -> None:
    campaign = campaign_from_dict(tomllib.loads(template("campaign")), where="c")
    again = campaign_from_dict(plain_of(campaign), where="again")
    assert isinstance(again, Campaign)
    assert again == campaign


def test_the_order_of_keys_in_the_file_does_not_matter() -> None:
    keys = {"start.pose[1]": uniform(-1, 1), "start.pose[0]": uniform(-2, -1)}
    backward = dict(reversed(keys.items()))
    assert made(keys).scenario_of(7) == made(backward).scenario_of(7)


# ------------------------------------------------------------------------------- what is refused

POSE = "start.pose[0]"
REFUSED = {
    "crossed": ({POSE: uniform(1.0, -1.0)}, "low must be below high"),
    "one point": ({POSE: uniform(1.0, 1.0)}, 'write kind = "constant"'),
    "too far apart": ({POSE: uniform(-1e308, 1e308)}, "too far apart"),
    "not finite": ({POSE: uniform(float("nan"), 1.0)}, "must be a finite number"),
    "log of 0": ({POSE: {"kind": "log-uniform", "low": 0.0, "high": 1.0}}, "greater than 0"),
    "deviation 0": (
        {POSE: {"kind": "normal", "mean": 0.0, "deviation": 0.0, "low": -1.0, "high": 1.0}},
        "deviation = 0.0: must be greater than 0",
    ),
    "ends in the tail": (
        {POSE: {"kind": "normal", "mean": 0.0, "deviation": 1.0, "low": 50.0, "high": 60.0}},
        "nothing is ever drawn",
    ),
    "no choice": ({POSE: {"kind": "choice", "values": []}}, "at least one value"),
    "choice of nan": ({POSE: {"kind": "choice", "values": [0.0, float("nan")]}}, "finite"),
    "no kind": ({POSE: {"low": 0.0, "high": 1.0}}, 'kind is missing; it takes "uniform"'),
    "unknown kind": ({POSE: {"kind": "unifrom", "low": 0.0, "high": 1.0}}, '"uniform"?'),
    "no table": ({POSE: 3.0}, "expected a table"),
    "misspelt end": ({POSE: {"kind": "uniform", "low": 0.0, "hihg": 1.0}}, 'did you mean "high"'),
    "unknown key": ({"start.poes[0]": uniform(0, 1)}, "did you mean start.pose[0]?"),
    "no key": ({"start pose": uniform(0, 1)}, "is no key"),
    "own key": ({"seed": uniform(0, 1)}, "the campaign's own"),
    "not in the file": ({"start.state[0]": uniform(0, 1)}, "the file has no start.state[0]"),
    "no such parameter": ({"truth.gamma[0].bandwidth": uniform(1, 2)}, "unknown key"),
    "a part of another": (
        {"start.pose": {"kind": "choice", "values": [[0, 0, 0]]}, POSE: uniform(0, 1)},
        "is a part of it",
    ),
    "twice": ({POSE: uniform(0, 1), f".{POSE}": uniform(0, 1)}, "one key twice"),
    "shared by lanes": (
        {"run.latency": uniform(0.0, 0.1)},
        '{ kind = "choice", values = [0, 0.1] }',
    ),
    "gains": ({"gains.lambda1": uniform(1.0, 2.0)}, "it can only be a choice"),
    "outside the bounds": (
        {"truth.alpha[0]": uniform(0.4, 1.5)},
        "lowest values: [truth] alpha[0] = 0.4: outside its bounds",
    ),
    "outside the bounds together": (
        {"truth.gamma[0].mean": uniform(1.2, 1.5), "truth.gamma[0].amplitude": uniform(0.0, 0.4)},
        "gamma[0] ranges over [0.8, 1.6], outside its bounds",
    ),
    "a choice that breaks a rule": (
        {POSE: uniform(0, 1), "gains.q1": {"kind": "choice", "values": ["9/11", "1/2"]}},
        "gains.q1 = 1/2",
    ),
    "a law that cannot turn": (
        {"start.pose[2]": uniform(0.0, 6.2), "law": {"kind": "constant", "value": "published"}},
        "the published law exists for |θ| < 90° only",
    ),
    "too many groups": (
        {"run.latency": {"kind": "choice", "values": [0.001 * i for i in range(101)]}},
        "have 101 combinations",
    ),
    "half a seed": ({"run.seed": uniform(0.5, 3.0)}, "write whole numbers"),
    "nothing": ({}, "draws nothing"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_distributions_that_cannot_be_are_refused(name: str) -> None:
    distributions, words = REFUSED[name]
    message = refused(distributions)
    assert words in message
    assert message.startswith("c: ")


def test_truth_outside_the_bounds_is_drawn_where_it_is_declared() -> None:
    declared = {"gamma": [SINE, SINE], "outside_bounds": True}
    prepared = made({"truth.alpha[0]": uniform(0.1, 3.0)}, truth=declared)
    assert any(prepared.scenario_of(i).truth.alpha[0] > 1.5 for i in range(20))


def test_numbers_of_trials_that_cannot_be_are_refused() -> None:
    assert "trials = 0: a campaign needs at least 1" in refused({POSE: uniform(0, 1)}, trials=0)
    beyond = refused({POSE: uniform(0, 1)}, trials=MOST_SOBOL + 1)
    assert 'write fewer, or draws = "independent"' in beyond
    check_trials(MOST_SOBOL + 1, "independent")
    with pytest.raises(InputError, match="at most"):
        check_trials(10**16, "independent")
    assert "seed = -1" in refused({POSE: uniform(0, 1)}, seed=-1)
    data = data_of({POSE: uniform(0, 1)})
    del data["trials"]
    with pytest.raises(InputError, match="trials is missing, so this is no campaign"):
        campaign_from_dict(data, where="c")
