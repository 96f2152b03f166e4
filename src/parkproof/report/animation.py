"""The robot driving its path to the goal, as an animated GIF."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image

from parkproof.report.path_picture import frame_path, window_of
from parkproof.report.robot_picture import draw_robot, place_robot
from parkproof.report.style import (
    FAINT,
    INK,
    MUTED,
    STEP_COLOURS,
    VERMILION,
    DrawnRun,
    drawing,
    new_figure,
    step_names,
    time_of_interest,
    title_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINAL_PAUSE = 1500
"""Milliseconds for which the last frame stays."""

SHADES = 16
"""Shades of each colour in a GIF, for smooth edges."""


def animation(run: DrawnRun, path: Path | str, *, seconds: float = 8.0, fps: int = 15) -> None:
    """Draw a run as an animated GIF: the robot, its trail, the step it is in and the time.

    The time from the start until a little after the robot parked (or until the end of the run, or
    until it left the picture for good) is stretched or squeezed to the length of the animation.

    Parameters
    ----------
    run : DrawnRun
        The run.
    path : Path or str
        The file.
    seconds : float
        Length of the animation.
    fps : int
        Frames per second, as near as GIF's unit of 10 ms comes to it.

    Examples
    --------
    >>> animation(run, directory / "run.gif", seconds=1.0)
    >>> (directory / "run.gif").read_bytes()[:3]
    b'GIF'
    """
    with drawing():
        frames = _frames(run, max(2, round(seconds * fps)))
    palette = _palette()
    images = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    pause = 10 * max(2, round(100.0 / fps))
    images[0].save(
        path, save_all=True, append_images=images[1:], loop=0, optimize=False, disposal=1,
        duration=[pause] * (len(images) - 1) + [FINAL_PAUSE],
    )  # fmt: skip


def _palette() -> Image.Image:
    """One palette for all frames: each colour of the style in shades up to white."""
    shades = np.linspace(0.0, 1.0, SHADES)[:, None]
    colours = [INK, MUTED, FAINT, VERMILION, *STEP_COLOURS.values()]
    mixed = [shades * 255.0 + (1.0 - shades) * 255.0 * np.array(to_rgb(c)) for c in colours]
    table = np.concatenate(mixed).round().astype(np.uint8)
    table[table.min(axis=1) > 245] = 255  # Pillow picks by coarse boxes: keep the paper white
    palette = Image.new("P", (1, 1))
    palette.putpalette(table.tobytes())
    return palette


def _frames(run: DrawnRun, count: int) -> list[Image.Image]:
    """The frames: a still background, and robot, trail and words drawn over a copy of it."""
    (x_low, x_high, y_low, y_high), _ = window_of(run)
    width = 6.8
    panel_width = width - 0.85
    panel_height = min(max((y_high - y_low) / (x_high - x_low), 0.36), 0.75) * panel_width
    height = panel_height + 1.05
    figure = new_figure(width, height)
    canvas: Any = figure.canvas  # matplotlib leaves its drawing calls without types
    axes = figure.add_axes((0.68 / width, 0.5 / height, panel_width / width, panel_height / height))
    length = frame_path(axes, run)
    figure.text(0.68 / width, 1.0 - 0.24 / height, title_of(run), fontsize=10, weight="bold")
    trajectory = run.trajectory
    x, y, theta, t = (trajectory[name] for name in ("xm", "ym", "theta", "t"))
    axes.plot(x[:: max(1, len(x) // 4000)], y[:: max(1, len(y) // 4000)], color=FAINT, lw=1.5)

    trails = {i: axes.plot([], [], color=c, lw=2.6, zorder=3.0)[0] for i, c in STEP_COLOURS.items()}
    robots = {
        i: draw_robot(axes, (0.0, 0.0, 0.0), length=length, colour=c, zorder=7.0)
        for i, c in STEP_COLOURS.items()
    }
    words = figure.text(0.68 / width, 1.0 - 0.43 / height, "", fontsize=9, color=MUTED)
    moving = [*trails.values(), *(part for parts in robots.values() for part in parts), words]
    for artist in moving:
        artist.set_animated(True)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)

    end = min(time_of_interest(run), _last_seen(run, axes))
    rows = np.searchsorted(t, np.linspace(0.0, end, count)).clip(0, len(t) - 1)
    seen = np.unique(np.concatenate([np.linspace(0, rows[-1], 3000, dtype=np.intp), rows]))
    names = step_names(run.scenario.law)
    frames = []
    for k, row in enumerate(rows):
        step = int(trajectory["step"][row])
        canvas.restore_region(background)
        trail = seen[seen <= row]
        for number, line in trails.items():
            of_step = trajectory["step"][trail] == number
            if of_step.any():
                line.set_data(
                    np.where(of_step, x[trail], np.nan), np.where(of_step, y[trail], np.nan)
                )
                axes.draw_artist(line)
        place_robot(axes, robots[step], (x[row], y[row], theta[row]), length=length)
        for part in robots[step]:
            axes.draw_artist(part)
        ending = f"   →  {run.outcome.value}" if k > 0.92 * count else ""
        words.set_text(f"{t[row]:.1f} s   Step {step}: {names[step]}{ending}")
        words.set_color(STEP_COLOURS[step])
        figure.draw_artist(words)
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    return frames


def _last_seen(run: DrawnRun, axes: "Axes") -> float:
    """Time by which the robot has left the panel for good, with a little to spare; in s."""
    x, y, t = (run.trajectory[name] for name in ("xm", "ym", "t"))
    (x_low, x_high), (y_low, y_high) = axes.get_xlim(), axes.get_ylim()
    seen = np.flatnonzero((x > x_low) & (x < x_high) & (y > y_low) & (y < y_high))
    return 1.1 * float(t[seen[-1]]) + 0.3
