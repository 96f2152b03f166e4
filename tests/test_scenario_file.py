"""Scenario files: read, checked with one-line messages, written back, described."""

import json
import tomllib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import jsonschema  # type: ignore[import-untyped]  # it has no stubs
import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.model.signals import Adversary, Constant, Noise, Sine, Square
from parkproof.model.truth import Truth
from parkproof.scenario import Robot, RunSettings, Scenario, Start, Weights
from parkproof.scenario_file import (
    TEMPLATES,
    read_gains_file,
    read_scenario,
    resolved,
    scenario_from_dict,
    scenario_schema,
    schema_text,
    template,
    to_toml,
)
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import simulate

START = 'law = "corrected"\n[start]\nstate = [-0.2, 0.3, -0.5, 5.6, 0.8]\n'
SCHEMA = Path(__file__).parents[1] / "docs" / "scenario.schema.json"


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "scenario.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def message(path: Path, *overrides: str) -> str:
    with pytest.raises(InputError) as caught:
        read_scenario(path, overrides=overrides)
    line = str(caught.value)
    assert "\n" not in line
    return line


# Reading


def test_the_issue_s_example_is_the_paper_template() -> None:
    scenario = scenario_from_dict(tomllib.loads(template("paper")), where="paper")
    gamma = Sine(mean=1.5, amplitude=0.5, omega=1.0)
    phi = Sine(amplitude=2.5, omega=1.0)
    expected = Scenario(
        title="Section 4",
        law="published",
        bounds=Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5),
        weights=Weights(k=(2.4, 17.5), k_step3=2.6),
        truth=Truth(
            alpha=(1.0, 1.0),
            gamma=(gamma, msgspec.structs.replace(gamma, phase=1.5708)),
            disturbance=(phi, msgspec.structs.replace(phi, phase=1.5708)),
        ),
        start=Start(state=(-0.2, 0.3, -0.5, 5.6, 0.8)),
    )
    assert scenario == expected


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    assert read_scenario(written(tmp_path, "\ufeff" + START)).law == "corrected"


def test_bounds_are_given_for_both_channels_or_for_each(tmp_path: Path) -> None:
    both = read_scenario(written(tmp_path, START + "[bounds]\nalpha = [0.5, 1.5]\n"))
    each = read_scenario(written(tmp_path, START + "[bounds]\nalpha = [[0.5, 1.5], [0.8, 1.2]]\n"))
    assert both.bounds.alpha == ((0.5, 1.5), (0.5, 1.5))
    assert each.bounds.alpha == ((0.5, 1.5), (0.8, 1.2))


@pytest.mark.parametrize(
    ("override", "read"),
    [
        ("run.duration=10", lambda s: s.run.duration == 10.0),
        ("gains.l=[2, 4.2, 25]", lambda s: s.gains.l == (2.0, 4.2, 25.0)),
        ("gains.l[2]=25", lambda s: s.gains.l == (2.0, 4.2, 25.0)),
        ("gains.q1=13/15", lambda s: str(s.gains.q1) == "13/15"),
        ("law=published", lambda s: s.law == "published"),
        ('title="a = b"', lambda s: s.title == "a = b"),
        ("title=two words", lambda s: s.title == "two words"),
        ("truth.gamma[0].amplitude=0.25", lambda s: s.truth.gamma[0].amplitude == 0.25),
        ("limits.speed=100", lambda s: s.limits.speed == 100.0),
        ("start.pose=[-1, 0.2, 0.3]", lambda s: s.start == Start(pose=(-1.0, 0.2, 0.3))),
    ],
)
def test_an_override_replaces_what_the_file_says(
    tmp_path: Path, override: str, read: Callable[[Scenario], bool]
) -> None:
    path = written(tmp_path, template("corrected"))
    before = read_scenario(path)
    assert not read(before)
    assert read(read_scenario(path, overrides=[override]))


def test_an_override_can_supply_what_the_file_lacks(tmp_path: Path) -> None:
    path = written(tmp_path, START.partition("\n")[2])
    assert read_scenario(path, overrides=["law=corrected"]).law == "corrected"


# Files of gains


def test_a_file_of_gains_needs_no_run_and_takes_the_paper_s_weights(tmp_path: Path) -> None:
    path = written(tmp_path, '[bounds]\nalpha = [0.5, 1.5]\n[gains]\nq1 = "13/15"\n')
    read = read_gains_file(path)
    assert (str(read.gains.q1), read.weights, read.law) == ("13/15", Weights(), None)


def test_a_scenario_is_a_file_of_gains_with_its_law(tmp_path: Path) -> None:
    path = written(tmp_path, template("paper"))
    read = read_gains_file(path, overrides=["weights.k=[4.28, 311]"])
    assert (read.law, read.weights.k) == ("published", (4.28, 311.0))
    assert read.bounds == read_scenario(path).bounds


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[bounds]\nalpha = [0.5, 1.5]\n", "gains is missing; add a [gains] table"),
        ("[gains]\nl = [1, 2, 3]\n", "bounds is missing; add a [bounds] table"),
        ("[bounds]\n[gains]\n[wieghts]\n", "[wieghts]: unknown table; did you mean [weights]?"),
        ("[bounds]\n[gains]\n[run]\n", "law is missing"),
        ("[bounds]\n[gains]\n[weights]\nk = [1, 0]\n", "[weights] k = 0.0: must be greater than 0"),
    ],
)
def test_a_bad_file_of_gains_says_what_it_lacks(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_gains_file(path)
    assert str(caught.value).startswith(f"{path}: {words}")


# Messages: the file

UNREADABLE = [
    ("", "the file is empty; for a scenario to start from, run: parkproof init"),
    ("# a comment\n", "the file is empty"),
    (b'title = "a"\ntitle2 = "caf\xe9"\n', "line 2: not UTF-8 text (byte 0xe9); save"),
    ("\nlaw = published\n", "line 2, column 7: not valid TOML: invalid value; write numbers plai"),
    ('law = "published\n', "a quoted text does not end on its line; add the closing quote"),
    ("[run]\nduration = 1\nduration = 2\n", "a key is given twice; keep one of them"),
    ("[run]\n[run]\n", "line 2, column 5: not valid TOML: this table is given twice"),
    ("[start]\npose = [1, 2", "end of the file: not valid TOML: a list is not closed; add the"),
    ("[start]\npose = ", "end of the file: not valid TOML: the last value is missing or not compl"),
    ("a = " + "9" * 5000, "a number is too long or lists are nested too deeply"),
    ("a = " + "[" * 5000, "a number is too long or lists are nested too deeply"),
    ("#" * 1_000_001, "longer than 1,000,000 bytes"),
    (
        "[start]\npose = [0, 0, 0]\n",
        'law is missing; write law = "published", law = "corrected" or law = "homogeneous"',
    ),
    ('law = "published"\n', "start is missing; add a [start] table with state = "),
]


@pytest.mark.parametrize(("text", "words"), UNREADABLE, ids=[words for _, words in UNREADABLE])
def test_a_file_that_is_no_scenario_says_why(tmp_path: Path, text: str | bytes, words: str) -> None:
    path = written(tmp_path, text)
    line = message(path)
    assert line.startswith(f"{path}: ")
    assert words in line


def test_a_file_that_cannot_be_read_says_why(tmp_path: Path) -> None:
    missing = tmp_path / "scenario.toml"
    assert message(missing) == (
        f"{missing}: no such file; check the name, or write one with: "
        f"parkproof init --out {missing}"
    )
    assert message(tmp_path).startswith(f"{tmp_path}: is a directory")
    below_a_file = written(tmp_path, START) / "scenario.toml"
    assert message(below_a_file).startswith(f"{below_a_file}: cannot be read (Not a directory)")


def test_an_unreadable_file_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(*_args: object, **_settings: object) -> None:
        raise PermissionError(13, "Permission denied")

    path = written(tmp_path, START)
    monkeypatch.setattr(Path, "open", denied)
    assert message(path).startswith(f"{path}: cannot be read (Permission denied)")


# Messages: what the file says

ONE = '{kind = "constant", value = 1}'
BAD = [
    ("[rnu]\nduration = 3", "[rnu]: unknown table; did you mean [run]?"),
    ("[run]\nduraton = 3", '[run] duraton: unknown key; did you mean "duration"?'),
    ("[run]\nDuration = 3", '[run] Duration: unknown key; did you mean "duration"?'),
    ("[switching]\nduration = 3", '[switching] duration: unknown key; did you mean "duration" un'),
    (
        "[truth]\nbeta = 3",
        "[truth] beta: unknown key; known keys: alpha, gamma, disturbance, b2, outs",
    ),
    ('["a\\nb"]', "[a\\nb]: unknown table; known keys: title, law, bounds"),
    ('[run]\nduration = "abc"', '[run] duration: expected a number, got a string "abc"'),
    ("[run]\nduration = true", "[run] duration: expected a number, got true"),
    ("[run]\nduration = 2024-01-01", "[run] duration: expected a number, got a date or time"),
    ("[run]\nduration = {}", "[run] duration: expected a number, got a table"),
    ("[run]\nduration = 1" + "0" * 400, "[run] duration: the number is too large"),
    ("[run]\nduration = 0", "[run] duration = 0.0: must be greater than 0; write for example"),
    ("[run]\nduration = -1", "[run] duration = -1.0: must be greater than 0"),
    ("[run]\nduration = nan", "[run] duration = nan: must be a finite number"),
    ("[run]\nduration = inf", "[run] duration = inf: must be a finite number"),
    ("[run]\ncontrol_period = 0", "[run] control_period = 0.0: must be greater than 0"),
    ("[run]\ncontrol_period = 1e3", "[run] control_period = 1000: longer than duration = 35"),
    ("[run]\ncontrol_period = 1e-9", "[run] duration / control_period = 3.5e+10 samples: at most"),
    ("[run]\nrecord_period = 0", "[run] record_period = 0.0: must be greater than 0"),
    ('[run]\ndiscretisation = "implict"', 'got a string "implict"; did you mean "implicit"?'),
    ("[switching]\ntolerance = [0, 1e-2, 1e-2]", "[switching] tolerance = 0.0: must be greater"),
    ("[switching]\ntolerance = [1, 1]", "tolerance: expected a list of 3 numbers, got a list of 2"),
    ('[switching]\nto_step2 = "setled"', 'to_step2: expected a number or "settled", got a string '),
    ("[switching]\nto_step2 = 5\nto_step3 = 3", "[switching] to_step2 = 5.0 and to_step3 = 3.0"),
    ("[bounds]\nalpha = [1.5, 0.5]", "[bounds] alpha = [1.5, 0.5]: the bounds are crossed; write"),
    ("[bounds]\nalpha = [-0.5, 1.5]", "-0.5"),
    ("[bounds]\nalpha = 0.5", "[bounds] alpha: expected a list of 2, each a number or a list of 2"),
    ('[bounds]\nalpha = [0.5, "a"]', "alpha[1]: expected a number or a list of 2 numbers, got a s"),
    ("[bounds]\nalpha = [[0.5, 1.5], 1]", "[bounds] alpha: give an interval for both channels, or"),
    ("[bounds]\nalpha = [[0.5, 1.5], [2, 1]]", "[bounds] alpha[1] = [2.0, 1.0]: the bounds are c"),
    ("[bounds]\ngamma = [0, 2]", "[bounds] gamma = [0, 2]: the lower bound must be greater than 0"),
    ('[gains]\nq0 = "1e400"', "[gains] q0"),
    ("[bounds]\ndisturbance = -1", "[bounds] disturbance = -1.0: must not be negative; write dist"),
    ("[bounds]\ndisturbance = [1, nan]", "[bounds] disturbance = nan: must be a finite number"),
    ('[gains]\nq0 = "5/3"', '[gains] q0 = 5/3: must lie in (0, 1); write for example q0 = "1/3"'),
    ("[gains]\nq1 = 0.5", '[gains] q1 = 0.5: must lie in (2/3, 1); write for example q1 = "9/11"'),
    ('[gains]\nq2 = "abc"', "[gains] q2 = 'abc': must be a number or a ratio"),
    ("[gains]\nq2 = []", "[gains] q2: expected a number or a string, got an empty list"),
    ("[gains]\nl = [1, -2, 3]", "[gains] l = -2.0: must be greater than 0"),
    (
        "[truth]\nalpha = [7, 1]",
        "[truth] alpha[0] = 7: outside its bounds [1, 1]; widen the bounds",
    ),
    ("[truth]\nalpha = [0, 1]", "[truth] alpha = 0.0: must be greater than 0"),
    ("[truth]\nb2 = -1", "[truth] b2 = -1.0: must be greater than 0"),
    (
        '[truth]\nb2 = {kind = "sine", mean = 0.5, amplitude = 0.5, omega = 1}',
        "[truth] b2 ranges over [0, 1]: must be greater than 0 at all times",
    ),
    ("[truth]\nb2 = 0.9", "[truth] b2 = 0.9: outside its bounds [1, 1]; widen the bounds"),
    (
        '[bounds]\nb2 = [0.9, 1.1]\n[truth]\nb2 = {kind = "square", amplitude = 1.2, omega = 1, '
        "mean = 2}",
        "[truth] b2 ranges over [0.8, 3.2], outside its bounds [0.9, 1.1]: widen the bounds",
    ),
    (
        '[truth]\nb2 = "one"',
        '[truth] b2: expected a number or a table with kind = "constant", "sine", "square", '
        '"switched", "noise" or "adversary", got a string "one"',
    ),
    ('[truth]\nb2 = {kind = "sin"}', 'or "adversary", got a string "sin"; did you mean "sine"?'),
    ("[truth]\nalpha = [1, true]", "[truth] alpha[1]: expected a number or a table with kind"),
    (
        '[bounds]\nb2 = [0.9, 1.1]\n[truth]\nb2 = 1.1\n[robot]\nkind = "torque"',
        '[truth] b2 is a gain of the chained form, and robot.kind = "torque" takes',
    ),
    ("[bounds]\nb2 = [0, 1]", "[bounds] b2 = 0.0: must be greater than 0"),
    (
        f'[truth]\ngamma = [{{kind = "sin"}}, {ONE}]',
        '[truth] gamma[0].kind: expected "constant", "sine", "square", "switched", "noise" or '
        '"adversary", '
        'got a string "sin"; did you mean "sine"?',
    ),
    (
        f"[truth]\ngamma = [{{value = 1}}, {ONE}]",
        '[truth] gamma[0]: kind is missing; it takes "constant", "sine", "square", "switched", ',
    ),
    (
        f'[truth]\ngamma = [{{kind = "sine", amplitude = 1}}, {ONE}]',
        "[truth] gamma[0]: omega is missing; it takes a number",
    ),
    (
        f'[truth]\ngamma = [{ONE}, {{kind = "constant", valeu = 1}}]',
        '[truth] gamma[1].valeu: unknown key; did you mean "value"? known keys: kind, value',
    ),
    (
        f'[truth]\ngamma = [{{kind = "constant", value = 3}}, {ONE}]',
        "[truth] gamma[0] ranges over [3, 3], outside its bounds [1, 1]: widen the bounds, or "
        "write outside_bounds = true under [truth]",
    ),
    (
        f'[truth]\ngamma = [{{kind = "sine", amplitude = 1, omega = 0}}, {ONE}]',
        "[truth] gamma[0]: omega = 0.0: must be greater than 0",
    ),
    (
        f'[truth]\ngamma = [{{kind = "noise", amplitude = 0, bandwidth = 1, seed = 0.5}}, {ONE}]',
        "[truth] gamma[0].seed: expected a whole number, got the number 0.5",
    ),
    ("[truth]\ngamma = []", '[truth] gamma: expected a list of 2, each a table with kind = "const'),
    ('[robot]\nkind = "torqe"', 'got a string "torqe"; did you mean "torque"?'),
    ('[robot]\nkind = "velocity"\n[bounds]\ndisturbance = 1', "leave both out of [bounds]"),
    ("[limits]\nsaturate = true", "[limits] saturate = true needs tau = [tau1, tau2]"),
    ("[limits]\nview = [1, 2, 0, 1]", "start (-0.2, 0.3) is outside limits.view"),
    ("[weights]\nk = [0, 1]", "[weights] k = 0.0: must be greater than 0"),
]


@pytest.mark.parametrize(("text", "words"), BAD)
def test_a_bad_key_or_value_is_named_with_its_place(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, START + text)
    line = message(path)
    assert line.startswith(f"{path}: ")
    assert words in line
    assert "$" not in line
    assert "`" not in line


BAD_STARTS = [
    ("[start]\n", "[start] needs just one of state = [x0, x1, x2, u0, u1], pose = [x, y, theta]"),
    ("[start]\npose = [0, 0, 0]\nstate = [0, 0, 0, 0, 0]\n", "[start] needs just one of state"),
    ("[start]\nstate = [0, 0, 0, nan, 0]\n", "[start] state = nan: must be a finite number"),
    ("[start]\nstate = [0, 0, 0, 0]\n", "[start] state: expected a list of 5 numbers, got a list"),
    ("start = 5\n", "start: expected a table, got the number 5"),
    ("[start]\npose = [0, 0, 2.8]\n", 'exists for |θ| < 90° only; use law = "corrected"'),
    (
        '[start]\npose = [0, 0, 0]\n[gains]\nq1 = "5/6"\n',
        "q1 = 5/6: the published law needs a rati",
    ),
]


@pytest.mark.parametrize(("text", "words"), BAD_STARTS)
def test_the_published_law_refuses_a_bad_start(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, 'law = "published"\n' + text)
    line = message(path)
    assert line.startswith(f"{path}: ")
    assert words in line
    assert line.count("[start]") <= 1


BAD_OVERRIDES = [
    ("run.duration", "--set run.duration: needs key=value, for example --set run.duration=35"),
    ("=3", "--set =3: needs key=value"),
    ("run..duration=3", "--set run..duration=3: needs key=value"),
    ("run.duraton=3", "--set run.duraton: unknown key; did you mean run.duration?"),
    ("duration=3", "--set duration: unknown key; did you mean run.duration?"),
    ("rnu.duration=3", "--set rnu.duration: unknown key; did you mean run.duration?"),
    ("zzz=3", "--set zzz: unknown key; known keys: title, law, bounds"),
    ("law.x=3", "--set law.x: unknown key; set law as a whole"),
    ("gains.l[3]=1", "--set gains.l[3]: no such element; set gains.l as a whole"),
    ("limits.tau[0]=3", "--set limits.tau[0]=3: the file has no limits.tau[0] to change; set limi"),
    ("truth.gamma[0].men=1", "unknown key; did you mean truth.gamma[0].mean?"),
    ("run.duration=-1", " with --set run.duration=-1: [run] duration = -1.0: must be greater"),
    ("run.duration=1\nx=2", r'expected a number, got a string "1\nx=2"'),
    (
        "law=corrcted",
        'law: expected "corrected", "homogeneous" or "published", got a string "corrcted"; did you',
    ),
]


@pytest.mark.parametrize(("override", "words"), BAD_OVERRIDES)
def test_a_bad_override_is_named(tmp_path: Path, override: str, words: str) -> None:
    assert words in message(written(tmp_path, template("corrected")), override)


# Writing

small = st.floats(0.01, 0.5)
number = st.floats(-5.0, 5.0)
positive = st.floats(1e-6, 1e6)


def exponents(low: float) -> st.SearchStrategy[float | str]:
    # Six decimals: a number within 1e-12 of a ratio counts as that ratio.
    decimals = st.integers(int(low * 1e6) + 1, 999_999).map(lambda n: n / 1e6)
    odd = st.integers(1, 49).map(lambda n: 2 * n + 1)
    ratios = st.tuples(odd, odd).filter(lambda r: low < r[0] / r[1] < 1.0)
    return st.one_of(decimals, ratios.map(lambda r: f"{r[0]}/{r[1]}"))


def signals(mean: float) -> st.SearchStrategy[object]:
    periodic = {"mean": st.just(mean), "amplitude": small, "omega": positive, "phase": number}
    return st.one_of(
        st.builds(Constant, st.floats(mean - 0.5, mean + 0.5)),
        st.builds(Sine, **periodic),
        st.builds(Square, **periodic),
        st.builds(
            Noise,
            mean=st.just(mean),
            amplitude=small,
            bandwidth=positive,
            seed=st.integers(0, 2**40),
        ),
        st.just(Adversary()),
    )


scenarios = st.builds(
    Scenario,
    title=st.text(max_size=20),
    law=st.just("corrected"),
    bounds=st.just(Bounds(alpha=((0.5, 1.5), (0.4, 2)), gamma=(0.5, 2.5), disturbance=(0.6, 2))),
    gains=st.builds(
        Gains,
        q0=exponents(0.0),
        q1=exponents(2.0 / 3.0),
        q2=exponents(0.5),
        l=st.tuples(positive, positive, positive),
        hold=st.none() | st.tuples(positive, positive),
        direction=st.sampled_from(["auto", "toward", "forward", "backward"]),
        return_steering=st.booleans(),
    ),
    weights=st.none() | st.builds(Weights, k=st.tuples(positive, positive)),
    truth=st.builds(
        Truth,
        alpha=st.tuples(st.floats(0.5, 1.5), st.floats(0.5, 1.5) | signals(1.2)),
        gamma=st.tuples(signals(1.5), signals(1.5)),
        disturbance=st.tuples(signals(0.0), signals(0.0)),
    ),
    start=st.one_of(
        st.builds(Start, state=st.tuples(*[number] * 5)),
        st.builds(
            Start, pose=st.tuples(*[number] * 3), velocity=st.none() | st.tuples(number, number)
        ),
    ),
    switching=st.builds(
        Switching,
        to_step2=st.just("settled") | st.integers(0, 5),
        to_step3=st.just("settled") | st.floats(6.0, 30.0),
        tolerance=st.tuples(positive, positive, positive),
    ),
    run=st.builds(
        RunSettings,
        control_period=st.floats(1e-4, 0.1),
        discretisation=st.sampled_from(["explicit", "implicit"]),
        record_period=st.none() | positive,
    ),
    robot=st.builds(Robot, kind=st.sampled_from(["chained", "torque"])),
    limits=st.builds(
        Limits,
        tau=st.tuples(positive, positive),
        speed=st.none() | positive,
        view=st.none() | st.just((-6.0, 6.0, -6, 6)),
        saturate=st.booleans(),
    ),
)


def only_plain(value: object) -> bool:
    if isinstance(value, dict):
        return all(isinstance(key, str) and only_plain(inner) for key, inner in value.items())
    if isinstance(value, list):
        return all(only_plain(inner) for inner in value)
    return type(value) in (bool, int, float, str)


def test_a_b2_that_varies_comes_back_as_it_was() -> None:
    waves = Sine(mean=1.0, amplitude=0.2, omega=3.0)
    for b2 in (1.1, waves, Adversary()):
        scenario = Scenario(
            law="corrected",
            bounds=Bounds(b2=(0.8, 1.2)),
            truth=Truth(b2=b2),
            start=Start(pose=(0.0, 0.0, 0.0)),
        )
        assert scenario_from_dict(resolved(scenario), where="here") == scenario


@given(scenarios)
@settings(max_examples=60, deadline=None)
def test_a_scenario_written_and_read_again_is_equal(scenario: Scenario) -> None:
    data = resolved(scenario)
    assert only_plain(data)
    assert scenario_from_dict(data, where="resolved") == scenario
    assert scenario_from_dict(json.loads(json.dumps(data)), where="summary") == scenario
    assert tomllib.loads(to_toml(scenario)) == data


def test_a_written_file_is_read_as_the_same_scenario(tmp_path: Path) -> None:
    scenario = Scenario(
        title='"quoted" \\ \t \x7f α',
        law="corrected",
        start=Start(pose=(-1.0, 0.5, 2.8)),
    )
    assert read_scenario(written(tmp_path, to_toml(scenario))) == scenario


def test_exponents_are_written_as_ratios() -> None:
    scenario = Scenario(law="corrected", start=Start(pose=(0.0, 0.0, 0.0)), gains=Gains(q1=9 / 11))
    assert resolved(scenario)["gains"]["q1"] == "9/11"


# Templates


@pytest.mark.parametrize("kind", TEMPLATES)
def test_every_template_runs_as_its_comment_says(kind: str) -> None:
    scenario = scenario_from_dict(tomllib.loads(template(kind)), where=kind)
    run = simulate(scenario)
    assert run.outcome is (Outcome.MISSED if kind == "paper" else Outcome.PARKED)


@pytest.mark.parametrize("kind", [*TEMPLATES, "campaign"])
def test_every_key_of_a_template_is_explained(kind: str) -> None:
    lines = template(kind).splitlines()
    assert max(map(len, lines)) <= 100
    for before, line in pairwise(lines):
        if " = " in line and line[:1].isalpha():
            assert before.startswith("#"), line


def test_an_unknown_template_names_the_nearest() -> None:
    with pytest.raises(InputError, match=r'kind "papr": unknown; did you mean "paper"\?'):
        template("papr")


# Schema


def test_the_schema_is_valid_and_accepts_every_template() -> None:
    schema = scenario_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    for kind in TEMPLATES:
        jsonschema.validate(tomllib.loads(template(kind)), schema)


@given(scenarios)
@settings(max_examples=10, deadline=None)
def test_the_schema_accepts_every_resolved_scenario(scenario: Scenario) -> None:
    jsonschema.validate(resolved(scenario), scenario_schema())


@pytest.mark.parametrize(
    "text",
    [
        "[start]\npose = [0, 0, 0]\n",
        START + "[run]\nduraton = 3\n",
        START + '[run]\nduration = "abc"\n',
        START + "[bounds]\nalpha = [0.5, 1.5, 2.0]\n",
        START + f'[truth]\ngamma = [{{kind = "sin"}}, {ONE}]\n',
    ],
)
def test_the_schema_refuses_what_the_reader_refuses(tmp_path: Path, text: str) -> None:
    assert message(written(tmp_path, text))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(text), scenario_schema())


def test_every_key_of_the_schema_is_described() -> None:
    schema = scenario_schema()
    for definition in (schema, *schema["$defs"].values()):
        assert definition["description"]
        for name, key in definition["properties"].items():
            is_kind = "kind" in definition.get("required", ()) and name == "kind"
            assert is_kind or "$ref" in key or key["description"], name


def test_the_published_schema_is_up_to_date() -> None:
    assert SCHEMA.read_text(encoding="utf-8") == schema_text(), (
        "write it anew: python -c 'from parkproof.scenario_file import schema_text; "
        "print(schema_text(), end=str())' > docs/scenario.schema.json"
    )
