"""Trials in single precision: the same source, for statistics only."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba import types

from parkproof.campaign.definition import read_campaign
from parkproof.campaign.replay import trial_of
from parkproof.campaign.run import run_campaign
from parkproof.campaign.table import row_of
from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.laws.gains import Switching
from parkproof.model.truth import Truth
from parkproof.report.campaign import write_report
from parkproof.scalar import sine, spow, tangent
from parkproof.scenario import Limits, Scenario, Start
from parkproof.simulation.compiler import KERNEL, inlined, register
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.lanes.buffer import BLOCK, PATH, ROWS
from parkproof.simulation.lanes.memory import Buffer, like
from parkproof.simulation.lanes.sums import add_to
from parkproof.simulation.run import simulate
from parkproof.simulation.single import has_singles
from robot_scenarios import COMBINATIONS, trials

Make = Callable[..., Scenario]

register()


@inlined
def scaled(x: float) -> float:
    return 0.5 * x + math.pi


def over(function: Callable[[Any, Any], Any]) -> Callable[..., np.ndarray]:
    """A function of two numbers, compiled for arrays of them."""
    work = inlined(function)

    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def loop(x: np.ndarray, y: np.ndarray, out: np.ndarray) -> None:
        for i in range(x.size):
            out[i] = work(x[i], y[i])

    def of(x: Any, y: Any, *, kind: type = np.float32) -> np.ndarray:
        x, y = (np.ascontiguousarray(a, dtype=kind) for a in np.broadcast_arrays(x, y))
        out = np.empty(x.shape)
        loop(x, y, out)
        return out

    return of


def power(x: float, p: float) -> float:
    return spow(x, p)


powers = over(power)
sines = over(lambda x, _: sine(x))
tangents = over(lambda x, _: tangent(x))
scales = over(lambda x, _: scaled(x))


def test_a_power_of_singles_is_right_to_3e_6() -> None:
    rng = np.random.default_rng(1)
    x = (10.0 ** rng.uniform(-8, 4, 100_000) * rng.choice([-1.0, 1.0], 100_000)).astype(np.float32)
    p = rng.uniform(0.05, 2.0, x.size).astype(np.float32)
    exact = np.copysign(np.abs(x.astype(float)) ** p.astype(float), x)
    off = np.abs(powers(x, p) / exact - 1.0)
    assert np.max(off) < 3e-6
    assert np.median(off) < 2e-7


def test_powers_of_special_singles() -> None:
    found = powers([1.0, -1.0, 4.0, -8.0, 0.0, -0.0, 1e-40], [0.37, 2.2, 0.5, 1.0, 0.5, 0.5, 0.5])
    assert found == pytest.approx([1.0, -1.0, 2.0, -8.0, 0.0, 0.0, 0.0], rel=2e-7)


def test_sine_and_tangent_of_singles() -> None:
    x = np.linspace(-100.0, 100.0, 100_001).astype(np.float32)
    assert np.max(np.abs(sines(x, 0.0) - np.sin(x.astype(float)))) < 2e-7
    narrow = x[np.abs(x) < 1.4]
    assert tangents(narrow, 0.0) == pytest.approx(np.tan(narrow.astype(float)), rel=3e-6, abs=1e-6)


def test_written_numbers_are_singles_only_where_a_function_is_given_singles() -> None:
    x = np.array([0.1, 3.3])
    exact = 0.5 * x + math.pi
    assert np.array_equal(scales(x, 0.0, kind=np.float64), exact)
    x32 = x.astype(np.float32)
    rounded = (np.float32(0.5) * x32 + np.float32(math.pi)).astype(float)
    assert np.array_equal(scales(x32, 0.0), rounded)
    assert not np.array_equal(rounded, exact)


def starts(section4: Make, count: int, form: str = "explicit") -> list[Scenario]:
    rng = np.random.default_rng(3)
    low, high = (-1.0, -0.5, -0.5, -1.0, -1.0), (1.0, 0.5, 0.5, 3.0, 1.0)
    return [
        section4(
            "corrected",
            start=Start(state=tuple(state)),
            duration=14.0,
            control_period=2e-3,
            plant_step=2e-3,
            discretisation=form,
        )
        for state in rng.uniform(low, high, (count, 5)).tolist()
    ]


@pytest.mark.parametrize("form", ["explicit", "implicit"])
def test_most_trials_settle_at_the_same_sample(section4: Make, form: str) -> None:
    some = starts(section4, 192, form)
    double, single = (
        simulate_ensemble(some, precision=precision) for precision in ("double", "single")
    )  # type: ignore[misc]  # mypy takes the names for text
    assert (double["outcome"] == single["outcome"]).mean() > 0.99
    off = np.abs(double["total"] - single["total"])
    assert (off < 1e-9).mean() > 0.8
    assert (off < 8e-3).mean() > 0.9
    for name in ("path_length", "rms_tau1", "rms_tau2", "excursion", "peak_tau1"):
        assert np.median(np.abs(single[name] / double[name] - 1.0)) < 1e-3
    # a time is that of a sample, and rounding is there
    assert np.array_equal(single["total"], np.round(single["total"] / 2e-3) * 2e-3, equal_nan=True)
    assert not np.array_equal(double["path_length"], single["path_length"])


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_short_runs_of_every_kind_of_robot_are_near(combination: Any) -> None:
    some = trials(*combination)
    double, single = (
        simulate_ensemble(some, precision=precision) for precision in ("double", "single")
    )  # type: ignore[misc]  # mypy takes the names for text
    assert (double["outcome"] == single["outcome"]).all()
    for name in ("x0", "x1", "path_length", "excursion"):
        assert single[name] == pytest.approx(double[name], rel=5e-3, abs=5e-3)


@pytest.mark.parametrize("combination", [None, COMBINATIONS[2], COMBINATIONS[5]])
def test_a_single_lane_does_not_depend_on_its_company(section4: Make, combination: Any) -> None:
    """Nor on threads; in both forms, with cameras, noise and latency."""
    some = starts(section4, 70) if combination is None else trials(*combination)
    whole = simulate_ensemble(some, precision="single", threads=2)
    alone = simulate_ensemble(some[3:4], precision="single")
    assert all(
        np.array_equal(whole[name][3:4], alone[name], equal_nan=name != "outcome") for name in whole
    )


@pytest.mark.parametrize("time", [0.3, 0.6, 0.7])
def test_a_given_time_of_switching_is_the_same_sample(section4: Make, time: float) -> None:
    law = section4("published", switching=Switching(to_step2=time), duration=1.0)
    found = [simulate_ensemble([law], precision=p)["end1"][0] for p in ("double", "single")]  # type: ignore[arg-type]
    assert found == [pytest.approx(time), found[0]]


def test_a_long_sum_in_singles_does_not_fall_behind() -> None:
    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def fill(b: Any, count: int) -> None:
        for _ in range(count):
            add_to(b, PATH, 0, like(b, 1e-4))

    for single, allowed in ((True, 1e-6), (False, 1e-9)):
        room = np.zeros(BLOCK * len(ROWS))
        buffer = Buffer(room, dtype=np.float32 if single else np.float64)
        fill(buffer, 3_000_000)
        assert buffer.numbers[PATH] == pytest.approx(300.0, rel=allowed)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"limits": Limits(tau=(1e300, 1.0))}, "limits has the number 1e+300"),
        ({"truth": Truth(gamma=(1e39, 1.0), outside_bounds=True)}, "truth has the number 1e+39"),
        ({"duration": 5000.0}, "5,000,000 samples in precision"),
    ],
)
def test_what_singles_cannot_hold_is_refused(section4: Make, changes: Any, said: str) -> None:
    with pytest.raises(InputError) as raised:
        simulate_ensemble([section4("corrected", **changes)], precision="single")
    assert str(raised.value).startswith(said)
    assert 'precision = "double"' in str(raised.value)


def test_what_is_no_precision_is_refused(section4: Make) -> None:
    some = starts(section4, 1)
    with pytest.raises(InputError, match='precision = "half": must be "double" or "single"'):
        simulate_ensemble(some, precision="half")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="in double precision only"):
        simulate_ensemble(some, precision="single", device="cuda")


CAMPAIGN = """
law = "corrected"
trials = 8
precision = "single"
[start]
pose = [-1.0, 0.2, 0.0]
[run]
duration = 12.0
control_period = 0.01
[distributions]
"start.pose[0]" = { kind = "uniform", low = -2.0, high = -0.5 }
"""


def test_a_campaign_in_singles_says_so_and_is_no_witness_of_a_proof(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, file, proof = (tmp_path / name for name in ("out", "campaign.toml", "certificate.json"))
    file.write_text(CAMPAIGN, encoding="utf-8")
    run_campaign(read_campaign(file), out)
    scenario = trial_of(out, 3).scenario
    alone = simulate_ensemble([scenario], precision="single")
    assert row_of(out, 3)["path_length"] == alone["path_length"][0]
    said = trial_of(out, 3).compared(simulate(scenario))
    assert said.startswith("In the campaign, in single precision: parked after")
    page = write_report(out, study=0).read_text(encoding="utf-8")
    assert "Carried out in single precision." in page
    proof.write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be compared with trials in precision"):
        write_report(out, certificate=proof, study=0)
    assert main(["campaign", str(file), "--out", str(out), "--certificate", str(proof)]) == 2
    assert 'precision = "single"' in " ".join(capsys.readouterr().err.split())


def test_a_campaign_from_before_there_was_a_choice_goes_on(tmp_path: Path) -> None:
    out, file = tmp_path / "out", tmp_path / "campaign.toml"
    file.write_text(CAMPAIGN.replace('precision = "single"\n', ""), encoding="utf-8")
    run_campaign(read_campaign(file), out)
    record = json.loads((out / "campaign.json").read_text(encoding="utf-8"))
    assert record["precision"] == record["campaign"].pop("precision") == "double"
    (out / "campaign.json").write_text(json.dumps(record), encoding="utf-8")
    run_campaign(read_campaign(file, overrides=["trials=12"]), out)
    assert row_of(out, 11)["outcome"] == "parked"
    with pytest.raises(InputError, match='precision is "double" there and "single" here'):
        run_campaign(read_campaign(file, overrides=["precision=single"]), out)


def test_types_that_hold_singles_are_known() -> None:
    singles = types.UniTuple(types.float32, 2)
    assert has_singles(types.Tuple((types.int64, singles)))
    assert has_singles(types.Array(types.float32, 1, "C"))
    assert not has_singles(types.Tuple((types.int64, types.float64)))
