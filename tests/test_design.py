"""Designs: limits are kept by proof, what cannot be is refused with what would do."""

import json
import tomllib
from pathlib import Path

import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("clarabel", reason="needs parkproof[proof]")

from parkproof.bounds import Bounds, Limits
from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.candidates import HomogeneousEngine, Knobs, PaperEngine
from parkproof.proof.checker.certificate import why_not
from parkproof.proof.design import design, engines
from parkproof.proof.find_links import approach_link, two_chain_link
from parkproof.proof.limits import over_limits
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
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


def test_each_engine_is_made_where_it_is_asked_for():
    kinds = [type(engine) for engine in engines(spec_with("homogeneous"), lambda _: None)]
    assert kinds == [HomogeneousEngine]
    papers = [type(engine) for engine in engines(spec_with("paper"), lambda _: None)]
    assert papers
    assert set(papers) == {PaperEngine}


def test_a_faster_return_costs_input():
    (engine,) = engines(spec_with(), lambda _: None)
    slow, fast = (engine.candidate(Knobs(0.3, 18.0, 1.0, back)) for back in (0.5, 1.0))
    assert fast.time < slow.time
    assert fast.tau[0] > slow.tau[0]


@pytest.mark.parametrize(
    ("limits", "bounds", "said"),
    [
        (Limits(tau=(0.4, 20.0)), KNOWN, r"limits.tau\[0\] = 0.4.*above 0.5"),
        (Limits(tau=(20.0, 0.5)), KNOWN, r"limits.tau\[1\] = 0.5.*above 0.5"),
        (Limits(view=(-0.1, 2.0, -1.0, 1.0)), KNOWN, r"view.*starts reach from \(-0.2"),
    ],
)
def test_what_no_gains_can_do_is_refused_with_the_reason(limits, bounds, said):
    with pytest.raises(InputError, match=said):
        design(Spec(bounds=bounds, starts=NEAR, limits=limits))


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
