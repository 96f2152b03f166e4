"""How the trials of a campaign spread: quantiles of each metric, and histograms."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from parkproof.report.style import BLUE, GREY, INK, VERMILION, bytes_of, drawing, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEVELS = (0.0, 0.05, 0.5, 0.95, 0.99, 1.0)
"""Quantiles of the tables."""

BINS = (10, 80)
"""Fewest and most bins; in between two for each root of the number of trials."""

LONG_TAIL = 30.0
"""A histogram is over the logarithm where the largest value is this many times the median."""

SMALLEST = 1e-9
"""Least share of the largest value that a logarithmic histogram shows."""

MANY = 500
"""Counts are drawn over their logarithm from so many trials on: rare ones stay visible."""


@dataclass(frozen=True)
class Metric:
    """A metric of a trial, as the report names it.

    Attributes
    ----------
    column : str
        Its column in the table.
    label : str
        Plain text, with the unit if it has one.
    drawn : bool
        Whether it gets a histogram.
    proven : str
        The number of a certificate's claim that bounds it, if any.
    """

    column: str
    label: str
    drawn: bool = False
    proven: str = ""


SETTLING = Metric("total", "Time until parked (s)", proven="total_time")

METRICS = (
    Metric("residual", "Residual in the last 2 s", drawn=True),
    Metric("excursion", "Largest distance from the goal", drawn=True),
    Metric("peak_tau1", "Largest |τ1|", drawn=True, proven="max_tau 1"),
    Metric("peak_tau2", "Largest |τ2|", drawn=True, proven="max_tau 2"),
    Metric("rms_tau1", "Root mean square of τ1", drawn=True),
    Metric("rms_tau2", "Root mean square of τ2", drawn=True),
    Metric("path_length", "Length of the path"),
    Metric("max_speed", "Largest |v|", proven="max_speed"),
    Metric("max_turn_rate", "Largest |ω|", proven="max_turn_rate"),
)


@dataclass(frozen=True)
class Spread:
    """How a metric spreads.

    Attributes
    ----------
    count : int
        Trials that have a value.
    missing : int
        Trials that have none.
    quantiles : tuple of floats
        At LEVELS; empty without a value.

    Examples
    --------
    >>> spread_of(np.array([1.0, np.nan, 3.0]))
    Spread(count=2, missing=1, quantiles=(1.0, 1.1, 2.0, 2.9, 2.98, 3.0))
    """

    count: int
    missing: int
    quantiles: tuple[float, ...]


def spread_of(values: Floats) -> Spread:
    """Sum a metric up.

    Parameters
    ----------
    values : array
        A number a trial; what is not finite counts as missing.

    Returns
    -------
    Spread
        Counts and quantiles.

    Examples
    --------
    >>> spread_of(np.array([np.nan])).quantiles
    ()
    """
    known = values[np.isfinite(values)]
    levels = np.quantile(known, LEVELS).tolist() if known.size else []
    return Spread(known.size, values.size - known.size, tuple(float(x) for x in levels))


def edges_of(values: Floats, *, bins: int | None = None) -> tuple[Floats, bool]:
    """Edges of a histogram, and whether they are even in the logarithm.

    Parameters
    ----------
    values : array
        Finite numbers, at least one.
    bins : int, optional
        How many.

    Returns
    -------
    tuple
        Edges from the least to the largest value; of a logarithmic histogram from 1e-9 of the
        largest at least, and what is smaller belongs into its first bin.

    Examples
    --------
    >>> edges_of(np.array([1.0, 2.0, 3.0]), bins=2)
    (array([1., 2., 3.]), False)
    >>> edges_of(np.array([0.0, 1e-2, 1.0, 100.0, 1e4]), bins=3)[1]
    True
    """
    bins = bins or min(max(2 * math.isqrt(len(values)), BINS[0]), BINS[1])
    low, high, middle = float(values.min()), float(values.max()), float(np.median(values))
    if low >= 0.0 and middle > 0.0 and high > LONG_TAIL * middle:
        least = max(float(values[values > 0.0].min()), SMALLEST * high)
        return np.geomspace(least, high, bins + 1), True
    if low == high:
        margin = 0.05 * abs(low) or 0.5
        low, high = low - margin, high + margin
    return np.linspace(low, high, bins + 1), False


def histogram(
    metric: Metric,
    values: Floats,
    *,
    apart: Flags | None = None,
    bound: float | None = None,
    wide: bool = False,
) -> bytes:
    """Draw a histogram.

    Parameters
    ----------
    metric : Metric
        What it is of.
    values : array
        A number a trial; what is not finite is left out.
    apart : array of bool, optional
        Trials that a certificate says nothing about: drawn in grey, on top of the others.
    bound : float, optional
        What is proved of the others: a line.
    wide : bool
        A little larger.

    Returns
    -------
    bytes
        SVG.

    Examples
    --------
    >>> histogram(SETTLING, np.array([7.1, 7.4, 8.0]), bound=11.7)[:5]
    b'<?xml'
    """
    known = np.isfinite(values)
    with drawing():
        figure = new_figure(5.8 if wide else 4.8, 3.3 if wide else 2.9)
        width, height = figure.get_size_inches()
        above = 0.34 if bound is not None or apart is not None else 0.14
        axes = figure.add_axes(
            (0.7 / width, 0.52 / height, 1.0 - 0.86 / width, 1.0 - (0.52 + above) / height)
        )
        axes.set_xlabel(metric.label)
        if known.any():
            _bars(axes, values[known], None if apart is None else apart[known])
        else:
            axes.text(0.5, 0.5, "no trial has a value", ha="center", transform=axes.transAxes)
            axes.set(xticks=[], yticks=[])
        if bound is not None:
            _mark_bound(axes, bound)
        _legend(figure, axes)
    return bytes_of(figure, "svg")


def _bars(axes: "Axes", values: Floats, apart: Flags | None) -> None:
    """Bars of all trials, those apart on top in another colour."""
    edges, logarithmic = edges_of(values)
    clipped = np.clip(values, edges[0], edges[-1])
    groups = [(clipped, BLUE, "trials")]
    if apart is not None and apart.any():
        groups = [
            (clipped[~apart], BLUE, "certified trials"),
            (clipped[apart], GREY, "other trials"),
        ]
    below = np.zeros(len(edges) - 1)
    for some, colour, label in groups:
        counts = np.histogram(some, edges)[0]
        axes.stairs(below + counts, edges, baseline=below, fill=True, color=colour, label=label)
        below = below + counts
    if logarithmic:
        axes.set_xscale("log")
    else:
        axes.xaxis.set_major_formatter(FuncFormatter(_tick))
        axes.xaxis.set_major_locator(
            MaxNLocator(5, steps=[1, 2, 5, 10])
        )  # labels such as 0.00025 are long
    if len(values) >= MANY:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(FuncFormatter(_tick))
        axes.set_ylim(0.7, 1.6 * float(below.max()))
        axes.set_ylabel("Trials a bin (logarithmic)")
    else:
        axes.set_ylim(0.0, 1.08 * float(below.max()))
        axes.set_ylabel("Trials a bin")
        axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))


def _mark_bound(axes: "Axes", bound: float) -> None:
    """A line at what is proved."""
    low, high = axes.get_xlim()
    if axes.get_xscale() == "log":
        axes.set_xlim(min(low, 0.8 * bound), max(high, 1.25 * bound))
    else:
        reach = 0.06 * max(high - low, abs(bound - low))
        axes.set_xlim(min(low, bound - reach), max(high, bound + reach))
    axes.axvline(bound, color=VERMILION, lw=1.6, label=f"proved: at most {bound:.4g}")


def _legend(figure: "Figure", axes: "Axes") -> None:
    """Name the colours above the panel, if there is more than one thing to name."""
    handles, labels = axes.get_legend_handles_labels()
    if len(handles) > 1:
        figure.legend(
            handles, labels, loc="upper right", bbox_to_anchor=(1.0, 1.0), ncols=3,
            handlelength=1.0, columnspacing=1.0, labelcolor=INK, fontsize=8.0,
        )  # fmt: skip


def _tick(value: float, _place: Any) -> str:
    return f"{value:,.6g}".replace("-", "−")
