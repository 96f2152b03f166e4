"""The page of a campaign: right whatever its trials were, and whole by itself."""

import json
import re
from html.parser import HTMLParser

import msgspec
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[campaign]")

from parkproof.bounds import Bounds
from parkproof.campaign.definition import campaign_from_dict, plain_of
from parkproof.campaign.directory import open_directory
from parkproof.campaign.draw import drawn_values, unit_numbers, values_at
from parkproof.campaign.ensembles import ensembles
from parkproof.campaign.prepare import prepare
from parkproof.campaign.run import run_campaign
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.model.signals import Sine
from parkproof.model.truth import Truth
from parkproof.proof.checker.certificate import digest_of
from parkproof.proof.whole_run import certify
from parkproof.report.campaign import write_report
from parkproof.report.campaign_coverage import TIGHTER, coverage_of
from parkproof.report.campaign_study import drawn_keys, study_of
from parkproof.report.sensitivity import sensitivity_of
from parkproof.report.trial_table import TrialTable
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.scenario_file import resolved
from parkproof.simulation.ensemble import simulate_trials

KNOWN = Bounds(alpha=(0.9, 1.1), gamma=(1.0, 1.2), disturbance=0.2)
GAINS = Gains(
    lambda1=10.215,
    k=(0.62777, 2.121),
    hold=(1.5032, 6.518),
    runup_speed=1.0324,
    direction="toward",
    return_steering=False,
    ellipsoid=(0.46055276, 0.2763446, 0.071801953, 0.21982455, 0.059686852, 0.023153942),
    feedback=(-13.199497, -11.571587, -4.0280169),
)
SWITCHING = Switching(
    tolerance=(0.10324, 0.01, 0.01), hysteresis=5.0, turn_tolerance=0.01, chart_limit=30.0
)
STARTS = {"x0": (-0.1, 0.1), "x1": (0.0, 0.1), "x2": (0.0, 0.1), "u0": (0, 0), "u1": (0, 0)}
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "wbr"}


@pytest.fixture(scope="module")
def certificate():
    found = certify(
        law="homogeneous", bounds=KNOWN, gains=GAINS, switching=SWITCHING, starts=STARTS
    )
    assert found.certificate is not None, found.reason
    return found.certificate


@pytest.fixture(scope="module")
def certificate_file(certificate, tmp_path_factory):
    path = tmp_path_factory.mktemp("certificates") / "certificate.json"
    path.write_text(json.dumps(certificate), encoding="utf-8")
    return path


def campaign_for(*, trials=8, distributions=None, **changes):
    """A campaign of the certificate's law; a third of its starts lie outside the certified box."""
    scenario = Scenario(
        **{
            "title": "Starts & <scales>",
            "law": "homogeneous",
            "bounds": KNOWN,
            "gains": GAINS,
            "switching": SWITCHING,
            "start": Start(pose=(0.0, 0.05, 0.05)),
            "run": RunSettings(
                duration=14.0, control_period=0.02, plant_step=0.01, discretisation="implicit"
            ),
        }
        | changes
    )
    drawn = distributions or {
        "start.pose[0]": {"kind": "uniform", "low": -0.1, "high": 0.2},
        "truth.alpha[0]": {"kind": "uniform", "low": 0.9, "high": 1.1},
    }
    data = {**resolved(scenario), "trials": trials, "seed": 1, "distributions": drawn}
    return campaign_from_dict(data, where="test")


def change(directory, **columns):
    """Change a table: each column by a function of its values."""
    for file in (directory / "trials").iterdir():
        table = pq.read_table(file)
        for name, changed in columns.items():
            values = changed(table[name].to_pylist())
            table = table.set_column(table.column_names.index(name), name, pa.array(values))
        pq.write_table(table, file)


class Checker(HTMLParser):
    """Whether tags are closed in order, and what the page would fetch."""

    def __init__(self):
        super().__init__()
        self.open, self.fetched, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        self.fetched += [
            value for name, value in attrs if name in {"src", "href", "srcset", "data", "action"}
        ]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def text_of(page):
    """The text of a page that is well-formed and fetches nothing."""
    source = page.read_text(encoding="utf-8")
    checker = Checker()
    checker.feed(source)
    assert checker.open == []
    assert all(value.startswith("data:image/") for value in checker.fetched)
    assert "@import" not in source
    assert "url(" not in source
    return re.sub(r"\s+", " ", " ".join(checker.text))


@pytest.fixture
def done(tmp_path):
    """A campaign that was carried out."""
    directory = tmp_path / "my runs"
    run_campaign(campaign_for(), directory)
    return directory


def test_the_page_says_how_many_parked_and_shows_the_worst_with_how_to_replay_them(done):
    command = "parkproof campaign a.toml --out 'my runs'"
    page = write_report(done, command=command, study=256)
    text = text_of(page)
    assert page == done / "report.html"
    assert "8 of 8 trials parked: 100 %" in text
    assert "63.0 % to 100 %" in text  # Clopper-Pearson: 0.025^(1/8) = 0.6306
    assert "The 8 worst trials" in text
    assert "Starts & <scales>" in text
    assert text.count(command) >= 5
    total = TrialTable(done).column("total")
    slowest = int(np.argmax(total))
    assert text.index(f"Trial {slowest}: parked after") < text.index("replay")
    assert f"parkproof replay '{done}' {slowest}" in text
    assert "Alarm" not in text
    assert page.read_text("utf-8").count("data:image/png") == 8


def test_the_study_is_of_the_campaigns_own_trials():
    campaign = campaign_for(trials=64)
    prepared = prepare(campaign, where="test")
    keys = drawn_keys(prepared)
    assert keys == ("start.pose[0]", "truth.alpha[0]")
    points = unit_numbers(2, 0, 64, seed=1, draws="sobol")
    drawn, again = drawn_values(campaign, 0, 64), values_at(campaign, points)
    assert all(np.array_equal(drawn[key], again[key]) for key in keys)
    ((members, scenario, trials),) = ensembles(prepared, again, np.arange(64), size=64)
    total = simulate_trials(scenario, trials)["total"]
    one = prepared.scenario_of(int(members[17]))
    assert trials.state[0, 17] == one.start.pose[0]
    assert np.isfinite(total).all()


def test_what_cannot_matter_has_no_share():
    drawn = {
        "start.pose[0]": {"kind": "uniform", "low": -0.1, "high": 0.2},
        "truth.disturbance[1].phase": {"kind": "uniform", "low": 0.0, "high": 6.28},
    }
    truth = Truth(disturbance=(Sine(amplitude=0.0, omega=1.0),) * 2)
    campaign = campaign_for(distributions=drawn, truth=truth)
    found = study_of(prepare(campaign, where="test"), trials=512)
    assert found.trials == 512
    assert found.total[1:, 1].tolist() == [0.0, 0.0]
    assert found.first[1:, 0] == pytest.approx([1.0, 1.0], abs=0.05)


def test_indices_are_those_known_of_the_ishigami_function():
    def ishigami(points):
        x, y, z = 2.0 * np.pi * points.T - np.pi
        value = np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
        return np.array([value, 0.0 * value])

    found = sensitivity_of(ishigami, ("x", "y", "z"), points=1024, seed=0)
    first, total = [0.3139, 0.4424, 0.0], [0.5576, 0.4424, 0.2437]
    assert found.first[0] == pytest.approx(first, abs=0.03)
    assert found.total[0] == pytest.approx(total, abs=0.03)
    low, high = found.total_range[:, 0]
    assert np.all((low <= total) & (total <= high))
    assert not found.total[1].any()
    again = sensitivity_of(ishigami, ("x", "y", "z"), points=1024, seed=0)
    assert np.array_equal(again.total_range, found.total_range)


def test_trials_inside_the_certificate_are_compared_and_others_said_to_be_outside(
    done, certificate_file
):
    text = text_of(write_report(done, certificate=certificate_file, study=0))
    outside = int((drawn_values(campaign_for(), 0, 8)["start.pose[0]"] > 0.1).sum())
    assert 0 < outside < 8
    assert f"It speaks of {8 - outside} of 8 trials. Not counted are:" in text
    assert f"start outside the certified box: {outside}" in text
    assert "max_abs_state x1" in text
    assert "Alarm" not in text


def test_a_violation_is_an_alarm_on_top_that_names_the_trials(done, certificate_file):
    inside = int(np.argmin(TrialTable(done).column("drawn.start.pose[0]")))
    outside = int(np.argmax(TrialTable(done).column("drawn.start.pose[0]")))

    def slow(values):
        return [50.0 if i in {inside, outside} else value for i, value in enumerate(values)]

    change(done, total=slow)
    page = write_report(done, certificate=certificate_file, study=0)
    text = text_of(page)
    assert "Alarm: 1 trial contradicts the certificate" in text
    assert text.index("Alarm") < text.index("How many parked")
    alarm = page.read_text("utf-8").partition('role="alert"')[2].partition("</div></div>")[0]
    assert f"<td>{inside}</td>" in alarm
    assert f"<td>{outside}</td>" not in alarm
    assert f"parkproof replay &#x27;{done}&#x27; {inside}" in alarm


def test_a_campaign_of_another_law_is_said_to_be_outside(tmp_path, certificate_file):
    other = msgspec.structs.replace(GAINS, lambda1=9.0)
    run_campaign(campaign_for(gains=other, trials=4), tmp_path / "out")
    text = text_of(write_report(tmp_path / "out", certificate=certificate_file, study=0))
    assert "It speaks of 0 of 4 trials." in text
    assert "another law, other gains or other switching (lambda1): 4" in text
    assert "Proved at most" not in text


def test_choices_that_split_a_campaign_are_held_against_the_certificate_one_by_one(
    tmp_path, certificate
):
    drawn = {
        "start.pose[0]": {"kind": "uniform", "low": -0.1, "high": 0.1},
        "gains.lambda1": {"kind": "choice", "values": [10.215, 9.0]},
        "run.duration": {"kind": "choice", "values": [5.0, 14.0]},
    }
    campaign = campaign_for(trials=24, distributions=drawn)
    run_campaign(campaign, tmp_path / "out")
    table = TrialTable(tmp_path / "out")
    found = coverage_of(certificate, prepare(campaign, where="test"), table)
    reason = "another law, other gains or other switching (lambda1)"
    assert list(found.outside) == [reason]
    other = table.column("drawn.gains.lambda1") < 10.0
    assert found.outside[reason].tolist() == other.tolist()
    long = table.column("drawn.run.duration") > 10.0
    assert found.long_enough.tolist() == long.tolist()
    assert TIGHTER not in found.outside


# ----------------------------------------------------------------------------- whatever the trials


def test_a_campaign_without_trials_yet_has_a_page(tmp_path, certificate_file):
    with open_directory(tmp_path / "out", plain_of(campaign_for())) as opened:
        opened.note(finished=False)
    text = text_of(write_report(tmp_path / "out", certificate=certificate_file))
    assert "0 of 8 trials were carried out" in text
    assert "No trial was carried out yet." in text


def test_an_unfinished_campaign_says_so(tmp_path):
    run_campaign(campaign_for(trials=3), tmp_path / "out")
    with open_directory(tmp_path / "out", plain_of(campaign_for(trials=9))):
        pass
    text = text_of(write_report(tmp_path / "out", study=0))
    assert "3 of 9 trials were carried out when this page was made" in text


def test_one_trial_and_one_drawn_quantity(tmp_path):
    one = {"start.pose[0]": {"kind": "uniform", "low": -0.1, "high": 0.2}}
    run_campaign(campaign_for(trials=1, distributions=one), tmp_path / "out")
    text = text_of(write_report(tmp_path / "out"))
    assert "1 of 1 trials parked" in text
    assert "Only start.pose[0] is drawn." in text
    assert "The 1 worst trials" not in text
    assert "The worst trial" in text


def test_none_parked(tmp_path):
    run = RunSettings(duration=0.5, control_period=0.02)
    run_campaign(campaign_for(run=run), tmp_path / "out")
    text = text_of(write_report(tmp_path / "out", study=256))
    assert "0 of 8 trials parked: 0 %" in text
    assert "No trial parked." in text
    assert "0 of 128 independent trials parked: too few parked to say" in text
    assert "The same in all of 128 independent trials." in text
    assert "still moving, run ended at 0.5 s" in text


def test_metrics_without_a_value_are_left_out_and_counted(done):
    change(
        done,
        residual=lambda values: [None if i % 2 else np.nan for i in range(len(values))],
        peak_tau1=lambda values: [np.inf] * len(values),
        excursion=lambda values: [np.nan, *values[1:]],
    )
    text = text_of(write_report(done, study=0))
    assert "A trial that has no value is left out: up to 8 of 8." in text
    assert "Residual in the last 2 s, 0 trials" in text
    assert "Largest distance from the goal, 7 trials" in text


# ------------------------------------------------------------------------------------ bad input


def test_what_is_no_campaign_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"no directory of a campaign \(it has no campaign.json\)"):
        write_report(tmp_path)


def test_a_certificate_that_is_none_or_not_proved_is_refused_before_anything_is_written(
    done, tmp_path, certificate
):
    wrong = {**certificate, "claim": {**certificate["claim"], "total_time": 1.0}}
    wrong["digest"] = digest_of(wrong)
    contents = {"unproved": (json.dumps(wrong), "is not proved"), "text": ("{}", "not a parkproof")}
    for name, (content, message) in contents.items():
        path = tmp_path / f"{name}.json"
        path.write_text(content, encoding="utf-8")
        with pytest.raises(InputError, match=message):
            write_report(done, certificate=path)
    with pytest.raises(InputError, match="cannot be read"):
        write_report(done, certificate=tmp_path / "none.json")
    assert not (done / "report.html").exists()


def test_a_page_that_cannot_be_written_leaves_the_earlier_one(done, monkeypatch):
    page = write_report(done, study=0)
    before = page.read_bytes()

    def full(*_args):
        raise InputError("cannot write: no space left on device")

    monkeypatch.setattr("parkproof.report.campaign.write_whole", full)
    with pytest.raises(InputError, match="no space left"):
        write_report(done, study=0)
    assert page.read_bytes() == before


def test_the_same_table_gives_the_same_page(done):
    first = write_report(done, study=256).read_bytes()
    assert write_report(done, study=256).read_bytes() == first
