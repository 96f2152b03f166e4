"""Certificates: enclosures contain, the proof proves, what is false is refused."""

import ast
import itertools
import json
import math
import random
import sys
from pathlib import Path

import jsonschema
import pytest

flint = pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[proof]")

from flint import arb  # noqa: E402

from parkproof.bounds import Bounds  # noqa: E402
from parkproof.cli import main  # noqa: E402
from parkproof.laws.gains import Gains, Switching  # noqa: E402
from parkproof.proof import checker  # noqa: E402
from parkproof.proof.checker.balls import exact, largest, point_power  # noqa: E402
from parkproof.proof.checker.certificate import (  # noqa: E402
    NotACertificateError,
    digest_of,
    read,
    why_not,
)
from parkproof.proof.checker.chains import ThreeChain, TwoChain  # noqa: E402
from parkproof.proof.checker.kernels import Kernel  # noqa: E402
from parkproof.proof.checker.lemmas import level_of, prove_rate, prove_sizes  # noqa: E402
from parkproof.proof.checker.statement import statement_of  # noqa: E402
from parkproof.proof.lyapunov import step2_lyapunov  # noqa: E402
from parkproof.proof.weights import best_weights  # noqa: E402
from parkproof.proof.whole_run import certify  # noqa: E402

PAPER = Gains(q1="9/11", l=(2.0, 4.2, 21.0))
WEIGHTS = (4.28, 311.0)
SMALL = {"x0": (-0.3, 0.3), "x1": (-0.2, 0.2), "x2": (0.0, 0.0), "u0": (0, 0), "u1": (0, 0)}


@pytest.fixture(scope="module")
def loop():
    return ThreeChain("9/11", PAPER.l, WEIGHTS, None)


@pytest.fixture(scope="module")
def certificate():
    gains = Gains(q1="19/21", direction="toward", return_steering=False)
    found = certify(law="corrected", bounds=Bounds(alpha=(0.8, 1.2)), gains=gains, starts=SMALL)
    assert found.certificate is not None, found.reason
    return found.certificate


def signed(certificate, path, value):
    """The certificate with a change, under a correct digest."""
    changed = json.loads(json.dumps(certificate))
    *places, last = path.split("__")
    section = changed
    for place in places:
        section = section[int(place) if place.isdigit() else place]
    section[int(last) if last.isdigit() else last] = value
    changed["digest"] = digest_of(changed)
    return changed


def test_the_checker_imports_only_the_standard_library_and_the_arithmetic():
    for file in Path(checker.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0
                names = [node.module or ""]
            for name in names:
                own = name.startswith("parkproof.proof.checker.")
                assert own or name.split(".")[0] in {*sys.stdlib_module_names, "flint"}, file


@pytest.mark.parametrize("varies", [False, True])
@pytest.mark.parametrize("radius", [0.0, 1e-6, 0.02, 0.3])
def test_boxes_enclose_the_values_at_their_points(varies, radius):
    draw = random.Random(f"{varies}{radius}")
    loop = ThreeChain("9/11", PAPER.l, WEIGHTS, 1.0 if varies else None)
    plain = step2_lyapunov(PAPER, k=WEIGHTS, constant_alpha=not varies)
    for _ in range(60):
        middle = [draw.choice([draw.uniform(-1, 1), 0.0, 1.0, -1.0]) for _ in range(3)]
        if not any(middle):
            continue
        box = tuple(arb(x, radius) for x in middle)
        b1 = draw.uniform(0.3, 2.0)
        value, rate = loop.value_and_rate(box, exact(b1), arb(1))
        inside = [x + radius * draw.uniform(-1, 1) for x in middle]
        state = plain.state_at(*inside)
        slack = 1e-9 * (1.0 + abs(float(rate.mid())))
        for ball, number in (
            (value, float(plain.value(*state, alpha=b1))),
            (rate, float(plain.rate(*state, alpha=b1))),
        ):
            assert float(ball.lower()) - slack <= number <= float(ball.upper()) + slack


def test_the_slope_of_v_is_affine_in_the_gains_and_b2_counts(loop):
    z = (arb(1), arb("0.4"), arb("-0.7"))
    corners = [
        loop.value_and_rate(z, arb(b1), arb(b2))[1]
        for b1, b2 in itertools.product((0.5, 1.5), (0.8, 1.2))
    ]
    middle = loop.value_and_rate(z, arb(1), arb(1))[1]
    assert float(abs(sum(corners) / 4 - middle).upper()) < 1e-6 * abs(float(middle.mid()))
    assert abs(float((corners[1] - corners[0]).mid())) > 1e-3


def test_the_slope_of_v_for_two_integrators_is_that_of_differences():
    q, k1, k3, k2, b = 7 / 9, 1.5, 6.5, 7.4, 0.8
    chain = TwoChain("7/9", (k1, k3), k2)
    draw = random.Random(2)

    def value(x, u):
        y = math.copysign(abs(u) ** (1 / q), u)
        return float(chain.value((exact(x), exact(y)), arb(1)).mid())

    for _ in range(20):
        x, u = draw.uniform(-2, 2), draw.uniform(-2, 2)
        y, K1 = math.copysign(abs(u) ** (1 / q), u), k1 ** (1 / q)
        xi = y + K1 * x
        push = -k3 * math.copysign(abs(xi) ** (2 * q - 1), xi)
        h = 1e-5
        slope = (value(x + h * b * u, u + h * push) - value(x - h * b * u, u - h * push)) / (2 * h)
        _, rate = chain.value_and_rate((exact(x), exact(xi / K1)), exact(b))
        assert float(rate.mid()) == pytest.approx(slope, rel=1e-3, abs=1e-3)


def test_kernels_are_the_integrals_that_they_enclose():
    n = 7 / 11
    kernel = Kernel(exact("7/11"))
    for a, y in ((-1.3, 0.7), (0.2, 1.9), (-2.0, -0.4), (1.5, -0.3), (0.9, 0.1), (-0.5, 0.0)):
        low, high, count = min(a, y), max(a, y), 100_000
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


@pytest.mark.parametrize(("rate", "proved"), [(0.5, True), (1.3, False), (9.0, False)])
def test_a_rate_is_proved_just_where_sampling_leaves_room(loop, rate, proved):
    assert bool(prove_rate(loop, rate, [(0.5, 1.5), (1.0, 1.0)])) is proved


def test_the_papers_own_weights_prove_nothing():
    """The state (1, −2, −2) of D2, where V grows, is on the surface."""
    weak = ThreeChain("9/11", PAPER.l, (2.4, 17.5), None)
    assert prove_rate(weak, 1e-6, [(1.5, 1.5), (1.0, 1.0)]) == 0


@pytest.mark.parametrize(("q", "reached"), [("13/15", 1.7), ("19/21", 1.9)])
def test_the_rates_of_the_published_gains_are_reached(q, reached):
    (k1, k2), rate = best_weights(Gains(q1=q, l=PAPER.l), b1=(0.5, 1.5), varies=False, start=None)
    assert rate > reached
    chain = ThreeChain(q, PAPER.l, (k1, k2), None)
    assert prove_rate(chain, reached, [(0.5, 1.5), (1.0, 1.0)]) > 0


def test_sizes_hold_at_random_states_and_are_not_proved_when_too_small():
    chain = TwoChain("7/9", (1.5, 6.5), 7.4)
    sizes = (2.04, 27.4, 20.0)
    assert prove_sizes(chain, sizes) > 0
    assert prove_sizes(chain, (1.9, 27.4, 20.0)) == 0
    draw = random.Random(1)
    for _ in range(100):
        x, y = draw.uniform(-3, 3), draw.uniform(-3, 3)
        value = float(chain.value((exact(x), exact(y)), arb(1)).mid())
        assert x * x <= sizes[0] * value
        assert y * y <= sizes[1] * value


def test_what_is_no_number_bounds_nothing():
    for numbers in ((arb("nan"), arb(3)), (arb(3), arb("nan")), (arb(1), arb("inf"))):
        with pytest.raises(ValueError, match="not finite"):
            largest(*numbers)
    for ball in (arb(0, 1), arb("nan")):
        with pytest.raises(ValueError, match="holds 0"):
            point_power(ball, arb("0.5"))


def test_a_level_is_nowhere_exceeded_on_its_box():
    chain = ThreeChain("9/11", PAPER.l, WEIGHTS, 1.0)
    box = [(exact(-0.5), exact(0.2)), (exact(-1.0), exact(1.0)), (exact(0.0), exact(2.0))]
    level = level_of(chain, box)
    draw = random.Random(3)
    for _ in range(300):
        state = [draw.uniform(float(low), float(high)) for low, high in box]
        y = [
            exact(math.copysign(abs(x) ** (1 / float(r.mid())), x))
            for x, r in zip(state, chain.degrees, strict=True)
        ]
        assert chain.value(tuple(y), arb(1)) <= level * (1 + arb("1e-9"))


def test_a_certificate_is_proved_and_follows_its_schema(certificate, capsys):
    assert why_not(read(json.dumps(certificate))) == ""
    assert main(["schema", "certificate"]) == 0
    jsonschema.validate(certificate, json.loads(capsys.readouterr().out))
    assert certificate["sampled"] == []
    assert len(json.dumps(certificate)) < 10_000


def test_the_statement_says_the_numbers_of_the_claim(certificate):
    text = " ".join(statement_of(certificate))
    claim = certificate["claim"]
    for number in (claim["total_time"], *claim["max_tau"], *claim["max_abs_state"][1:]):
        assert repr(number) in text
    assert "continuous time" in text


def leaves(value, path=()):
    """Every number below a value, with its place."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*path, key))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from leaves(inner, (*path, str(i)))
    elif isinstance(value, float) and value:
        yield "__".join(path), value


def test_every_stronger_claim_is_refused_under_a_correct_digest(certificate):
    """One digit less anywhere, down to the sixth."""
    places = list(leaves(certificate["claim"]))
    assert len(places) == 14
    for path, value in places:
        for digit in (1, 3, 6):
            unit = 10.0 ** (math.floor(math.log10(abs(value))) - digit + 1)
            lower = value - unit if path != "x0_range__0" else value + unit
            assert why_not(signed(certificate, f"claim__{path}", lower)), path


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("assumptions__alpha", [[0.5, 1.5], [0.5, 1.5]]),
        ("assumptions__disturbance", [0.5, 0.0]),
        ("assumptions__b2", [0.2, 3.0]),
        ("assumptions__starts__x1", [-2.0, 2.0]),
        ("assumptions__starts__x1", [0.2, -0.2]),
        ("assumptions__starts__x2", [-9.0, 9.0]),
        ("assumptions__gamma", [[-1.0, 1.0], [1.0, 1.0]]),
        ("law__l", [2.0, 4.2, 5.0]),
        ("law__k", [0.5, 0.5]),
        ("law__hold", [1.5, 1.0]),
        ("law__q1", "1/2"),
        ("law__hysteresis", 1.01),
        ("law__hysteresis", -1000.0),
        ("law__turn_tolerance", 2.0),
        ("law__tolerance", [1.5, 0.01, 0.01]),
        ("lyapunov__approach__rate", 3.0),
        ("lyapunov__approach__k", [2.4, 17.5]),
        ("lyapunov__approach__s", [-0.1, 0.0]),
        ("lyapunov__hold__sizes", [1.0, 1.0, 1.0]),
        ("lyapunov__return__rate", 9.0),
        ("claim__total_time", math.inf),
        ("claim__total_time", math.nan),
        ("sampled", ["the approach"]),
    ],
)
def test_what_does_not_follow_is_not_proved_under_a_correct_digest(certificate, path, value):
    assert why_not(signed(certificate, path, value))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("law__l", 21),
        ("law__return_steering", True),
        ("law__name", "published"),
        ("law__direction", "sideways"),
        ("law__to_step3", 100.0),
        ("law__q0", "1e-3000000"),
        ("law__tolerance", {"0.01": 1, "-0.02": 1, "0.03": 1}),
        ("assumptions__x", [[[]]]),
        ("measured", {"proved\n6. Always": 1}),
        ("measured", {"form": "implicit\nProved."}),
        ("sampled", 0),
        ("law__lambda1", "-3.0"),
        ("law__lambda1", True),
        ("law__tolerance", [0.01, 0.01]),
        ("assumptions__alpha", None),
        ("assumptions__starts", {"x0": [0.0, 0.0]}),
        ("lyapunov", []),
        ("claim", 3),
    ],
)
def test_a_part_of_the_wrong_kind_makes_it_unreadable(certificate, path, value, tmp_path):
    file = tmp_path / "forged.json"
    file.write_text(json.dumps(signed(certificate, path, value)), encoding="utf-8")
    assert main(["verify", str(file)]) == 2


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: text.replace("0.8", "0.9", 1),
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


def test_a_digit_changed_anywhere_is_refused(certificate):
    text = json.dumps(certificate)
    places = [i for i, letter in enumerate(text) if letter.isdigit()]
    assert len(places) > 300
    for i in places:
        other = str((int(text[i]) + 1) % 10)
        with pytest.raises(NotACertificateError):
            read(text[:i] + other + text[i + 1 :])


@pytest.mark.parametrize(
    ("section", "key"), [("claim", "total_time"), ("law", "l"), ("lyapunov", "hold")]
)
def test_a_certificate_that_lacks_a_part_is_not_proved(certificate, section, key):
    broken = json.loads(json.dumps(certificate))
    del broken[section][key]
    with pytest.raises(NotACertificateError, match=section):
        why_not(broken)


def test_a_turn_is_certified_for_every_heading():
    starts = {"x": (-0.1, 0.1), "y": (-0.1, 0.1), "theta": (-3.1416, 3.1416), "v": (-0.1, 0.1),
              "omega": (0.0, 0.0)}  # fmt: skip
    switching = Switching(
        tolerance=(0.1, 0.01, 0.01), hysteresis=12.0, turn_tolerance=0.01, chart_limit=30.0
    )
    gains = Gains(q1="19/21", direction="toward", return_steering=False)
    found = certify(
        law="corrected", bounds=Bounds(), gains=gains, starts=starts, switching=switching
    )
    assert found.certificate is not None, found.reason
    assert 3.14 < found.certificate["claim"]["max_heading"] < 3.15
    assert why_not(found.certificate) == ""


@pytest.mark.parametrize("omega", [-4.0, 4.0])
def test_a_heading_beside_half_a_turn_counts_with_either_sign(omega):
    """The law may see 3.1416 as −3.1416, where V is larger if it turns further that way."""
    gains = Gains(q1="19/21", direction="toward", return_steering=False)
    claims = []
    for theta in (3.1, 3.1416):
        starts = {"x": (0, 0), "y": (0, 0), "theta": (theta, theta), "v": (0, 0),
                  "omega": (omega, omega)}  # fmt: skip
        found = certify(law="corrected", bounds=Bounds(), gains=gains, starts=starts)
        claims.append(found.certificate["claim"]["max_tau"][1])
    away = abs(omega) if omega > 0 else -abs(omega)
    assert (claims[1] > 1.1 * claims[0]) is (away < 0)


def test_a_turn_that_would_end_beyond_the_chart_is_not_certified():
    switching = Switching(
        tolerance=(0.1, 0.01, 0.01), hysteresis=12.0, turn_tolerance=0.5, chart_limit=10.0
    )
    starts = {"x": (0, 0), "y": (0, 0), "theta": (0.9, 0.9), "v": (0, 0), "omega": (0, 0)}
    gains = Gains(q1="19/21", direction="toward")
    found = certify(
        law="corrected", bounds=Bounds(), gains=gains, starts=starts, switching=switching
    )
    assert "turn_tolerance must be below chart_limit" in found.reason


def test_a_hysteresis_that_is_too_small_is_named_with_the_one_that_is_needed():
    switching = Switching(tolerance=(0.1, 0.01, 0.01), hysteresis=1.1, turn_tolerance=0.01)
    gains = Gains(q1="19/21", direction="toward")
    found = certify(
        law="corrected", bounds=Bounds(), gains=gains, starts=SMALL, switching=switching
    )
    assert found.certificate is None
    assert "hysteresis must be at least" in found.reason


def test_the_commands_certify_and_verify(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("gains.toml").write_text(
        '[bounds]\nalpha = [0.8, 1.2]\n[gains]\nq1 = "19/21"\ndirection = "toward"\n'
        "[starts]\nx0 = [-0.3, 0.3]\nx1 = [-0.2, 0.2]\nx2 = [0.0, 0.0]\n",
        encoding="utf-8",
    )
    assert main(["certify", "gains.toml", "--out", "c.json", "--quiet"]) == 0
    assert "the robot is parked" in capsys.readouterr().out
    assert main(["certify", "gains.toml", "--out", "c.json", "--quiet"]) == 2
    assert main(["verify", "c.json"]) == 0
    assert capsys.readouterr().out.endswith("Proved.\n")
    weak = ["--set", "gains.l=[2.0, 1.0, 1.0]", "--out", "d.json", "--quiet"]
    assert main(["certify", "gains.toml", *weak]) == 1
    assert not Path("d.json").exists()
    assert main(["certify", "gains.toml", "--set", "law='published'", "--out", "d.json"]) == 2
    assert "Step 3" in capsys.readouterr().err


def test_a_missing_library_is_named_with_its_extra(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("parkproof.extras.find_spec", lambda _: None)
    assert main(["verify", str(tmp_path / "c.json")]) == 2
    assert "pip install 'parkproof[proof]'" in capsys.readouterr().err
