"""The reproduction of the paper: figures, claims and page, made once for all tests here."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest
from PIL import Image

from parkproof.report.claims import Verdict, claims_of
from parkproof.report.evidence import figure_runs, gather
from parkproof.report.findings import FINDINGS
from parkproof.report.reproduce import reproduce
from parkproof.results import read_trajectory


@pytest.fixture(scope="module")
def evidence():
    return gather(figure_runs(("published", "corrected")))


@pytest.fixture(scope="module")
def claims(evidence):
    return {claim.claim: claim for claim in claims_of(evidence)}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    directory = tmp_path_factory.mktemp("made") / "reproduction"
    directory.mkdir()
    told = []
    result = reproduce(directory, progress=lambda text, done: told.append((text, done)))
    return directory, result, told


def row_of(claims, start):
    (found,) = [claim for text, claim in claims.items() if text.startswith(start)]
    return found


def verdict_of(claims, start):
    return row_of(claims, start).verdict


def claims_with(evidence, **changes):
    return {claim.claim: claim for claim in claims_of(replace(evidence, **changes))}


def with_end(run, step, end):
    """The run as if one of its steps had ended at another time, or never."""
    times = msgspec.structs.replace(run.settling_time, steps={**run.settling_time.steps, step: end})
    return msgspec.structs.replace(run, settling_time=times)


@pytest.mark.parametrize(
    ("claim", "verdict"),
    [
        ("Step 1 brings u0 to 1", Verdict.HOLDS),
        ("Step 2 brings", Verdict.HOLDS),
        ("Step 3 brings (x0, u0)", Verdict.HOLDS),
        ("(x1, x2, u1) stay at zero in Step 3", Verdict.FAILS),
        ("After T3 both inputs can be set to zero", Verdict.FAILS),
        ("The gains of section 4 satisfy (15)-(17)", Verdict.FAILS),
        ("The gains of section 4 satisfy (18)", Verdict.FAILS),
        ("V3 with the weights", Verdict.FAILS),
        ("The search of Remark 3", Verdict.FAILS),
        ("k̃1, k̃2, k̃3", Verdict.HOLDS),
        ("Figure 3: u0 stays at 1", Verdict.HOLDS),
        ("Figure 4", Verdict.FAILS),
        ("The curves of Figures 3 to 8", Verdict.OPEN),
    ],
)
def test_each_claim_gets_the_verdict_that_its_run_shows(claims, claim, verdict):
    assert verdict_of(claims, claim) is verdict


def test_verdicts_follow_the_evidence(evidence, claims):
    """With the corrected run in the place of the published one the failed figures hold."""
    better = claims_with(
        evidence, figures={**evidence.figures, "published": evidence.figures["corrected"]}
    )
    for start in ("Figure 3: (x0, u0)", "Figure 4", "Figures 6-8", "After T3"):
        assert verdict_of(claims, start) is Verdict.FAILS
        assert verdict_of(better, start) is Verdict.HOLDS


def test_verdicts_on_settling_follow_the_runs(evidence):
    published = evidence.figures["published"]
    bound = 4.6 ** (2 / 3) / (2 / 3)  # (20) for |u0 − 1| = 4.6, λ1 = 1, q0 = 1/3
    for name, run in (("worst_step1", evidence.worst_step1), ("figures", published)):
        for end, verdict in (
            (bound - 1e-3, Verdict.HOLDS),
            (bound + 1e-3, Verdict.FAILS),
            (None, Verdict.FAILS),
        ):
            timed = with_end(run, "1", end)
            changed = timed if name == "worst_step1" else {**evidence.figures, "published": timed}
            assert verdict_of(claims_with(evidence, **{name: changed}), "Step 1 brings") is verdict
    endless = {**evidence.figures, "published": with_end(published, "3", None)}
    missed = claims_with(evidence, figures=endless)
    assert verdict_of(missed, "Step 3 brings (x0, u0)") is Verdict.FAILS
    assert verdict_of(missed, "After T3") is Verdict.FAILS
    backward = {**evidence.figures, "published": evidence.figures["corrected_fast"]}
    there = claims_with(evidence, figures=backward)
    assert verdict_of(there, "Figure 3: u0 stays at 1") is Verdict.FAILS
    stays = [
        replace(e, runs={**e.runs, "published": e.runs["corrected"]}) for e in evidence.redivergence
    ]
    one_left = [*stays[:-1], evidence.redivergence[-1]]
    start = "(x1, x2, u1) stay at zero"
    assert verdict_of(claims_with(evidence, redivergence=stays), start) is Verdict.HOLDS
    assert verdict_of(claims_with(evidence, redivergence=one_left), start) is Verdict.FAILS


@pytest.mark.parametrize(
    ("state", "failing"),
    [
        ("x0", {"Figure 3: (x0, u0)", "After T3", "Figures 6-8"}),
        ("u0", {"Figure 3: (x0, u0)", "After T3"}),
        ("x1", {"Figure 4", "Figures 6-8"}),
        ("x2", {"Figure 4", "Figures 6-8"}),
        ("u1", {"Figure 4"}),
    ],
)
def test_a_figure_fails_by_any_of_its_states(evidence, state, failing):
    """The corrected run, had one of its states been 0.03 off at the end."""
    run = evidence.figures["corrected"]
    off = {
        name: {**getattr(run.metrics, name), state: 0.03} for name in ("final", "residual_by_state")
    }
    nearly = msgspec.structs.replace(run, metrics=msgspec.structs.replace(run.metrics, **off))
    found = claims_with(evidence, figures={**evidence.figures, "published": nearly})
    figures = ("Figure 3: (x0, u0)", "After T3", "Figure 4", "Figures 6-8")
    assert {start for start in figures if verdict_of(found, start) is Verdict.FAILS} == failing


def test_verdicts_on_the_image_scales_follow_the_runs(evidence, claims):
    times = evidence.step2_times
    assert len(set(times.values())) == len(times) == 6
    for name in ("sines", "adversary"):
        assert times[0.5, name] > 1.5 * times[1.0, name]  # the smaller α2, the slower x1
    scales = "Unequal image scales"
    assert "4 of 4" in row_of(claims, scales).measured
    assert verdict_of(claims, scales) is Verdict.OPEN  # measured, but not as the image shows it
    unsettled = {
        key: claims_with(evidence, step2_times={**times, key: None})
        for key in ((1.0, "adversary"), (1.5, "sines"))
    }
    for found in unsettled.values():
        assert "5 of 6" in row_of(found, "Step 2 brings").measured
        assert verdict_of(found, "Step 2 brings") is Verdict.FAILS
    assert verdict_of(unsettled[1.0, "adversary"], scales) is Verdict.OPEN
    assert verdict_of(unsettled[1.5, "sines"], scales) is Verdict.FAILS
    assert "3 of 4" in row_of(unsettled[1.5, "sines"], scales).measured


def test_verdicts_on_gains_follow_the_conditions(evidence):
    holding, failing = evidence.remark4.conditions, evidence.step3
    ratios = {key: -abs(ratio) for key, ratio in evidence.ratios.items()}
    one_positive = {**ratios, ("9/11", "paper"): 0.1}
    changes = [
        ("V3 with the weights", {"ratios": ratios}, Verdict.HOLDS),
        ("V3 with the weights", {"ratios": one_positive}, Verdict.FAILS),
        ("The gains of section 4 satisfy (15)", {"printed": holding}, Verdict.HOLDS),
        ("The gains of section 4 satisfy (18)", {"step3": holding}, Verdict.HOLDS),
        (
            "The search of Remark 3",
            {"remark3": replace(evidence.remark3, found=evidence.sequential.gains)},
            Verdict.HOLDS,
        ),
        ("k̃1, k̃2", {"remark4": replace(evidence.remark4, conditions=failing)}, Verdict.FAILS),
    ]
    for start, change, verdict in changes:
        assert verdict_of(claims_with(evidence, **change), start) is verdict


def test_every_claim_says_where_and_what_was_measured(claims):
    assert len(claims) >= 20
    for claim in claims.values():
        assert claim.where
        assert len(claim.measured) > 20
        assert "nan" not in claim.measured


def test_the_published_law_explodes_in_step_3_and_the_corrected_does_not(made):
    directory, _, _ = made
    published = read_trajectory(directory / "published" / "trajectory.parquet")
    corrected = read_trajectory(directory / "corrected" / "trajectory.parquet")
    for trajectory, exploded in ((published, True), (corrected, False)):
        at_switch = np.abs(trajectory["x1"][np.searchsorted(trajectory["t"], 24.99)])
        late = np.max(np.abs(trajectory["x1"][trajectory["t"] > 25.0]))
        assert at_switch < 1e-2
        assert bool(late > 100.0) is exploded
        u0 = trajectory["u0"][(trajectory["t"] > 5.0) & (trajectory["t"] < 25.0)]
        assert np.max(np.abs(u0 - 1.0)) < 0.02
        assert np.min(trajectory["u0"]) < -5.0


def test_the_fast_corrected_run_parks_long_before_the_paper_does(made):
    _, result, _ = made
    assert result["runs"]["corrected_fast"]["outcome"] == "parked"
    assert result["runs"]["corrected_fast"]["settling_time"]["total"] < 10.0
    assert result["runs"]["published"]["settling_time"]["total"] is None


def test_all_figures_are_there_and_are_pictures(made):
    directory, _, _ = made
    for name in ("published", "corrected", "corrected_fast"):
        for number in range(3, 9):
            with Image.open(directory / name / f"figure{number}.png") as image:
                assert image.width > 800
                assert image.convert("L").getextrema()[0] < 100
            assert "<svg" in (directory / name / f"figure{number}.svg").read_text()[:2000]
        summary = json.loads((directory / name / "summary.json").read_text())
        assert summary["law"] in name
    for finding in FINDINGS:
        assert (directory / "findings" / f"{finding}.png").stat().st_size > 10_000


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.sources, self.rows, self.open = [], 0, []

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.sources += [found[key] for key in ("src", "href") if key in found]
        self.rows += tag == "tr"
        if tag not in ("img", "meta", "link", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_is_whole_and_needs_no_other_file(made):
    directory, result, _ = made
    text = (directory / "index.html").read_text(encoding="utf-8")
    page = _Page()
    page.feed(text)
    assert page.open == []
    assert len(page.sources) == 3 * 6 + len(FINDINGS)
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert page.rows >= len(result["claims"])
    assert not re.search(r"\$[a-z]|https?://", text)


def test_progress_only_grows_and_ends_at_one(made):
    _, _, told = made
    fractions = [done for _, done in told]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_one_law_alone_leaves_the_other_out(tmp_path, monkeypatch, evidence):
    from parkproof.report import reproduce as module

    monkeypatch.setattr(module, "gather", lambda _runs, **_: evidence)
    result = reproduce(tmp_path, laws=("published",))
    assert list(result["runs"]) == ["published"]
    assert sorted(p.name for p in tmp_path.iterdir() if p.is_dir()) == ["findings", "published"]
