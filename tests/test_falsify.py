"""The search for the run that breaks a claim."""

import json
import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

pytest.importorskip("scipy", reason="needs parkproof[campaign]")
pytest.importorskip("flint", reason="needs parkproof[proof]")

from parkproof.bounds import Bounds, Limits
from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.falsification import confirm
from parkproof.falsification.claims import chosen, claims_of
from parkproof.falsification.confirm import finer, replayed
from parkproof.falsification.search import POPULATION, falsify
from parkproof.falsification.space import space_of_scenario
from parkproof.laws.gains import Gains
from parkproof.model.signals import Adversary, Constant, Switched
from parkproof.model.truth import Truth
from parkproof.proof import find_links
from parkproof.proof.checker.certificate import digest_of
from parkproof.proof.whole_run import certify
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.scenario_file import read_scenario, template, to_toml
from parkproof.simulation import ensemble
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import simulate

COARSE = "run.control_period=0.008"
KNOWN = Bounds(alpha=(0.9, 1.1), disturbance=0.5)
BOX = {"x0": (-0.1, 0.1), "x1": (0.0, 0.1), "x2": (0.0, 0.1), "u0": (0, 0), "u1": (0, 0)}


def scenario(**changes) -> Scenario:
    given = {
        "law": "corrected",
        "bounds": KNOWN,
        "start": Start(pose=(-1.0, 0.1, 0.0)),
        "run": RunSettings(duration=9.0, control_period=0.01, discretisation="implicit"),
    }
    return Scenario(**{**given, **changes})


def searched(one: Scenario, *, box=(), **options):
    claims = claims_of(one)
    objectives = chosen(claims, options.pop("names", ()))
    return falsify(space_of_scenario(one, box=box), claims, objectives=objectives, **options)


@pytest.fixture(scope="module")
def certificate():
    gains = Gains(q1="19/21", direction="toward")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(find_links, "SHARES", (0.7,))
        found = certify(law="corrected", bounds=KNOWN, gains=gains, starts=BOX)
    assert found.certificate is not None, found.reason
    return found.certificate


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(certificate, path: Path, **claim) -> Path:
    """A certificate's file, some numbers of its claim forged, with a digest that fits."""
    forged = json.loads(json.dumps(certificate))
    forged["claim"] |= claim
    path.write_text(json.dumps(forged | {"digest": digest_of(forged)}))
    return path


def test_a_sound_certificate_is_not_broken(certificate, here, capsys):
    path = written(certificate, here / "certificate.json")
    assert main(["falsify", str(path), "--runs", "300", "--set", COARSE]) == 0
    printed = capsys.readouterr().out
    assert "No run went beyond what is proved." in printed
    assert "the same." in printed
    assert simulate(read_scenario(here / "falsified.toml")).outcome is Outcome.PARKED


@pytest.mark.parametrize(
    ("forged", "name"), [({"total_time": 3.0}, "total_time"), ({"max_speed": 1.0}, "max_speed")]
)
def test_a_forged_number_raises_an_alarm_and_its_run_is_written(
    certificate, here, capsys, forged, name
):
    path = written(certificate, here / "certificate.json", **forged)
    options = ["--runs", "200", "--set", COARSE, "--set", "run.duration=20"]
    assert main(["falsify", str(path), "--objective", name, *options]) == 1
    assert f"ALARM: {name} = " in capsys.readouterr().out
    again = ["--objective", name, *options, "--json", "--out", "again.toml"]
    assert main(["falsify", str(path), *again]) == 1
    found = {one["number"]: one for one in json.loads(capsys.readouterr().out)["numbers"]}
    assert [key for key, one in found.items() if one["broken"]] == [name]
    assert found[name]["sampled_finely"] > found[name]["bound"] == forged[name]
    run = simulate(read_scenario(here / "falsified.toml"))
    value = run.settling_time.total if name == "total_time" else run.metrics.max_speed
    assert value > forged[name]


def test_what_only_sampling_adds_is_no_alarm(certificate, here, capsys, monkeypatch):
    path = written(certificate, here / "certificate.json", max_speed=1.0)
    monkeypatch.setattr(
        "parkproof.falsification.confirm.finer", lambda broken: [0.9 for _ in broken]
    )
    options = ["--objective", "max_speed", "--runs", "65", "--set", COARSE]
    assert main(["falsify", str(path), *options]) == 0
    assert "this is what sampling adds" in capsys.readouterr().out
    assert main(["falsify", str(path), *options, "--json", "--out", "again.toml"]) == 0
    found = {one["number"]: one for one in json.loads(capsys.readouterr().out)["numbers"]}
    one = found["max_speed"]
    assert (one["exceeded"], one["broken"], one["sampled_finely"]) == (True, False, 0.9)


def test_ctrl_c_while_sampling_finely_is_said_and_leaves_an_alarm(
    certificate, here, capsys, monkeypatch
):
    def stops(_broken):
        raise KeyboardInterrupt

    path = written(certificate, here / "certificate.json", max_speed=1.0)
    monkeypatch.setattr("parkproof.falsification.confirm.finer", stops)
    options = ["--objective", "max_speed", "--runs", "65", "--set", COARSE]
    assert main(["falsify", str(path), *options, "--json"]) == 130
    found = json.loads(capsys.readouterr().out)
    one = next(one for one in found["numbers"] if one["number"] == "max_speed")
    assert (found["interrupted"], found["written"]["replay"]) == (True, None)
    assert (one["broken"], one["sampled_finely"]) == (True, None)
    assert main(["falsify", str(path), *options, "--out", "again.toml"]) == 130
    assert "it was not sampled more finely" in capsys.readouterr().out


def test_the_published_law_is_broken_where_truth_may_vary(section4):
    found = searched(section4("published", duration=12.0, control_period=0.01), runs=100)
    (time, *_) = found.worst
    assert time.broken
    assert time.outcome is not Outcome.PARKED
    assert replayed(time).same


def test_a_disturbance_beyond_what_the_law_is_told_breaks_the_claim():
    run = RunSettings(duration=8.0, control_period=0.01)
    strong = (Constant(1.5), Constant(1.5))
    told = scenario(run=run)
    untold = scenario(run=run, truth=Truth(disturbance=strong, outside_bounds=True))
    assert not searched(told, runs=65).worst[0].broken
    (worst, *_) = searched(untold, runs=200).worst
    assert worst.broken


def test_improving_finds_more_than_drawing_at_random(monkeypatch):
    one = scenario(bounds=Bounds(alpha=(0.8, 1.2), gamma=(1.0, 2.0), disturbance=1.0))

    def largest(first: float) -> float:
        monkeypatch.setattr("parkproof.falsification.search.FIRST", first)
        found = searched(one, names=["max_tau_2"], runs=700, box=(0.3, 0.05, 0.2), seed=3)
        return next(w.size for w in found.worst if w.claim.name == "max_tau 2")

    assert largest(0.15) > largest(1.0)


def test_the_same_seed_gives_the_same_search_on_any_number_of_threads():
    one, two = (searched(scenario(), runs=200, seed=5, threads=n, box=(0.2,)) for n in (1, 2))
    other = searched(scenario(), runs=200, seed=6, box=(0.2,))
    assert one == two
    assert other.worst != one.worst


def test_all_that_is_tried_lies_within_bounds_and_box():
    given = scenario(bounds=Bounds(alpha=(0.9, 1.1), gamma=(1, 2), disturbance=0.5, b2=(0.9, 1.1)))
    space = space_of_scenario(given, box=(0.2, 0.1))
    assert space.dimension == 2 + 7 * 4
    kinds = set()
    for point in np.random.default_rng(0).random((200, space.dimension)):
        tried = space.scenario_at(point)  # which checks its truth
        assert not tried.truth.outside_bounds
        x, y, theta = tried.start_pose
        assert abs(x + 1.0) <= 0.2 + 1e-12
        assert abs(y - 0.1) <= 0.1 + 1e-12
        assert theta == 0.0
        kinds |= {type(signal).__name__ for signal in tried.truth.signals}
    assert kinds == {"Constant", "Sine", "Square", "Switched", "Adversary"}


@pytest.mark.parametrize(
    ("kind", "free"), [("tilted-camera", set()), ("velocity-robot", {"alpha"})]
)
def test_only_what_a_scenario_leaves_open_is_searched(here, kind, free):
    (here / "scenario.toml").write_text(template(kind))
    given = read_scenario(here / "scenario.toml")
    space = space_of_scenario(given, box=(0.05, 0.05))
    assert {key for key, _, _ in space.signals} == free
    tried = space.scenario_at(np.full(space.dimension, 0.9))
    assert tried.start_pose[:2] == pytest.approx([x + 0.05 for x in given.start_pose[:2]])
    assert tried.camera == given.camera
    alone = msgspec.structs.replace(given, bounds=Bounds(alpha=(0.4, 1.9), b2=(0.9, 1.1)))
    if given.camera is None:  # b2 belongs to robots of the paper
        space = space_of_scenario(alone)
        assert space.scenario_at(np.full(space.dimension, 0.9)).start == given.start
    else:
        with pytest.raises(InputError, match="nothing to search"):
            space_of_scenario(alone)


def test_a_limit_is_a_claim_and_a_view_too():
    limits = Limits(tau=(20.0, 30.0), speed=3.0, view=(-2.0, 1.0, -0.5, 0.8))
    bounds = {c.name: c.bound for c in claims_of(scenario(limits=limits)) if c.bound < math.inf}
    assert bounds == {
        "total_time": 9.0, "max_tau 1": 20.0, "max_tau 2": 30.0, "max_speed": 3.0,
        "x0_range -": 2.0, "x0_range +": 1.0, "max_abs_state x1": 0.8,
    }  # fmt: skip


def test_ctrl_c_keeps_the_worst_so_far(here, monkeypatch, capsys):
    (here / "scenario.toml").write_text(to_toml(scenario()))
    calls = []

    def stops(*given, **options):
        calls.append(given)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return ensemble.simulate_trials(*given, **options)

    monkeypatch.setattr("parkproof.falsification.search.simulate_trials", stops)
    assert main(["falsify", "scenario.toml"]) == 130
    assert "Interrupted" in capsys.readouterr().out
    read_scenario(here / "falsified.toml")


def test_json_says_what_the_table_says(here, capsys):
    (here / "scenario.toml").write_text(to_toml(scenario()))
    words = ["falsify", "scenario.toml", "--runs", "64", "--json"]
    assert main([*words, "--set", "run.duration=2"]) == 1
    broken = json.loads(capsys.readouterr().out)
    time = next(one for one in broken["numbers"] if one["number"] == "total_time")
    assert (time["bound"], time["worst"], time["exceeded"]) == (2.0, None, True)
    assert broken["written"]["replay"]["same"]
    assert read_scenario(Path(broken["written"]["scenario"])).law == "corrected"
    assert main([*words, "--out", "other.toml"]) == 0
    kept = json.loads(capsys.readouterr().out)
    assert not any(one["exceeded"] for one in kept["numbers"])
    time = next(one for one in kept["numbers"] if one["number"] == "total_time")
    assert 0.0 < time["worst"] <= time["bound"] == 9.0
    assert kept["written"]["replay"]["size"] == pytest.approx(time["worst"], abs=0.011)


def test_time_ends_a_search(here, capsys):
    (here / "scenario.toml").write_text(to_toml(scenario()))
    assert main(["falsify", "scenario.toml", "--seconds", "0.01"]) == 0
    assert f"{POPULATION + 1} runs" in capsys.readouterr().out


def test_a_run_that_is_not_repeated_is_said_to_differ():
    (worst, *_) = searched(scenario(), runs=1).worst
    assert replayed(worst).same
    assert not replayed(replace(worst, size=worst.size + 0.1)).same


def test_finer_sampling_is_left_out_where_it_would_be_too_much(monkeypatch):
    (worst, *_) = searched(scenario(), runs=1).worst
    (fine,) = finer([worst])
    assert 0.0 < abs(fine - worst.size) < 0.2
    monkeypatch.setattr(confirm, "MAX_SAMPLES", 1000)
    assert finer([worst]) == [None]


BAD = [
    (["none.toml"], "none.toml"),
    (["scenario.toml", "--runs", "0"], "--runs 0: must be from 1 to"),
    (["scenario.toml", "--seconds", "-1"], "--seconds -1: must be a positive number"),
    (["scenario.toml", "--seed", "-1"], "--seed -1: must be a whole number >= 0"),
    (["scenario.toml", "--threads", "0"], "--threads 0: must be from 1 to"),
    (["scenario.toml", "--box", "wide"], "--box wide: must be numbers"),
    (["scenario.toml", "--box", "1,1,1,1,1,1"], "has 6 numbers; a start has 5"),
    (["scenario.toml", "--box", "-1"], "--box"),
    (["scenario.toml", "--box", "0,0,0,1e6"], "a start in the box"),
    (["published.toml", "--box", "0,0,6.28"], "a start in the box"),
    (
        ["scenario.toml", "--objective", "speed"],
        'no claim is called "speed"; choose of: total_time',
    ),
    (["certain.toml"], "nothing to search: [bounds] leave the truth no choice"),
    (["broken.json"], "broken.json: not JSON"),
    (["certificate.json", "--box", "0.1"], "--box goes with a scenario"),
    (["certificate.json", "--set", "bounds.disturbance=1"], "only keys of run can be set"),
    (["certificate.json", "--set", "run.duration=0.1"], "shorter than the proven time"),
    (["certificate.json", "--set", "run.noise=true"], "run"),
    (["scenario.toml", "--out", "missing/falsified.toml"], "there is no folder missing"),
]


@pytest.mark.parametrize(("words", "said"), BAD)
def test_bad_input_is_said_in_one_line(certificate, here, capsys, words, said):
    (here / "scenario.toml").write_text(to_toml(scenario()))
    (here / "published.toml").write_text(to_toml(scenario(law="published")))
    (here / "certain.toml").write_text(to_toml(scenario(bounds=Bounds())))
    (here / "broken.json").write_text("{")
    written(certificate, here / "certificate.json")
    assert main(["falsify", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not (here / "falsified.toml").exists()


def test_signals_switch_when_they_say():
    push = Switched(first=2.0, second=-1.0, times=(1.0, 2.0, 3.5))
    mean, tones = push.mean_and_tones
    at = [mean + sum(a * np.sign(np.sin(w * t + f)) for a, w, f, _ in tones) for t in range(5)]
    assert push.range == (-1.0, 2.0)
    assert [at[0], at[3], at[4]] == [2.0, 2.0, -1.0]


@pytest.mark.parametrize("times", [(), (2.0, 1.0), (1.0, 1.0), (-1.0,), (1e9,), (math.nan,)])
def test_times_that_are_no_times_are_refused(times):
    with pytest.raises(InputError, match="times"):
        Switched(first=1.0, second=2.0, times=times)


def test_lanes_and_plain_run_switch_alike(tmp_path):
    pushes = Switched(first=0.5, second=-0.5, times=(0.7123, 2.2217))
    one = scenario(
        truth=Truth(alpha=(Switched(first=0.9, second=1.1, times=(1.003,)), Adversary()),
                    disturbance=(pushes, pushes))
    )  # fmt: skip
    run, rows = simulate(one), ensemble.simulate_ensemble([one])
    assert rows["total"][0] == pytest.approx(run.settling_time.total, abs=0.0101)
    assert rows["peak_tau2"][0] == pytest.approx(run.metrics.peak_tau[1], rel=1e-6)
    path = tmp_path / "switched.toml"
    path.write_text(to_toml(one))
    assert read_scenario(path) == one
