"""Pieces of SVG: numbers, paths, styles, and words with their widths, those of the font of matplotlib."""

import os
import re
from collections.abc import Iterable, Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.units import RAISED
from allanite.reporting.fonts import ON_PAGE
from allanite.reporting.language import tr

from .axis import Unsketched

ABOVE, BELOW = 0.76, 0.24  # height of a line above and below its foot, sizes of the letters
FULL_WIDTH = 1.0  # width of a letter that the font does not have, sizes: Chinese ones are squares


@cache
def wide(text: str, *, bold: bool = False) -> float:
    """Width of a line of text, in sizes of its letters."""
    return sum(_letter(letter, bold) for letter in text)


@cache
def _letter(letter: str, bold: bool) -> float:
    font = _font(bold)
    if not font.get_char_index(ord(letter)):
        return FULL_WIDTH
    return float(font.load_char(ord(letter)).linearHoriAdvance) / 65536 / _SIZE


_SIZE = 100.0


@cache
def _font(bold: bool) -> Any:
    from matplotlib import get_data_path
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(Path(get_data_path(), "fonts", "ttf", f"DejaVuSans{'-Bold' if bold else ''}.ttf")))
    font.set_size(_SIZE, 72)
    return font


if hasattr(os, "register_at_fork"):  # processes that share an open file move each other's place in it
    os.register_at_fork(after_in_child=_font.cache_clear)


MAX_COORDINATE = 20_000.0
"""Points beyond which a coordinate is not drawn any farther: browsers count in single precision."""

_POWER = re.compile(r"\$(×?)10\^\{(-?\d+)\}\$")

_BLANKS = re.compile(" {2,}")


def number(value: float) -> str:
    """A coordinate in points, to a tenth."""
    return f"{value:.1f}".removesuffix(".0")


def path(x: FloatArray, y: FloatArray, *, closed: bool = False) -> str:
    """Lines through points; a point that is not finite ends one."""
    finite = np.isfinite(x) & np.isfinite(y)
    runs = np.flatnonzero(np.diff(finite, prepend=False, append=False)).reshape(-1, 2).tolist()
    points = np.clip(np.round(np.column_stack([x, y]), 1), -MAX_COORDINATE, MAX_COORDINATE) + 0.0
    parts = (f"M%g %g{' %g %g' * (end - start - 1)}" % tuple(points[start:end].ravel().tolist()) for start, end in runs)
    return "".join(parts) + ("Z" if closed and runs else "")


def style(**properties: "str | float | None") -> str:
    """An attribute of these properties, but for those that are None."""
    known = (f"{name.replace('_', '-')}: {value}" for name, value in properties.items() if value is not None)
    return f'style="{"; ".join(known)}"'


@cache
def hexadecimal(color: str) -> str:
    """A color as the style sheet of a page names it."""
    if color != "white" and not re.fullmatch("#[0-9a-fA-F]{6}", color):
        raise Unsketched(f"color {color}")
    return "#ffffff" if color == "white" else color.lower()


def stroke(color: str, width: float, dash: Sequence[float] = (), opacity: float | None = None) -> str:
    """The style of a line; dashes are in widths of it."""
    dashes = ",".join(f"{width * part:.4g}" for part in dash) or None
    return style(fill="none", stroke=hexadecimal(color), stroke_width=f"{width:.4g}", stroke_dasharray=dashes,
        stroke_opacity=opacity)  # fmt: skip


def fill(color: str, opacity: float | None = None) -> str:
    """The style of an area."""
    return style(fill=hexadecimal(color), fill_opacity=opacity)


def element(d: str, styled: str) -> str:
    """A path; nothing if it is empty."""
    return f'<path d="{d}" {styled}/>' if d else ""


def shown(text: str) -> list[str]:
    """Lines of a text as they are read, in the language that is spoken; powers of ten in raised digits."""
    text = str(tr(text))
    if "$" in text:
        text = _POWER.sub(lambda found: f"{found[1]}10{found[2].translate(RAISED)}", text)
    return text.splitlines()


def size_of(lines: Iterable[str], size: float, *, bold: bool = False, spacing: float = 1.2) -> tuple[float, float]:
    """Width and height of lines of text."""
    widths = [wide(line, bold=bold) * size for line in lines]
    return max(widths, default=0.0), size * (1 + spacing * (len(widths) - 1)) if widths else 0.0


ANCHORS = {"left": "start", "center": "middle", "right": "end"}


def words(  # noqa: PLR0913 - each has a default, and is a property of its own
    lines: Sequence[str], at: tuple[float, float], size: float, *, color: str, ha: str = "left", va: str = "baseline",
    bold: bool = False, spacing: float = 1.2, turned: bool = False,
) -> str:  # fmt: skip
    """Lines of text at a point; `turned`, it runs upwards."""
    step = spacing * size
    _, height = size_of(lines, size, spacing=spacing)
    above = {"baseline": -ABOVE * size, "top": 0.0, "center": -height / 2, "bottom": -height}[va] + ABOVE * size
    look = style(font=f"{'bold ' if bold else ''}{size:g}px {ON_PAGE}",
        text_anchor=ANCHORS[ha] if ha != "left" else None, fill=hexadecimal(color))  # fmt: skip
    x, y = at
    turn = f' transform="rotate(-90 {number(x)} {number(y)})"' if turned else ""
    # several blanks, of which browsers show one
    kept = (_BLANKS.sub(lambda blanks: "\N{NO-BREAK SPACE}" * len(blanks[0]), line) for line in lines)
    return "".join(f'<text x="{number(x)}" y="{number(y + above + i * step)}"{turn} {look}>{escape(line)}</text>'
        for i, line in enumerate(kept) if line.strip())  # fmt: skip
