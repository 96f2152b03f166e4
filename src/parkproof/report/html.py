"""What the pages are made of: their style, numbers as text, and pictures inside the file."""

import base64
import math
from html import escape
from typing import Literal

STYLE_SHEET = """\
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1b1f24; margin: 0 auto;
  max-width: 1240px; padding: 1.5rem; }
h1 { font-size: 1.7rem; margin-bottom: 0.2rem; } h2 { margin-top: 2.4rem; font-size: 1.3rem; }
p, li { max-width: 75ch; } .lead { color: #444c56; }
table { border-collapse: collapse; width: 100%; font-size: 0.92rem; }
th, td { text-align: left; vertical-align: top; padding: 0.45rem 0.7rem;
  border-bottom: 1px solid #d5d9de; }
th { border-bottom: 2px solid #8b929b; }
td.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
figure { margin: 0; } figcaption { font-size: 0.88rem; color: #444c56;
  padding: 0.2rem 0.4rem 0.8rem; }
img { width: 100%; height: auto; border: 1px solid #e4e7ea; }
footer { margin-top: 3rem; color: #57606a; font-size: 0.85rem; }
"""
"""Type, tables and figures, the same on every page."""

_MEDIA = {"png": "image/png", "svg": "image/svg+xml"}


def picture(
    data: bytes, caption: str, *, kind: Literal["png", "svg"] = "png", note: str = ""
) -> str:
    """A picture with its caption, held by the page itself.

    Parameters
    ----------
    data : bytes
        The picture's file.
    caption : str
        Plain text.
    kind : "png" or "svg"
        What it is.
    note : str
        HTML that follows the caption.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> picture(b"<svg/>", "x < 1", kind="svg")[:63]
    '<figure><img alt="x &lt; 1" src="data:image/svg+xml;base64,PHN2'
    """
    text = escape(caption)
    return (
        f'<figure><img alt="{text}" src="data:{_MEDIA[kind]};base64,'
        f'{base64.b64encode(data).decode("ascii")}"><figcaption>{text}{note}</figcaption></figure>'
    )


def number_text(value: float | None) -> str:
    """A number for a reader: three digits, or all of a large one, and a dash for none.

    Parameters
    ----------
    value : float or None
        The number.

    Returns
    -------
    str
        Text without characters that HTML reserves.

    Examples
    --------
    >>> number_text(1234567.8), number_text(-0.01234), number_text(None), number_text(float("nan"))
    ('1,234,568', '−0.0123', '–', '–')
    """
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:,.0f}" if 1000.0 <= abs(value) < 1e9 else f"{value:.3g}"
    return text.replace("inf", "∞").replace("-", "−")
