"""Small, smooth letters for pictures that are NumPy arrays, in the font of all other pictures."""

from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.devices import Image

Colour = tuple[int, int, int]
"""Red, green, blue; 0 to 255."""


@cache
def _font(size: int, *, bold: bool) -> Any:
    import matplotlib as mpl
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


@lru_cache(maxsize=1024)
def _letters(text: str, size: int, *, bold: bool) -> NDArray[np.uint16]:
    """How much ink each pixel of a line of text has, 0 to 256; its rows are those of the font."""
    from PIL import Image as Picture
    from PIL import ImageDraw

    font = _font(size, bold=bold)
    ascent, descent = font.getmetrics()
    width = max(1, int(np.ceil(font.getlength(text))) + 1)
    mask = Picture.new("L", (width, ascent + descent), 0)
    ImageDraw.Draw(mask).text((0, 0), text, font=font, fill=255)
    ink = np.asarray(mask, np.uint16)
    return ink + (ink >> 7)


def text_width(text: str, size: int, *, bold: bool = False) -> int:
    """Width of a line of text.

    Parameters
    ----------
    text : str
        The line.
    size : int
        Height of the font in px.
    bold : bool
        Whether it is bold.

    Returns
    -------
    int
        In px.

    Examples
    --------
    >>> text_width("approach", 15) > text_width("turn", 15)
    True
    """
    return int(_letters(text, size, bold=bold).shape[1])


def write_text(
    image: Image,
    text: str,
    place: tuple[int, int],
    *,
    size: int,
    colour: Colour,
    bold: bool = False,
    align: str = "left",
) -> None:
    """Write a line of text onto a picture; what does not fit on it is cut off.

    Parameters
    ----------
    image : array of uint8
        RGB; changed.
    text : str
        The line.
    place : tuple of 2 ints
        Where its left, middle or right end is, and the middle of its height; px.
    size : int
        Height of the font in px.
    colour : tuple of 3 ints
        Red, green, blue.
    bold : bool
        Whether it is bold.
    align : str
        "left", "middle" or "right": what ``place`` is.

    Examples
    --------
    >>> image = np.zeros((20, 60, 3), np.uint8)
    >>> write_text(image, "ω", (5, 10), size=14, colour=(255, 255, 255))
    >>> bool(image.max() > 200)
    True
    """
    ink = _letters(text, size, bold=bold)
    height, width = ink.shape
    left = place[0] - {"left": 0, "middle": width // 2, "right": width}[align]
    top = place[1] - height // 2
    x0, y0 = max(left, 0), max(top, 0)
    x1, y1 = min(left + width, image.shape[1]), min(top + height, image.shape[0])
    if x0 >= x1 or y0 >= y1:
        return
    part = ink[y0 - top : y1 - top, x0 - left : x1 - left, None].astype(np.int32)
    under = image[y0:y1, x0:x1].astype(np.int32)
    mixed = under + ((np.array(colour, np.int32) - under) * part >> 8)
    image[y0:y1, x0:x1] = mixed.astype(np.uint8)
