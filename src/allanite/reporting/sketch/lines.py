"""Lines and markers by the words that matplotlib has for them."""

from typing import Any

import numpy as np

from .limits import Unsketched, demanding
from .marks import DATA, SHAPES, LineMark, Marker

DASHES: dict[Any, tuple[float, ...]] = {"-": (), "": (), "--": (3.7, 1.6), ":": (1.0, 1.65)}
EDGE, DOT = 1.0, 6.0
"""Width of a marker's edge, and its size, where none is given."""

_LINES = ("-", "--", ":")


@demanding
def line_of(  # noqa: PLR0913 - as matplotlib has it
    x: Any, y: Any, form: str = "", *, color: str, lw: float = 1.5, ls: Any = None, marker: str = "", ms: float = DOT,
    mfc: str = "", mec: str = "", mew: float | None = None, label: str = "", zorder: float = 2.0, transform: str = DATA,
    alpha: float | None = None,
) -> LineMark:  # fmt: skip
    """A line, markers, or both, by the words that matplotlib has for them."""
    shape = next((letter for letter in form if letter in SHAPES), marker)
    drawn = any(part in form for part in _LINES) if form else ls != ""
    if form.replace(shape, "", 1) not in ("", *_LINES) or (shape and shape not in SHAPES):
        raise Unsketched(f"line {form or marker}")
    made = Marker(shape, ms, mfc or color, mec or color, EDGE if mew is None else mew, alpha) if shape and ms else None
    dash = ls[1] if isinstance(ls, tuple) else DASHES[ls or "-"]
    x, y = np.array(x, dtype=float, ndmin=1), np.array(y, dtype=float, ndmin=1)
    return LineMark(x, y, color, lw, dash, drawn, made, zorder, label, transform, alpha=alpha)
