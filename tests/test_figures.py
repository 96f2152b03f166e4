import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from parkproof.bounds import Bounds, Limits
from parkproof.laws.gains import Switching
from parkproof.report.animation import animation
from parkproof.report.figures import FIGURES, draw_inputs, draw_states, paper_figures, plot
from parkproof.report.path_picture import path_picture, window_of
from parkproof.report.style import (
    MAX_POINTS,
    band,
    new_figure,
    stretches_of_steps,
    thinned,
    time_of_interest,
)
from parkproof.scenario import Robot, RunSettings, Scenario, Start
from parkproof.simulation.run import Run, simulate

LOOSE = Switching(tolerance=(0.1, 0.05, 0.05))


@pytest.fixture(scope="module")
def runs(section4: Callable[..., Scenario]) -> dict[str, Run]:
    """One run of each kind that has a look of its own."""
    velocity = {"bounds": Bounds(alpha=(0.5, 1.5)), "robot": Robot(kind="velocity")}
    coarse = RunSettings(control_period=0.033, duration=12.0)
    scenarios = {
        "parked": section4(control_period=0.005, duration=12.0, switching=LOOSE),
        "diverging": section4("published", control_period=0.005, duration=20.0, switching=LOOSE),
        "chattering": section4(control_period=0.001, duration=6.0, switching=LOOSE),
        "turning": section4(
            start=Start(pose=(-1.0, 0.5, 2.0)), control_period=0.01, duration=10.0, switching=LOOSE
        ),
        "out of view": Scenario(
            law="corrected",
            start=Start(pose=(-1.0, 0.5, 0.1)),
            run=coarse,
            limits=Limits(view=(-1.5, 1.5, -1.0, 1.0)),
            **velocity,  # type: ignore[arg-type]  # bounds and robot
        ),
        "one sample": section4(control_period=0.01, duration=0.01),
    }
    return {name: simulate(scenario) for name, scenario in scenarios.items()}


KINDS = ("parked", "diverging", "chattering", "turning", "out of view", "one sample")


def colours_in(path: Path) -> int:
    with Image.open(path) as image:
        found = image.convert("RGB").getcolors(1 << 24)
    assert found is not None
    return len(found)


@pytest.mark.parametrize("kind", KINDS)
def test_every_run_gets_figures_3_to_8_as_png_and_svg(
    runs: dict[str, Run], tmp_path: Path, kind: str
) -> None:
    files = paper_figures(runs[kind], tmp_path)
    names = [f"figure{i}.{ending}" for i in range(3, 9) for ending in ("png", "svg")]
    assert [file.name for file in files] == names
    for file in files:
        assert file.stat().st_size < 300_000
        if file.suffix == ".png":
            assert colours_in(file) > 20
        else:
            assert "<svg" in file.read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", KINDS)
def test_every_run_gets_a_path_an_overview_and_an_animation(
    runs: dict[str, Run], tmp_path: Path, kind: str
) -> None:
    path_picture(runs[kind], tmp_path / "path.png")
    assert isinstance(plot(runs[kind], tmp_path / "plot.png"), Figure)
    animation(runs[kind], tmp_path / "run.gif", seconds=1.0, fps=10)
    for name in ("path.png", "plot.png"):
        assert colours_in(tmp_path / name) > 20
    assert (tmp_path / "run.gif").stat().st_size < 1_500_000


def test_the_same_run_gives_the_same_bytes(runs: dict[str, Run], tmp_path: Path) -> None:
    for directory in ("a", "b"):
        (tmp_path / directory).mkdir()
        paper_figures(runs["one sample"], tmp_path / directory)
    for file in sorted((tmp_path / "a").iterdir()):
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_labels_and_time_axis_are_those_of_the_paper(runs: dict[str, Run], tmp_path: Path) -> None:
    labels = [label for _, label in FIGURES.values()]
    assert labels[0] == "The states x0 and u0"
    assert labels[2] == "The control inputs τ1 and τ2"
    axes = new_figure(4, 3).add_axes((0.1, 0.1, 0.8, 0.8))
    draw_states(axes, runs["parked"], ("x0", "u0"))
    assert axes.get_xlim() == (0.0, 12.0)
    assert axes.get_yscale() == "linear"
    mpl.rcParams["svg.fonttype"] = "none"  # so that words stay words
    try:
        paper_figures(runs["one sample"], tmp_path)
    finally:
        mpl.rcParams["svg.fonttype"] = "path"
    for number, (_, label) in FIGURES.items():
        text = (tmp_path / f"figure{number}.svg").read_text(encoding="utf-8")
        assert label in text
        assert "Time (s)" in text


def test_a_figure_may_end_earlier(runs: dict[str, Run]) -> None:
    axes = new_figure(4, 3).add_axes((0.1, 0.1, 0.8, 0.8))
    draw_states(axes, runs["parked"], ("x0", "u0"), until=4.0)
    assert axes.get_xlim() == (0.0, 4.0)
    drawn = [np.asarray(line.get_data()[0]) for line in axes.lines]
    assert max(t[-1] for t in drawn if len(t) > 2) <= 4.0


def test_a_state_that_explodes_is_shown_whole_and_named(runs: dict[str, Run]) -> None:
    run = runs["diverging"]
    axes = new_figure(4, 3).add_axes((0.1, 0.1, 0.8, 0.8))
    notes = draw_states(axes, run, ("x1", "x2", "u1"))
    low, high = axes.get_ylim()
    drawn = np.concatenate([run.trajectory[name] for name in ("x1", "x2", "u1")])
    assert low <= drawn.min() <= drawn.max() <= high
    assert axes.get_yscale() == "symlog"
    largest = np.abs(run.trajectory["x1"]).max()
    assert f"|x1| reaches {largest:,.4g}." in notes
    early = [run.trajectory[n][run.trajectory["step"] <= 2] for n in ("x1", "x2", "u1")]
    frame = float(notes[0].split("±")[1].rstrip("."))
    assert frame == pytest.approx(1.08 * np.abs(np.concatenate(early)).max(), rel=1e-2)


def test_chatter_is_drawn_as_a_band_that_holds_every_sample(runs: dict[str, Run]) -> None:
    run = runs["chattering"]
    t, tau = run.trajectory["t"], run.trajectory["tau1"]
    middle, low, mean, high = band(t, tau)
    assert len(middle) < 0.1 * len(t)
    assert low.min() == tau.min()
    assert high.max() == tau.max()
    assert np.all((low <= mean) & (mean <= high))
    holding = middle > time_of_interest(run) - 0.2
    assert np.all(high[holding] - low[holding] > 4.0)  # from -2.5 to 2.5
    axes = new_figure(4, 3).add_axes((0.1, 0.1, 0.8, 0.8))
    assert "band" in draw_inputs(axes, run, ("tau1",))[0]


def test_a_coarse_input_is_drawn_sample_by_sample(runs: dict[str, Run]) -> None:
    run = runs["out of view"]
    middle, low, mean, high = band(run.trajectory["t"], run.trajectory["tau2"])
    np.testing.assert_array_equal(middle, run.trajectory["t"])
    np.testing.assert_array_equal(low, high)
    np.testing.assert_array_equal(mean, run.trajectory["tau2"])


def test_thinning_keeps_every_extreme_and_gap() -> None:
    rng = np.random.default_rng(3)
    t = np.linspace(0.0, 1.0, 100_000)
    y = np.cumsum(rng.standard_normal(len(t)))
    y[30_000:40_000] = np.nan
    short_t, short_y = thinned(t, y)
    assert len(short_t) <= MAX_POINTS + 2
    assert np.all(np.diff(short_t) > 0.0)
    assert (short_t[0], short_t[-1]) == (0.0, 1.0)
    assert (np.nanmin(short_y), np.nanmax(short_y)) == (np.nanmin(y), np.nanmax(y))
    assert np.isnan(short_y[(short_t > 0.305) & (short_t < 0.395)]).all()


def test_stretches_of_steps_cover_the_run(runs: dict[str, Run]) -> None:
    step = runs["turning"].trajectory["step"]
    stretches = stretches_of_steps(step)
    assert stretches[0][:2] == (0, 0)
    assert stretches[-1][2] == len(step) - 1
    assert all(a[2] == b[1] for a, b in pairwise(stretches))


def test_chart_states_are_not_drawn_while_turning(runs: dict[str, Run]) -> None:
    run = runs["turning"]
    axes = new_figure(4, 3).add_axes((0.1, 0.1, 0.8, 0.8))
    draw_states(axes, run, ("x1", "x2", "u1"))
    turned = run.settling_time.steps["0"]
    assert turned is not None
    lines = {line.get_label(): line for line in axes.lines}
    t, x2 = np.asarray(lines["x2"].get_data())
    assert np.isnan(x2[t < turned]).all()
    assert np.isfinite(lines["x1"].get_data()[1]).all()


def test_the_window_shows_the_whole_path_unless_it_explodes(runs: dict[str, Run]) -> None:
    for kind, whole in (("parked", True), ("turning", True), ("diverging", False)):
        (x_low, x_high, y_low, y_high), stays = window_of(runs[kind])
        x, y = runs[kind].trajectory["xm"], runs[kind].trajectory["ym"]
        inside = (x_low < x) & (x < x_high) & (y_low < y) & (y < y_high)
        assert stays is whole
        assert inside.all() == whole
        assert x_low < 0.0 < x_high
        assert y_low < 0.0 < y_high


def test_the_camera_view_is_in_the_window(runs: dict[str, Run]) -> None:
    (x_low, x_high, y_low, y_high), _ = window_of(runs["out of view"])
    assert x_low < -1.5 < 1.5 < x_high
    assert y_low < -1.0 < 1.0 < y_high


def test_time_of_interest_ends_a_little_after_parking(runs: dict[str, Run]) -> None:
    total = runs["parked"].settling_time.total
    assert total is not None
    assert total < time_of_interest(runs["parked"]) < total + 3.0
    assert time_of_interest(runs["diverging"]) == runs["diverging"].ended


def test_an_animation_has_the_length_and_frames_asked_for(
    runs: dict[str, Run], tmp_path: Path
) -> None:
    animation(runs["parked"], tmp_path / "run.gif", seconds=2.0, fps=10)
    with Image.open(tmp_path / "run.gif") as gif:
        frames = gif.n_frames  # type: ignore[attr-defined]
        lasts = 0
        for i in range(frames):
            gif.seek(i)
            lasts += gif.info["duration"]
            assert gif.convert("RGB").getpixel((2, 2)) == (255, 255, 255)
    assert frames <= 20
    assert lasts == 19 * 100 + 1500


def test_pictures_leave_the_users_matplotlib_alone(runs: dict[str, Run], tmp_path: Path) -> None:
    before = dict(mpl.rcParams)
    with ThreadPoolExecutor(2) as pool:
        for i in range(2):
            pool.submit(path_picture, runs["turning"], tmp_path / f"{i}.png")
    assert dict(mpl.rcParams) == before
    assert (tmp_path / "0.png").read_bytes() == (tmp_path / "1.png").read_bytes()


def test_a_set_of_figures_is_quick(runs: dict[str, Run], tmp_path: Path) -> None:
    paper_figures(runs["one sample"], tmp_path)  # fonts are loaded once
    start = time.process_time()
    paper_figures(runs["chattering"], tmp_path)
    assert time.process_time() - start < 5.0  # 1.3 s on a free core
