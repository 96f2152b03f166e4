"""Sobol' indices as bars: what each drawn quantity decides alone, and with all others."""

import numpy as np

from parkproof.report.sensitivity import Sensitivity
from parkproof.report.style import BLUE, GREY, INK, bytes_of, drawing, new_figure

SHOWN = 12
"""At most so many quantities are drawn, those with the largest total indices."""

ROW = 0.34
"""Height of a quantity in inches."""


def ranked(found: Sensitivity, output: int) -> list[int]:
    """The inputs in the order of their total index, the largest first.

    Parameters
    ----------
    found : Sensitivity
        Indices.
    output : int
        Which output.

    Returns
    -------
    list of int
        Places in `Sensitivity.inputs`.
    """
    return [int(i) for i in np.argsort(-found.total[output], kind="stable")]


def sensitivity_bars(found: Sensitivity, output: int) -> bytes:
    """Draw the indices of one output.

    Parameters
    ----------
    found : Sensitivity
        Indices.
    output : int
        Which output.

    Returns
    -------
    bytes
        SVG.
    """
    shown = ranked(found, output)[:SHOWN]
    names = [found.inputs[i] for i in shown]
    with drawing():
        margin = 0.35 + 0.066 * max(map(len, names))
        width, height = max(4.8, margin + 2.2), 0.95 + ROW * len(shown)
        figure = new_figure(width, height)
        axes = figure.add_axes(
            (margin / width, 0.5 / height, 1.0 - (margin + 0.2) / width, 1.0 - 0.85 / height)
        )
        place = np.arange(len(shown))
        for values, ends, shift, colour, label in (
            (found.total, found.total_range, 0.2, GREY, "with others (total)"),
            (found.first, found.first_range, -0.2, BLUE, "alone (first order)"),
        ):
            size = values[output, shown]
            low, high = ends[:, output][:, shown]
            axes.barh(place + shift, np.maximum(size, 0.0), height=0.36, color=colour, label=label)
            axes.hlines(place + shift, np.clip(low, 0.0, None), np.maximum(high, 0.0), color=INK)
        axes.set_yticks(place, names)
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set_xlim(left=0.0)
        axes.set_xlabel("Share of the variance")
        figure.legend(
            *(part[::-1] for part in axes.get_legend_handles_labels()), loc="upper right", ncols=2,
            handlelength=1.0, columnspacing=1.2, fontsize=8.0,
        )  # fmt: skip
    return bytes_of(figure, "svg")
