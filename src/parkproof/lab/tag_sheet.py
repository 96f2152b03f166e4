"""A page with a tag to print, to scale, with all that is needed to mount it and to check it."""

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.image_pose import check_tag_id
from parkproof.lab.tag import FAMILY
from parkproof.lab.tag_square import QUIET
from parkproof.validate import positive

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PAGES = {
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
    "A5": (148.0, 210.0),
    "letter": (215.9, 279.4),
}
"""Width and height of the pages in mm."""

ENDINGS = (".pdf", ".svg", ".png")
"""Kinds of file; a picture in pixels has `DPI`."""

DPI = 300

CELLS = 8
"""Cells along a side of the black square."""

_BORDER = 8.0  # mm that printers cannot reach
_STRIP = 6.0  # mm around the white margin, for what must stay with the tag when it is cut out
_MARK = 4.0  # mm, marks around that
_TOP, _BOTTOM = 26.0, 46.0  # mm for the title, and for the arrow and the ruler
_LEAST = 5.0  # mm


def tag_cells(tag_id: int) -> NDArray[np.bool_]:
    """Cells of a tag as it is printed and read, without its white margin.

    Parameters
    ----------
    tag_id : int
        Which tag of the family 36h11.

    Returns
    -------
    array of bool, 8 × 8
        True where it is white. The first row is the top.

    Raises
    ------
    InputError
        If there is no such tag, or the library for tags is not installed.

    Examples
    --------
    >>> cells = tag_cells(0)
    >>> cells.shape, bool(cells[0].any())
    ((8, 8), False)
    """
    check_tag_id(tag_id)
    require("cv2", extra="lab", purpose="drawing tags")
    import cv2

    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    marker = np.asarray(cv2.aruco.generateImageMarker(family, tag_id, CELLS))
    return np.ascontiguousarray(marker[::-1, ::-1] > 127)  # OpenCV's is turned by half a turn


def largest_side(page: str) -> float:
    """Largest side of a tag that a page has room for.

    Parameters
    ----------
    page : str
        Name of the page, one of `PAGES`.

    Returns
    -------
    float
        Side of the black square in m, whole mm.

    Raises
    ------
    InputError
        If there is no such page.

    Examples
    --------
    >>> largest_side("A4")
    0.139
    """
    width, height = _page(page)
    room = min(width - 2.0 * _BORDER, height - _TOP - _BOTTOM) - 2.0 * (_STRIP + _MARK)
    return math.floor(room / (1.0 + 2.0 * QUIET)) / 1000.0


def _page(page: str) -> tuple[float, float]:
    if page not in PAGES:
        raise InputError(f'page = "{page}": must be one of {", ".join(PAGES)}; write page = "A4"')
    return PAGES[page]


def tag_sheet(tag_id: int, ending: str, *, side: float = 0.1, page: str = "A4") -> bytes:
    """Draw a page with a tag, to scale.

    Parameters
    ----------
    tag_id : int
        Which tag of the family 36h11.
    ending : str
        Kind of file: ".pdf" or ".svg", in lines, or ".png", at 300 dots an inch.
    side : float
        Side of the black square in m.
    page : str
        "A3", "A4", "A5" or "letter".

    Returns
    -------
    bytes
        The file.

    Raises
    ------
    InputError
        If there is no such tag, page or kind of file, or the tag has no room on the page.

    Examples
    --------
    >>> tag_sheet(7, ".pdf")[:5]
    b'%PDF-'
    >>> tag_sheet(7, ".pdf", side=0.3)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: side = 0.3 m: A4 has room for tags up to 0.139 m; ...
    """
    check_tag_id(tag_id)
    width, height = _page(page)
    check_ending(Path(f"tag{ending}"))
    mm = 1000.0 * positive("side", side, example=0.1)
    if mm < _LEAST:
        raise InputError(
            f"side = {side:g} m: must be at least {_LEAST / 1000:g} m, or nothing can read it; is "
            "it in m? write for example side = 0.1"
        )
    if mm > 1000.0 * largest_side(page):
        larger = next((name for name in PAGES if mm <= 1000.0 * largest_side(name)), None)
        raise InputError(
            f"side = {side:g} m: {page} has room for tags up to {largest_side(page):g} m; write a "
            "smaller side" + (f", or --page {larger}" if larger else "")
        )
    require("matplotlib", extra="lab", purpose="drawing tags")
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context({"svg.fonttype": "path", "svg.hashsalt": "tag", "font.size": 9.0}):
        figure = Figure(figsize=(width / 25.4, height / 25.4))
        FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(0.0, width), ylim=(0.0, height))
        axes.set_axis_off()
        middle = (width / 2.0, _BOTTOM + (height - _TOP - _BOTTOM) / 2.0)
        _draw_tag(axes, tag_cells(tag_id), middle, mm)
        _draw_marks(axes, tag_id, middle, mm)
        _draw_words(axes, tag_id, mm, (width, height))
        file = io.BytesIO()
        kind = ending[1:]
        dates = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
        figure.savefig(file, format=kind, dpi=DPI, metadata=dates)
    return file.getvalue()


def check_ending(path: Path) -> str:
    """Return the ending of a file for a tag, or raise if there is no such kind.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        ".pdf", ".svg" or ".png".

    Raises
    ------
    InputError
        If it is another.

    Examples
    --------
    >>> check_ending(Path("tag.pdf"))
    '.pdf'
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(
            f"{path}: a tag can be written as {', '.join(ENDINGS)}; write for example "
            f"{path.with_suffix('.pdf')}"
        )
    return ending


def _draw_tag(
    axes: "Axes", cells: NDArray[np.bool_], middle: tuple[float, float], side: float
) -> None:
    """Draw the black cells as one path, so that no viewer shows seams between them."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    cell = side / CELLS
    left, top = middle[0] - side / 2.0, middle[1] + side / 2.0
    squares = [
        Outline([(x, y), (x + cell, y), (x + cell, y - cell), (x, y - cell), (x, y)], closed=True)
        for row, column in np.argwhere(~cells)
        for x, y in ((left + column * cell, top - row * cell),)
    ]
    outline = Outline.make_compound_path(*squares)
    axes.add_patch(PathPatch(outline, facecolor="black", edgecolor="none", snap=False))


def _draw_marks(axes: "Axes", tag_id: int, middle: tuple[float, float], side: float) -> None:
    """Draw the centre, marks to cut along, and forward and id in the strip that stays."""
    x, y = middle
    fine: Any = {"color": "0.5", "linewidth": 0.3, "solid_capstyle": "butt"}
    arm = 0.12 * side / CELLS  # too small to change how a cell reads
    axes.plot((x - arm, x + arm), (y, y), **fine)
    axes.plot((x, x), (y - arm, y + arm), **fine)
    white = side * (0.5 + QUIET)
    edge = white + _STRIP
    for towards in (-1.0, 1.0):
        ends = (towards * edge, towards * (edge + _MARK))
        for across in (-edge, 0.0, edge):
            axes.plot([x + end for end in ends], (y + across, y + across), **fine)
            axes.plot((x + across, x + across), [y + end for end in ends], **fine)
        # From here to the centre point these, too, when the tag is cut out.
        inner = (towards * (white + 0.5 * _STRIP), towards * edge)
        axes.plot((x, x), [y + end for end in inner], **fine)
    axes.plot((x - edge, x - white - 0.5 * _STRIP), (y, y), **fine)
    tip = x + edge - 1.0
    axes.fill((tip, tip - 4.0, tip - 4.0), (y, y + 2.5, y - 2.5), color="black", linewidth=0.0)
    axes.text(
        x - white,
        y - white - 1.0,
        f"{tag_id}",
        ha="left",
        va="top",
        fontsize=9,
        color="black",
    )


def _draw_words(axes: "Axes", tag_id: int, side: float, page: tuple[float, float]) -> None:
    """Draw the title, the arrow of the robot's forward, and a ruler."""
    x, top = page[0] / 2.0, page[1] - _BORDER
    words: Any = {"ha": "center", "va": "top", "color": "black"}
    axes.text(x, top, f"{FAMILY}, id {tag_id}, side {side:g} mm", fontsize=13, **words)
    line = "Print at 100 % on matt paper. Cut along the marks. Mount it flat."
    axes.text(x, top - 7.5, line, **words)
    y = _BOTTOM - 6.0
    axes.annotate(
        "",
        xy=(x + 30.0, y),
        xytext=(x - 30.0, y),
        arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.2, "mutation_scale": 16},
    )
    axes.text(x, y - 2.5, "forward of the robot (x of the tag; angle 0)", **words)
    y = _BORDER + 12.0
    left = x - 50.0
    axes.plot((left, left + 100.0), (y, y), color="black", linewidth=0.5)
    for at in range(0, 101, 5):
        long = 3.0 if at % 50 == 0 else 2.0 if at % 10 == 0 else 1.2
        axes.plot((left + at, left + at), (y, y + long), color="black", linewidth=0.3)
        if at % 50 == 0:
            axes.text(left + at, y + 3.6, f"{at}", ha="center", va="bottom", fontsize=7)
    line = "100 mm. If this line measures otherwise, the tag is not to scale."
    axes.text(x, y - 2.0, line, **words)
