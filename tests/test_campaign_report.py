"""The report of a campaign: what it counts, what it holds against a certificate, what it shows."""

import json
import math

import msgspec
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[proof]")

from parkproof.bounds import Bounds, Limits
from parkproof.campaign.table import file_of
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.model.signals import Adversary, Constant, Sine
from parkproof.model.truth import Truth
from parkproof.proof.whole_run import certify
from parkproof.report.coverage import (
    other_than_certified,
    outside_assumptions,
    tighter_limits,
)
from parkproof.report.distributions import SETTLING, edges_of, histogram, spread_of
from parkproof.report.measured import gains_of, stressed_runs, switching_of
from parkproof.report.success import success_of
from parkproof.report.trial_table import OUTCOMES, TrialTable, counted
from parkproof.report.violations import NAMED, against_proof
from parkproof.report.worst_trials import worst_of
from parkproof.scenario import Robot, RunSettings, Scenario, Start
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.trials import trials_of

KNOWN = Bounds(alpha=(0.9, 1.1), gamma=(1.0, 1.2), disturbance=0.5)
GAINS = Gains(q1="19/21", direction="toward")
STARTS = {"x0": (-0.1, 0.1), "x1": (0.0, 0.1), "x2": (0.0, 0.1), "u0": (0, 0), "u1": (0, 0)}


def table_at(directory, rows, *, begin=0, files=1):
    """A table of trials on disk, as a campaign writes it."""
    (directory / "trials").mkdir(parents=True)
    outcomes = [getattr(outcome, "value", outcome) for outcome in rows["outcome"]]
    columns = {name: pa.array(values) for name, values in rows.items() if name != "outcome"}
    table = pa.table(columns | {"outcome": outcomes})
    for part in np.array_split(np.arange(len(table)), files):
        range_of_file = (begin + int(part[0]), begin + int(part[-1]) + 1)
        pq.write_table(table.take(pa.array(part)), file_of(directory, range_of_file))
    return TrialTable(directory)


def few(**columns):
    """Rows with few columns."""
    n = len(next(iter(columns.values())))
    filled = {"outcome": [Outcome.PARKED] * n, "total": np.arange(1.0, n + 1.0)}
    filled |= {"residual": np.full(n, 1e-3), "ended": np.full(n, 15.0)}
    return filled | columns


@pytest.fixture(scope="module")
def certificate():
    found = certify(law="corrected", bounds=KNOWN, gains=GAINS, starts=STARTS)
    assert found.certificate is not None, found.reason
    return found.certificate


@pytest.fixture(scope="module")
def runs(certificate):
    return stressed_runs(certificate, count=96, seed=0, control_period=4e-3)


@pytest.fixture(scope="module")
def rows(runs):
    return simulate_ensemble(runs)


# ------------------------------------------------------------------------------- the table


def test_columns_of_several_files_stay_in_step(tmp_path, rows):
    table = table_at(tmp_path, rows, begin=7, files=3)
    assert len(table) == 96
    assert table.trials.tolist() == list(range(7, 103))
    assert table.column("total") == pytest.approx(rows["total"])
    assert [OUTCOMES[code] for code in table.outcomes] == rows["outcome"].tolist()
    assert counted(table.outcomes) == {Outcome.PARKED: 96}


def test_a_file_without_a_column_is_damaged(tmp_path):
    with pytest.raises(InputError, match="is damaged; remove it"):
        table_at(tmp_path, few(residual=[1.0])).column("peak_tau1")


def test_an_unknown_outcome_is_refused(tmp_path):
    table = table_at(tmp_path, few(outcome=["parked", "<b>lost</b>"]))
    with pytest.raises(InputError, match="outcome '<b>lost</b>' is none of parked, "):
        _ = table.outcomes


# --------------------------------------------------------------------------- shares, spreads


@pytest.mark.parametrize(
    ("parked", "trials", "low", "high"),
    # R: binom.test(parked, trials)$conf.int
    [(0, 10, 0.0, 0.3084971), (10, 10, 0.6915029, 1.0), (8, 10, 0.4439045, 0.9747893)],
)
def test_the_interval_of_the_share_is_exact(parked, trials, low, high):
    found = success_of(parked, trials)
    assert (found.low, found.high) == pytest.approx((low, high), abs=1e-7)


def test_no_trial_says_nothing_about_the_share():
    found = success_of(0, 0)
    assert (found.low, found.high) == (0.0, 1.0)


def test_what_has_no_value_is_counted_apart():
    spread = spread_of(np.array([2.0, np.nan, np.inf, 4.0]))
    assert (spread.count, spread.missing, spread.quantiles[2]) == (2, 2, 3.0)


def test_a_long_tail_is_drawn_over_its_logarithm_and_nothing_is_left_out():
    values = np.concatenate([np.zeros(3), np.geomspace(1e-4, 1e-3, 100), [1e3]])
    edges, logarithmic = edges_of(values)
    assert logarithmic
    assert edges[-1] == pytest.approx(1e3)
    assert not edges_of(np.linspace(-1.0, 1.0, 9))[1]


@pytest.mark.parametrize("values", [[], [np.nan], [3.0], [0.0, 0.0], [1.0, 2.0, 500.0]])
def test_every_histogram_can_be_drawn(values):
    drawn = histogram(SETTLING, np.array(values, dtype=float), bound=11.7)
    assert drawn.startswith(b"<?xml")


# -------------------------------------------------------------------- beside a certificate


def against(certificate, table, *, outside=None, duration=100.0):
    none = {"start": np.zeros(len(table), dtype=bool)}
    long_enough = np.full(len(table), duration >= certificate["claim"]["total_time"])
    return against_proof(certificate, table, outside or none, long_enough=long_enough)


def test_trials_within_the_assumptions_keep_every_number(tmp_path, certificate, runs, rows):
    flags = outside_assumptions(certificate, trials_of(runs))
    assert not any(flag.any() for flag in flags.values())
    found = against(certificate, table_at(tmp_path, rows), outside=flags)
    assert (found.violating, int(found.covered.sum()), found.outside) == (0, 96, {})
    assert {one.name.partition(" ")[0] for one in found.compared} == set(certificate["claim"])


@pytest.mark.parametrize(
    ("column", "value", "name"),
    [
        ("total", 1e3, "total_time"),
        ("peak_tau2", 1e3, "max_tau 2"),
        ("max_x1", 7.0, "max_abs_state x1"),
        ("max_heading", 1.5, "max_heading"),
        ("least_x0", -50.0, "x0_range -"),
        ("x1", -0.7, "x1_at_rest"),
    ],
)
def test_a_trial_beyond_a_proven_number_is_named(tmp_path, certificate, rows, column, value, name):
    changed = rows | {column: rows[column].copy()}
    changed[column][5] = value
    found = against(certificate, table_at(tmp_path, changed, begin=1000))
    (violation,) = found.named
    assert found.violating == 1
    assert violation.trial == 1005
    (broken,) = violation.broken
    assert (broken.name, broken.worst) == (name, abs(value))


def test_a_trial_that_does_not_park_contradicts_the_time_unless_it_was_too_short(
    tmp_path, certificate, rows
):
    outcome, total = rows["outcome"].copy(), rows["total"].copy()
    outcome[7], total[7] = Outcome.STILL_MOVING, np.nan
    table = table_at(tmp_path, rows | {"outcome": outcome, "total": total})
    (violation,) = against(certificate, table).named
    assert (violation.trial, violation.broken[0].worst) == (7, math.inf)
    short = certificate["claim"]["total_time"] - 0.1
    assert against(certificate, table, duration=short).violating == 0


def test_trials_outside_are_counted_by_reason_and_never_as_violations(tmp_path, certificate, rows):
    even, first = np.arange(96) % 2 == 0, np.arange(96) < 10
    flags = {"start outside": even, "ended early": first, "γ outside": np.zeros(96, dtype=bool)}
    table = table_at(tmp_path, rows | {"total": rows["total"] + 1e3})
    found = against(certificate, table, outside=flags)
    assert found.outside == {"start outside": 48, "ended early": 10}
    assert int(found.covered.sum()) == found.violating == 43
    assert len(found.named) == NAMED
    everything = {"all": np.ones(96, dtype=bool)}
    assert against(certificate, table, outside=everything).compared == ()


def trial(**changes):
    start = changes.pop("start", Start(state=(0.05, 0.05, 0.05, 0.0, 0.0)))
    return Scenario(law="corrected", bounds=KNOWN, gains=GAINS, start=start, **changes)


@pytest.mark.parametrize(
    ("truth", "reasons"),
    [
        ({"alpha": (0.9, 1.1)}, []),
        ({"alpha": (0.85, 1.1)}, ["α"]),
        ({"alpha": (1.0, Sine(mean=1.0, amplitude=0.2, omega=1.0))}, ["α"]),
        ({"gamma": (Constant(1.0), Constant(1.3))}, ["γ"]),
        ({"gamma": (Adversary(), Adversary()), "disturbance": (Adversary(), Adversary())}, []),
        ({"disturbance": (Sine(amplitude=0.5, omega=2.0), Constant(-0.5))}, []),
        ({"disturbance": (Sine(mean=0.1, amplitude=0.45, omega=2.0), Constant(0.0))}, ["φ"]),
        ({"b2": 1.01}, ["b2"]),
    ],
)
def test_a_truth_is_held_against_the_assumptions(certificate, truth, reasons):
    one = trial(truth=Truth(outside_bounds=True, **truth))
    flags = outside_assumptions(certificate, trials_of([one]))
    assert [why.partition(" ")[0] for why, flag in flags.items() if flag[0]] == reasons


@pytest.mark.parametrize(
    ("start", "inside"),
    [
        (Start(state=(0.1, 0.0, 0.1, 0.0, 0.0)), True),
        (Start(state=(0.1, 0.0, 0.1, 0.01, 0.0)), False),
        (Start(pose=(0.1, 0.1, math.atan(0.1))), True),
        (Start(pose=(0.1, 0.1, 0.11)), False),
        (Start(pose=(0.1, 0.1, 3.1)), False),
        (Start(pose=(0.0, 0.05, 0.0), velocity=(0.0, 0.02)), False),
    ],
)
def test_a_start_is_held_against_a_box_of_chained_states(certificate, start, inside):
    flags = outside_assumptions(certificate, trials_of([trial(start=start)]))
    assert flags["start outside the certified box"].tolist() == [not inside]


def test_a_chained_start_is_held_against_a_box_of_poses(certificate):
    box = {"x": [-1, 1], "y": [-1, 1], "theta": [0.4, 0.5], "v": [0.9, 1.2], "omega": [-1, 1]}
    poses = json.loads(json.dumps(certificate))
    poses["assumptions"]["starts"] = box
    # θ = 0.464, v = 0.9·√1.25 = 1.006
    inside, fast = (trial(start=Start(state=(0.0, 0.0, 0.5, u0, 0.0))) for u0 in (0.9, 1.1))
    turned = trial(start=Start(pose=(0.0, 0.0, 0.45), velocity=(1.0, 0.0)))
    flags = outside_assumptions(poses, trials_of([inside, fast, turned]))
    assert flags["start outside the certified box"].tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({}, None),
        ({"k": (2.0, 9.0), "hold": (2.0, 9.0)}, "other gains or other switching (hold, k)"),
        ({"return_steering": True}, "return_steering"),
        ({"bounds": Bounds(alpha=(0.9, 1.1), gamma=(1.0, 1.2), disturbance=0.6)}, "bounds of φ"),
        ({"bounds": Bounds(gamma=(1.0, 2.0), disturbance=0.5)}, None),
        ({"bounds": Bounds(gamma=(0.9, 1.2), disturbance=0.5)}, "lowest γ"),
        ({"to_step3": 20.0}, "at a given time"),
        ({"run": RunSettings(noise=1e-3)}, "noise"),
        ({"run": RunSettings(latency=0.01)}, "latency"),
        ({"robot": Robot(kind="torque")}, 'robot.kind = "torque"'),
        ({"limits": Limits(tau=(9.0, 9.0), saturate=True)}, "clipped"),
    ],
)
def test_what_all_trials_share_is_held_against_the_certificate(certificate, changes, word):
    gains = {name: changes[name] for name in ("k", "hold", "return_steering") if name in changes}
    shared = {"law": "corrected", "bounds": KNOWN, "switching": switching_of(certificate)}
    shared |= {name: value for name, value in changes.items() if name not in gains}
    if "to_step3" in shared:
        time = shared.pop("to_step3")
        shared["switching"] = msgspec.structs.replace(shared["switching"], to_step3=time)
    own = other_than_certified(
        certificate,
        Scenario(
            start=Start(pose=(0.0, 0.0, 0.0)),
            gains=msgspec.structs.replace(gains_of(certificate), **gains),
            **shared,
        ),
    )
    assert len(own) == (word is not None)
    assert word is None or word in own[0]


def test_limits_that_a_certified_run_may_reach_are_known(certificate):
    claim = certificate["claim"]
    tau, wide = claim["max_tau"], (-1e3, 1e3, -1e3, 1e3)
    assert tighter_limits(certificate, trial(limits=Limits(tau=tuple(tau), view=wide))) == set()
    tight = Limits(tau=(tau[0], 0.9 * tau[1]), speed=1e-3, view=(-0.2, 1e3, -1e3, 1e3))
    assert tighter_limits(certificate, trial(limits=tight)) == {
        Outcome.INPUT_LIMIT,
        Outcome.SPEED_LIMIT,
        Outcome.OUT_OF_VIEW,
    }


# ------------------------------------------------------------------------- the worst trials


def test_the_worst_do_not_park_then_are_slow_then_inexact(tmp_path):
    outcome = [Outcome.PARKED] * 6 + [Outcome.STILL_MOVING, Outcome.DIVERGED]
    total = [3.0, 4.0, 4.0, 9.0, 3.0, 1.0, np.nan, np.nan]
    residual = [0.1, 0.1, 0.3, 0.0, 0.1, 0.9, 5.0, np.nan]
    table = table_at(tmp_path, few(residual=residual, outcome=outcome, total=total))
    assert [one.trial for one in worst_of(table, count=7)] == [7, 6, 3, 2, 1, 0, 4]
    assert math.isnan(worst_of(table)[0].residual)
