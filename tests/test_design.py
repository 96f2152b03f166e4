"""Designs: limits are kept by proof, what cannot be is refused with what would do."""

import json
import tomllib
from pathlib import Path

import msgspec
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("clarabel", reason="needs parkproof[proof]")

from parkproof.bounds import Bounds, Limits
from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof import design as designing
from parkproof.proof import find_links
from parkproof.proof.candidates import Knobs
from parkproof.proof.checker.certificate import why_not
from parkproof.proof.design import design, two_chain_forms
from parkproof.proof.engines import HomogeneousEngine, directions_of
from parkproof.proof.find_links import approach_link, sampled_approach_link, two_chain_link
from parkproof.proof.knob_search import KnobSearch
from parkproof.proof.limits import over_limits
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
from parkproof.proof.shapes import KNOWN_SHAPES, ShapeSearch, normal_ranges
from parkproof.scenario_file import template
from parkproof.spec import Aim, Spec, Starts, read_spec

NEAR = Starts(x0=(-0.2, 0.2), x1=(-0.1, 0.1), x2=(-0.1, 0.1))
KNOWN = Bounds(alpha=(0.8, 1.2), gamma=(1.0, 1.5), disturbance=0.5)


def spec_with(engine="homogeneous", limits=None, **aim):
    return Spec(
        bounds=KNOWN,
        starts=NEAR,
        limits=limits or Limits(tau=(20.0, 20.0), view=(-2.0, 2.0, -2.0, 2.0)),
        design=Aim(engine=engine, **aim),
    )


@pytest.fixture(scope="module")
def found():
    return design(spec_with(), sweep=4, steps=8)


def test_a_design_keeps_its_limits_by_proof(found):
    claim = found.certificate["claim"]
    assert max(claim["max_tau"]) <= 20.0
    assert -2.0 <= claim["x0_range"][0] <= claim["x0_range"][1] <= 2.0
    assert found.certificate["law"]["name"] == "homogeneous"
    assert why_not(found.certificate) == ""
    assert not over_limits(found.chosen, found.spec)


@pytest.mark.parametrize("speed", [0.4, 1.7])
def test_scaled_links_are_proved(speed):
    k, link = TwoChainForm("7/9", (1.5, 6.5), two_chain_link("7/9", (1.5, 6.5), (0.8, 1.2))).scaled(
        speed
    )
    assert k[0] == pytest.approx(1.5 * speed)
    assert link.proved([(0.8, 1.2)], (1.0, 1.0), 0.0)
    shape = (2.0, 4.2, 21.0)
    found = approach_link(Gains(q1="19/21", l=shape), [(0.8, 1.2), (1.0, 1.0)])
    _, link = ThreeChainForm("19/21", shape, found).scaled(speed, 0.3)
    assert link.proved([(0.8 * 0.3, 1.2 * 0.3), (1.0, 1.0)], (1.0, 1.0), 0.0)


OF_THE_PAPER = msgspec.structs.replace(spec_with("paper"), bounds=Bounds(disturbance=0.5))


FEW_BOXES = (0.7,)
"""Share of a sampled rate that is quickly proved."""


@pytest.fixture(scope="module")
def of_the_paper():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(find_links, "SHARES", FEW_BOXES)
        return design(OF_THE_PAPER, sweep=3, steps=4)


def test_the_papers_engine_finds_a_shape_of_its_own_and_proves_it(of_the_paper):
    law = of_the_paper.certificate["law"]
    assert law["name"] == "corrected"
    assert why_not(of_the_paper.certificate) == ""
    cruise = law["runup_speed"]
    for q, l in KNOWN_SHAPES:  # noqa: E741
        speed = law["l"][0] * cruise / l[0]
        link = {"k": (1.0, 1.0), "s": (0.0, 0.0), "rate": 1.0, "sizes": (1.0,) * 4}
        gains, _ = ThreeChainForm(q, l, link).scaled(speed, cruise)
        assert q != law["q1"] or gains != pytest.approx(law["l"], rel=1e-2)


def test_the_papers_engine_is_no_worse_than_its_known_shapes(of_the_paper, monkeypatch):
    monkeypatch.setattr(find_links, "SHARES", FEW_BOXES)
    spec = of_the_paper.spec
    shapes = ShapeSearch(spec, *two_chain_forms(spec))
    for q, l in KNOWN_SHAPES:  # noqa: E741
        link = sampled_approach_link(Gains(q1=q, l=l), normal_ranges(spec))
        known = KnobSearch(shapes.engine(ThreeChainForm(q, l, link), "toward"), spec, [])
        known.sweep(8)
        known.descend_at_once(60)
        assert of_the_paper.chosen.price(spec) < known.price


def test_what_is_sampled_is_close_to_what_is_proved():
    ranges, gains = normal_ranges(spec_with()), Gains(q1="5/7", l=(1.0, 2.5, 14.4))
    sampled, proved = sampled_approach_link(gains, ranges), approach_link(gains, ranges)
    assert sampled["k"] == proved["k"]
    assert proved["rate"] <= sampled["rate"] * 1.001
    assert sampled["sizes"] == pytest.approx(proved["sizes"], rel=0.02)


def test_shapes_that_sampling_finds_worse_are_not_proved(monkeypatch):
    monkeypatch.setattr(designing, "approach_link", lambda *_: pytest.fail("proved"))
    spec = Spec(bounds=KNOWN, starts=NEAR, limits=Limits(tau=(20.0, 20.0)))
    assert design(spec, sweep=2, steps=2).certificate["law"]["name"] == "homogeneous"


def test_a_search_of_shapes_that_is_interrupted_proves_the_best_so_far(monkeypatch):
    monkeypatch.setattr(find_links, "SHARES", FEW_BOXES)

    def interrupt(doing, share):
        if doing.startswith("shapes") and share > 0.3:
            raise KeyboardInterrupt

    found = design(OF_THE_PAPER, sweep=4, steps=4, progress=interrupt)
    assert found.interrupted
    assert len(found.looked_at) == 1
    assert why_not(found.certificate) == ""


AHEAD = Spec(
    bounds=KNOWN,
    starts=Starts(x0=(-0.02, 0.02), x1=(-0.1, 0.1), x2=(-0.1, 0.1)),
    limits=Limits(tau=(20.0, 20.0), view=(-0.05, 5.0, -2.0, 2.0)),
    design=Aim(engine="homogeneous"),
)


def test_a_view_to_one_side_is_served_by_driving_to_that_side():
    found = design(AHEAD, sweep=2, steps=4)
    claim = found.certificate["claim"]
    assert found.certificate["law"]["direction"] == "forward"
    assert claim["x0_range"][0] >= -0.05
    assert claim["x0_range"][1] > 0.05
    assert why_not(found.certificate) == ""


def test_a_view_to_one_side_is_not_served_by_driving_toward_the_goal(monkeypatch):
    monkeypatch.setattr(designing, "directions_of", lambda _: ("toward",))
    found = design(AHEAD, sweep=2, steps=2)
    assert found.certificate is None
    assert "limits.view" in found.reason


def test_the_shapes_of_a_view_to_the_other_side_are_sought_for_driving_backward():
    view = Limits(tau=(20.0, 20.0), view=(-5.0, 0.05, -2.0, 2.0))
    spec = msgspec.structs.replace(AHEAD, limits=view)
    shapes = ShapeSearch(spec, *two_chain_forms(spec))
    shapes.run(0, 0)
    best = shapes.ranked()[0]
    found = {
        way: shapes.engine(best.form, way).candidate(best.knobs) for way in directions_of(spec)
    }
    assert not over_limits(found["backward"], spec)
    assert over_limits(found["toward"], spec)
    assert over_limits(found["forward"], spec)


@pytest.mark.parametrize("ways", [("toward", "forward"), ("toward", "auto"), ("forward", "auto")])
def test_of_mirrored_starts_the_direction_left_out_has_no_better_bounds(ways):
    spec = spec_with()
    assert directions_of(spec) == ("toward",)
    first, other = (
        HomogeneousEngine(spec, *two_chain_forms(spec), way).candidate(Knobs(0.3, 18.0, 1.0, 0.7))
        for way in ways
    )
    assert first.time <= other.time
    assert first.travel <= other.travel
    assert max(first.tau) <= max(other.tau)


def test_gains_beyond_those_that_a_law_takes_make_no_candidate():
    spec = spec_with("paper")
    link = {"k": (1.0, 1.0), "s": (0.0, 0.0), "rate": 1.0, "sizes": (1.0,) * 4}
    form = ThreeChainForm("9/13", (1.0, 2.3, 3e6), link)
    engine = ShapeSearch(spec, *two_chain_forms(spec)).engine(form, "toward")
    assert engine.candidate(Knobs(0.05, 6.0, 1.0, 1.0)) is None


def test_a_faster_return_costs_input():
    spec = spec_with()
    engine = HomogeneousEngine(spec, *two_chain_forms(spec), "toward")
    slow, fast = (engine.candidate(Knobs(0.3, 18.0, 1.0, back)) for back in (0.5, 1.0))
    assert fast.time < slow.time
    assert fast.tau[0] > slow.tau[0]


@pytest.mark.parametrize(
    ("limits", "bounds", "said"),
    [
        (Limits(tau=(0.4, 20.0)), KNOWN, r"limits.tau\[0\] = 0.4.*above 0.5"),
        (Limits(tau=(20.0, 0.5)), KNOWN, r"limits.tau\[1\] = 0.5.*above 0.5"),
        (Limits(view=(-0.1, 2.0, -1.0, 1.0)), KNOWN, r"view.*starts reach from \(-0.2"),
        (Limits(view=(-0.5, 0.5, 0.0, 1.0)), KNOWN, r"view.*starts reach from \(-0.2"),
    ],
)
def test_what_no_gains_can_do_is_refused_with_the_reason(limits, bounds, said):
    with pytest.raises(InputError, match=said):
        design(Spec(bounds=bounds, starts=NEAR, limits=limits))


def test_a_view_without_the_goal_is_refused():
    ahead = Starts(x0=(1.0, 2.0), x1=(-0.1, 0.1), x2=(-0.1, 0.1))
    limits = Limits(view=(0.5, 5.0, -2.0, 2.0))
    with pytest.raises(InputError, match="the goal"):
        design(Spec(bounds=KNOWN, starts=ahead, limits=limits))


def test_a_limit_that_cannot_be_kept_is_named_with_what_would_do():
    limits = Limits(tau=(20.0, 20.0), view=(-0.21, 0.21, -2.0, 2.0))
    found = design(spec_with(limits=limits), sweep=4, steps=4)
    assert found.certificate is None
    assert "limits.view binds" in found.reason
    assert "limits.view[1] = " in found.reason
    assert "would do, 0.21 does not" in found.reason


def test_an_interrupted_search_certifies_the_best_so_far():
    calls = []

    def interrupt(doing, share):
        if doing == "homogeneous engine":
            calls.append(share)
            if len(calls) == 3:
                raise KeyboardInterrupt

    found = design(spec_with(), sweep=8, steps=8, progress=interrupt)
    assert found.interrupted
    assert why_not(found.certificate) == ""


def test_the_template_is_the_case_of_the_documentation(tmp_path):
    file = tmp_path / "spec.toml"
    file.write_text(template("design"), encoding="utf-8")
    spec = read_spec(file)
    assert spec.limits.tau == (40.0, 40.0)
    assert spec.starts.ranges["x1"] == (-0.5, 0.5)
    assert spec.starts.ranges["u0"] == (0.0, 0.0)


def test_the_command_leaves_files_that_other_commands_take(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(
        "[bounds]\nalpha = [0.9, 1.1]\n[limits]\ntau = [30.0, 30.0]\n"
        "[starts]\nx0 = [-0.2, 0.2]\nx1 = [-0.1, 0.1]\nx2 = [0.0, 0.0]\n"
        '[design]\nengine = "homogeneous"\ncontrol_period = 0.005\n',
        encoding="utf-8",
    )
    assert main(["design", "spec.toml", "--effort", "0.1", "--quiet"]) == 0
    made = {path.name for path in Path("designs/spec").iterdir()}
    assert {"gains.toml", "certificate.json", "summary.json", "scenario.toml"} <= made
    assert {"tradeoff.png", "settling_map.png"} <= made
    assert main(["verify", "designs/spec/certificate.json"]) == 0
    assert main(["certify", "designs/spec/gains.toml", "--quiet"]) == 0
    assert main(["park", "designs/spec/scenario.toml", "--check", "--no-pictures", "--quiet"]) == 0
    measured = json.loads(Path("designs/spec/summary.json").read_text())["measured"]
    assert measured["parked"] == measured["runs"]
    gains = tomllib.loads(Path("designs/spec/gains.toml").read_text())["gains"]
    assert gains["return_steering"] is False


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[bounds]\nalpha = [1.5, 0.5]", "crossed"),
        ("[bounds]\nb2 = [0.0, 1.0]", "b2"),
        ("[bounds]\ndisturbance = 3.0\n[limits]\ntau = [2.0, 9.0]", "above 3"),
        ("[bounds]\n[limits]\nview = [-0.5, 0.5, -1.0, 1.0]", "widen the view"),
    ],
)
def test_what_no_gains_can_do_has_no_design(text, said, tmp_path, capsys):
    file = tmp_path / "spec.toml"
    file.write_text(text, encoding="utf-8")
    assert main(["design", str(file), "--out", str(tmp_path / "out")]) == 1
    assert said in " ".join(capsys.readouterr().out.split())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("[bounds]\n[starts]\nx0 = [0.0, 1.0]", "x1 is missing"),
        ("[bounds]\n[starts]\nx0=[0.0, 1.0]\nx=[0.0,1.0]\ny=[0.0,1.0]\ntheta=[0.0,1.0]", "x0 does"),
        ('[bounds]\n[design]\naim = "input"', "time_limit"),
        ('[bounds]\n[design]\naim = "tme"', "aim"),
        ("[bounds]\n[desing]\n", "did you mean"),
        ("[bounds]\n[design]\ntolerance = nan", "tolerance"),
        ("[bounds]\n[design]\ntolerance = 0.2", "x1_at_rest"),
    ],
)
def test_a_specification_that_makes_no_sense_is_refused_in_one_line(text, said, tmp_path, capsys):
    file = tmp_path / "spec.toml"
    file.write_text(text, encoding="utf-8")
    assert main(["design", str(file), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error
    assert not (tmp_path / "out").exists()
