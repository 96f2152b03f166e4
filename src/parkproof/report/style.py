"""One style for every picture: colours, fonts, and how long records are drawn in few points."""

import io
import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from parkproof.simulation.metrics import Metrics
    from parkproof.simulation.run import SettlingTime

Array = NDArray[np.float64]

INK = "#1b1f24"
MUTED = "#6b7280"
FAINT = "#d5d9de"
BLUE, VERMILION, GREEN, AMBER, PURPLE, GREY = (
    "#0072b2", "#d55e00", "#009e73", "#e69f00", "#aa5f9b", "#8b929b",
)  # fmt: skip

STEP_COLOURS = {0: PURPLE, 1: AMBER, 2: BLUE, 3: GREEN, 4: GREY}
"""Colour of each step, the same in every picture; apart for all common kinds of colour sight."""

COLUMN_COLOURS = {
    "x0": BLUE, "u0": VERMILION, "x1": BLUE, "x2": VERMILION, "u1": GREEN,
    "xm": BLUE, "ym": BLUE, "theta": BLUE, "tau1": BLUE, "tau2": VERMILION,
    "v": BLUE, "omega": VERMILION,
}  # fmt: skip

STYLE: Any = {
    "figure.dpi": 100.0,
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "text.color": INK,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#eceef1",
    "grid.linewidth": 0.8,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "savefig.facecolor": "white",
    "svg.hashsalt": "parkproof",
}

MAX_POINTS = 2000
"""A line is drawn with at most this many points."""


class Setting(Protocol):
    """What pictures need to know of a run's setting."""

    @property
    def title(self) -> str:
        """What it is called."""

    @property
    def law(self) -> str:
        """Its law."""

    @property
    def view_outline(self) -> tuple[tuple[float, float], ...]:
        """Corners of what the camera sees."""


class Ending(Protocol):
    """How a run ended."""

    @property
    def value(self) -> str:
        """In a word or two."""

    @property
    def sentence(self) -> str:
        """In words."""


class DrawnRun(Protocol):
    """A run as pictures need it: simulated, or of the laboratory."""

    @property
    def scenario(self) -> Setting:
        """Title, law and view."""

    @property
    def outcome(self) -> Ending:
        """How it ended."""

    @property
    def ended(self) -> float:
        """When it ended, in s."""

    @property
    def settling_time(self) -> "SettlingTime":
        """When its steps ended."""

    @property
    def metrics(self) -> "Metrics":
        """Its metrics."""

    @property
    def trajectory(self) -> dict[str, NDArray[Any]]:
        """Its columns."""


_LOCK = threading.RLock()


@contextmanager
def drawing() -> Iterator[None]:
    """Apply the style while a picture is drawn; one thread at a time, as matplotlib needs.

    Examples
    --------
    >>> with drawing():
    ...     mpl.rcParams["axes.spines.top"]
    False
    """
    with _LOCK, mpl.rc_context(STYLE):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Make a figure of its own, outside pyplot's global state.

    Parameters
    ----------
    width, height : float
        Size in inches.

    Returns
    -------
    Figure
        With a canvas that draws PNG.

    Examples
    --------
    >>> float(new_figure(6.4, 4.0).get_figwidth())
    6.4
    """
    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path | str, *, dpi: float = 150.0) -> None:
    """Save a figure; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : Path or str
        The file; its ending says in which format.
    dpi : float
        Resolution of a PNG in dots per inch.

    Examples
    --------
    >>> save(figure, directory / "figure3.svg")
    """
    metadata = {"Date": None} if str(path).endswith(".svg") else None
    with drawing():
        figure.savefig(path, dpi=dpi, metadata=metadata)


def bytes_of(figure: Figure, kind: Literal["png", "svg"], *, dpi: float = 150.0) -> bytes:
    """A figure as the bytes of a file, for a page that holds its pictures itself.

    Parameters
    ----------
    figure : Figure
        The figure.
    kind : "png" or "svg"
        What it becomes.
    dpi : float
        Resolution of a PNG in dots per inch.

    Returns
    -------
    bytes
        The same figure gives the same bytes.

    Examples
    --------
    >>> bytes_of(figure, "svg") == bytes_of(figure, "svg")
    True
    """
    stream = io.BytesIO()
    with drawing():
        figure.savefig(
            stream, format=kind, dpi=dpi, metadata={"Date": None} if kind == "svg" else None
        )
    return stream.getvalue()


def thinned(t: Array, y: Array, *, points: int = MAX_POINTS) -> tuple[Array, Array]:
    """Thin a line so that it looks the same: the lowest and highest sample of each stretch.

    Parameters
    ----------
    t, y : array
        The line; NaN where it has a gap.
    points : int
        At most this many points are kept, the first and last sample among them.

    Returns
    -------
    tuple of two arrays
        The thinned line.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 10_001)
    >>> spike = np.where(t == 0.5, 7.0, 0.0)
    >>> short_t, short_y = thinned(t, spike, points=100)
    >>> len(short_t) <= 100, float(short_y.max())
    (True, 7.0)
    """
    n = len(t)
    if n <= points:
        return t, y
    size = math.ceil(n / (points // 2 - 1))
    padded = np.full(size * math.ceil(n / size), np.nan)
    padded[:n] = y
    stretches = padded.reshape(-1, size)
    first = size * np.arange(len(stretches))
    lowest = first + np.where(np.isnan(stretches), np.inf, stretches).argmin(axis=1)
    highest = first + np.where(np.isnan(stretches), -np.inf, stretches).argmax(axis=1)
    rows = np.unique(np.concatenate(([0, n - 1], lowest, highest)))
    return t[rows], y[rows]


def band(t: Array, y: Array, *, stretches: int = 700) -> tuple[Array, Array, Array, Array]:
    """Lowest, mean and highest value of each stretch of a signal that may chatter.

    Parameters
    ----------
    t, y : array
        The signal.
    stretches : int
        At most about this many; fewer where a long signal chatters, so that each holds 25 samples.

    Returns
    -------
    tuple of four arrays
        Time in the middle of each stretch, lowest, mean and highest value in it.

    Examples
    --------
    >>> t = np.arange(5000.0)
    >>> middle, low, mean, high = band(t, (-1.0) ** t)
    >>> len(middle), float(low[0]), round(float(mean[0]), 1), float(high[0])
    (200, -1.0, 0.0, 1.0)
    """
    n = len(t)
    change = np.diff(y)
    if n <= 2 * stretches:
        stretches = n
    elif np.mean(change[1:] * change[:-1] < 0.0) > 0.1:
        stretches = min(stretches, n // 25)
    starts = np.unique(np.linspace(0, n, stretches + 1, dtype=np.intp)[:-1])
    counts = np.diff(np.append(starts, n))
    return (
        np.add.reduceat(t, starts) / counts,
        np.minimum.reduceat(y, starts),
        np.add.reduceat(y, starts) / counts,
        np.maximum.reduceat(y, starts),
    )


def title_of(run: DrawnRun) -> str:
    """What a picture of a run is called.

    Parameters
    ----------
    run : DrawnRun
        The run.

    Returns
    -------
    str
        The scenario's title and the law.

    Examples
    --------
    >>> title_of(run)
    'Example, corrected law'
    """
    title, law = run.scenario.title, run.scenario.law
    return f"{title}, {law} law" if title else f"The {law} law"


def step_names(law: str) -> dict[int, str]:
    """Name of each step in legends.

    Parameters
    ----------
    law : str
        "published" stops at the end, every other law holds.

    Returns
    -------
    dict of int to str
        Names by number.

    Examples
    --------
    >>> step_names("published")[4]
    'stopped'
    """
    last = "stopped" if law == "published" else "hold"
    return {0: "turn", 1: "run-up", 2: "approach", 3: "return", 4: last}


def stretches_of_steps(step: NDArray[Any]) -> list[tuple[int, int, int]]:
    """Where each step begins and ends.

    Parameters
    ----------
    step : array of int
        The column ``step``.

    Returns
    -------
    list of (step, first row, last row)
        In order of time; a stretch ends where the next begins.

    Examples
    --------
    >>> stretches_of_steps(np.array([1, 1, 2, 2, 2]))
    [(1, 0, 2), (2, 2, 4)]
    """
    starts = [0, *(np.flatnonzero(np.diff(step)) + 1).tolist()]
    ends = [*starts[1:], len(step) - 1]
    return [(int(step[a]), a, b) for a, b in zip(starts, ends, strict=True)]


def time_of_interest(run: DrawnRun) -> float:
    """Time by which all that can be seen has happened.

    Parameters
    ----------
    run : DrawnRun
        The run.

    Returns
    -------
    float
        A little after the robot parked, else the end of the run; in s.

    Examples
    --------
    >>> time_of_interest(run) <= run.ended
    True
    """
    total = run.settling_time.total
    return run.ended if total is None else min(run.ended, 1.15 * total + 0.3)


def step_legend(axes: "Axes", run: DrawnRun, **options: Any) -> None:
    """Name the steps that a run went through, by colour.

    Parameters
    ----------
    axes : Axes
        Where.
    run : DrawnRun
        The run.
    **options
        To `Axes.legend`.

    Examples
    --------
    >>> step_legend(axes, run, loc="lower right")
    >>> len(axes.get_legend().get_texts())
    5
    """
    names = step_names(run.scenario.law)
    handles = [
        Patch(color=STEP_COLOURS[int(i)], label=f"{i} {names[int(i)]}")
        for i in np.unique(run.trajectory["step"])
    ]
    axes.add_artist(axes.legend(handles=handles, handlelength=0.9, handleheight=0.9, **options))
