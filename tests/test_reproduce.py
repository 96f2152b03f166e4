"""The reproduction of the paper: figures, claims and page, made once for all tests here."""

import json
import re
from html.parser import HTMLParser

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


def verdict_of(claims, start):
    (found,) = [claim.verdict for text, claim in claims.items() if text.startswith(start)]
    return found


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
    from dataclasses import replace

    mended = replace(
        evidence, figures={**evidence.figures, "published": evidence.figures["corrected"]}
    )
    better = {claim.claim: claim for claim in claims_of(mended)}
    for start in ("Figure 3: (x0, u0)", "Figure 4", "Figures 6-8", "After T3"):
        assert verdict_of(claims, start) is Verdict.FAILS
        assert verdict_of(better, start) is Verdict.HOLDS


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
