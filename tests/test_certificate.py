"""Certificates of Step 2: enclosures contain, the proof proves, what is false is refused."""

import ast
import itertools
import json
import math
import random
import sys
from pathlib import Path

import pytest

flint = pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[proof]")

from flint import arb  # noqa: E402

from parkproof.bounds import Bounds  # noqa: E402
from parkproof.cli import main  # noqa: E402
from parkproof.laws.gains import Gains, Switching  # noqa: E402
from parkproof.model.truth import Truth  # noqa: E402
from parkproof.proof import verify  # noqa: E402
from parkproof.proof.certify import best_weights, certify_step2  # noqa: E402
from parkproof.proof.lyapunov import step2_lyapunov  # noqa: E402
from parkproof.scenario import RunSettings, Scenario, Start  # noqa: E402
from parkproof.simulation.run import simulate  # noqa: E402

PAPER = Gains(q1="9/11", l=(2.0, 4.2, 21.0))
WEIGHTS = (4.28, 311.0)


@pytest.fixture(scope="module")
def loop():
    return verify.Step2("9/11", PAPER.l, WEIGHTS, None)


@pytest.fixture(scope="module")
def certificate():
    found = certify_step2(Gains(q1="19/21", l=PAPER.l), b1=(0.5, 1.5), weights=(3.52, 58.9))
    assert found is not None
    return found.certificate


def signed(certificate, **changes):
    """The certificate with changes two levels deep, under a correct digest."""
    changed = json.loads(json.dumps(certificate))
    for path, value in changes.items():
        section, key = path.split("__")
        changed[section][key] = value
    changed["digest"] = verify.digest_of(changed)
    return changed


def test_the_verifier_imports_only_the_standard_library_and_the_arithmetic():
    tree = ast.parse(Path(verify.__file__).read_text(encoding="utf-8"))
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            names.add((node.module or "").split(".")[0])
    assert names - set(sys.stdlib_module_names) == {"flint"}


@pytest.mark.parametrize("varies", [False, True])
@pytest.mark.parametrize("radius", [0.0, 1e-6, 0.02, 0.3])
def test_boxes_enclose_the_values_at_their_points(varies, radius):
    draw = random.Random(f"{varies}{radius}")
    loop = verify.Step2("9/11", PAPER.l, WEIGHTS, 1.0 if varies else None)
    plain = step2_lyapunov(PAPER, k=WEIGHTS, constant_alpha=not varies)
    for _ in range(60):
        middle = [draw.choice([draw.uniform(-1, 1), 0.0, 1.0, -1.0]) for _ in range(3)]
        if not any(middle):
            continue
        box = tuple(arb(x, radius) for x in middle)
        b1 = draw.uniform(0.3, 2.0)
        value, rate = loop.value_and_rate(box, verify.exact(b1), arb(1))
        inside = [x + radius * draw.uniform(-1, 1) for x in middle]
        state = plain.state_at(*inside)
        slack = 1e-9 * (1.0 + abs(float(rate.mid())))
        for ball, number in (
            (value, float(plain.value(*state, alpha=b1))),
            (rate, float(plain.rate(*state, alpha=b1))),
        ):
            assert float(ball.lower()) - slack <= number <= float(ball.upper()) + slack


def test_the_rate_grows_with_b2_as_finite_differences_say(loop):
    """V̇ is affine in b1 and b2: its value at the middle is the mean of the corners' values."""
    z = (arb(1), arb("0.4"), arb("-0.7"))
    corners = [
        loop.value_and_rate(z, arb(b1), arb(b2))[1]
        for b1, b2 in itertools.product((0.5, 1.5), (0.8, 1.2))
    ]
    middle = loop.value_and_rate(z, arb(1), arb(1))[1]
    assert float(abs(sum(corners) / 4 - middle).upper()) < 1e-6 * abs(float(middle.mid()))
    assert abs(float((corners[1] - corners[0]).mid())) > 1e-3


def test_kernels_are_the_integrals_that_they_enclose():
    n = 7 / 11
    kernel = verify.Kernel(verify.exact("7/11"))
    for a, y in ((-1.3, 0.7), (0.2, 1.9), (-2.0, -0.4), (1.5, -0.3), (0.9, 0.1), (-0.5, 0.0)):
        low, high, count = min(a, y), max(a, y), 200_000
        total = [0.0, 0.0]
        for i in range(count):
            # |s| = t^(1/n) takes the singularity at 0 away: n|s|^(n−1) ds = dt
            ends = [math.copysign(abs(x) ** n, x) for x in (low, high)]
            t = ends[0] + (i + 0.5) / count * (ends[1] - ends[0])
            s = math.copysign(abs(t) ** (1 / n), t)
            width = (ends[1] - ends[0]) / count
            total[0] += abs(s - a) ** (1 - n) * width
            total[1] += abs(s - a) ** (2 - n) * width
        sign = 1.0 if y >= a else -1.0
        assert float(kernel.j(arb(a), arb(y)).mid()) == pytest.approx(sign * total[0], rel=1e-5)
        assert float(kernel.i(arb(a), arb(y)).mid()) == pytest.approx(total[1], rel=1e-5)


@pytest.mark.parametrize(("rate", "proved"), [("0.5", True), ("1.3", False), ("9", False)])
def test_a_rate_is_proved_just_where_sampling_leaves_room(loop, rate, proved):
    boxes = [verify.prove_rate(loop, arb(rate), arb(b1), arb(1)) for b1 in ("0.5", "1.5")]
    assert all(boxes) is proved


def test_the_papers_own_weights_prove_nothing():
    assert certify_step2(PAPER, b1=(0.5, 1.5), weights=(2.4, 17.5)) is None
    weak = verify.Step2("9/11", PAPER.l, (2.4, 17.5), None)
    assert verify.prove_rate(weak, arb("1e-6"), arb("1.5"), arb(1)) == 0


def test_the_figures_of_the_published_gains_are_reached(certificate):
    assert certificate["claim"]["rate"] >= 1.9
    assert verify.prove(verify.read(json.dumps(certificate)))


def test_gains_that_vary_in_time_are_certified():
    found = certify_step2(
        Gains(q1="13/15", l=PAPER.l), b1=(0.25, 1.5), varies=True, weights=(3.0, 120.0)
    )
    assert found is not None
    assert found.certificate["lyapunov"]["w"] == 1.0
    assert verify.prove(found.certificate)
    constant = signed(found.certificate, lyapunov__w=None)
    assert not verify.prove(constant)


def test_weights_are_found_that_nearly_reach_the_best_known():
    _, rate = best_weights(PAPER, b1=(0.5, 1.5), varies=False)
    assert rate > 1.2


def test_runs_settle_within_the_certified_time():
    found = certify_step2(PAPER, b1=(0.5, 1.5), weights=WEIGHTS)
    assert found is not None
    assert found.certificate["claim"]["step2_time"] <= 9.9
    for alpha in (0.5, 1.0, 1.5):
        scenario = Scenario(
            law="published",
            bounds=Bounds(alpha=(0.5, 1.5)),
            truth=Truth(alpha=(1.0, alpha)),
            gains=PAPER,
            start=Start(state=(0.0, 1.0, 0.0, 1.0, 0.0)),
            switching=Switching(tolerance=(1e-3, 1e-3, 1e-2)),
            run=RunSettings(duration=10.0, control_period=5e-3, discretisation="implicit"),
        )
        settled = simulate(scenario).settling_time.steps["2"]
        assert settled is not None
        assert settled < found.certificate["claim"]["step2_time"]


@pytest.mark.parametrize(
    "changes",
    [
        {"claim__rate": 2.5},
        {"claim__step2_time": 3.0},
        {"claim__total_time": 1.0},
        {"assumptions__b1": [0.5, 4.0]},
        {"assumptions__b2": [0.2, 3.0]},
        {"assumptions__b1_varies": True},
        {"assumptions__start": [[-9.0, 9.0], [0.0, 0.0], [0.0, 0.0]]},
        {"assumptions__start": [[0.0, 0.0]]},
        {"assumptions__b1": [-0.5, 1.5]},
        {"law__l": [2.0, 4.2, 5.0]},
        {"law__q1": "1/2"},
        {"lyapunov__k": [2.4, 17.5]},
        {"claim__rate": -1.0},
    ],
)
def test_a_false_or_stronger_claim_is_not_proved_under_a_correct_digest(
    certificate, changes, tmp_path
):
    path = tmp_path / "forged.json"
    path.write_text(json.dumps(signed(certificate, **changes)), encoding="utf-8")
    assert main(["verify", str(path)]) == 1


@pytest.mark.parametrize(
    "changes",
    [
        {"claim__step2_time": math.inf},
        {"lyapunov__k": [math.nan, 17.5]},
        {"law__l": "21"},
        {"assumptions__b1": None},
    ],
)
def test_numbers_of_no_kind_are_refused_under_a_correct_digest(certificate, changes, tmp_path):
    path = tmp_path / "forged.json"
    path.write_text(json.dumps(signed(certificate, **changes)), encoding="utf-8")
    assert main(["verify", str(path)]) == 2


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: text.replace("1.9", "2.9", 1),
        lambda text: text[:-20],
        lambda _: "{}",
        lambda _: "[]",
        lambda _: "",
        lambda text: text.replace("parkproof-certificate-1", "parkproof-certificate-9"),
    ],
)
def test_a_file_that_was_changed_is_refused(certificate, spoil, tmp_path, capsys):
    path = tmp_path / "spoilt.json"
    path.write_text(spoil(json.dumps(certificate)), encoding="utf-8")
    assert main(["verify", str(path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(("section", "key"), [("claim", "rate"), ("law", "l"), ("lyapunov", "w")])
def test_a_certificate_that_lacks_a_number_is_refused(certificate, section, key):
    broken = json.loads(json.dumps(certificate))
    del broken[section][key]
    with pytest.raises(verify.NotACertificateError):
        verify.prove(broken)


def test_the_commands_certify_and_verify(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("gains.toml").write_text(
        '[bounds]\nalpha = [0.5, 1.5]\n[gains]\nq1 = "19/21"\nl = [2.0, 4.2, 21.0]\n',
        encoding="utf-8",
    )
    assert main(["certify", "gains.toml", "--out", "c.json", "--quiet"]) == 0
    assert "and stays 0" in capsys.readouterr().out
    assert main(["certify", "gains.toml", "--out", "c.json", "--quiet"]) == 2
    assert main(["verify", "c.json"]) == 0
    assert capsys.readouterr().out.endswith("Proved.\n")
    weak = ["--set", "gains.l=[2.0, 1.0, 1.0]", "--out", "d.json", "--quiet"]
    assert main(["certify", "gains.toml", *weak]) == 1
    assert not Path("d.json").exists()


def test_a_missing_library_is_named_with_its_extra(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("parkproof.extras.find_spec", lambda _: None)
    assert main(["verify", str(tmp_path / "c.json")]) == 2
    assert "pip install 'parkproof[proof]'" in capsys.readouterr().err
