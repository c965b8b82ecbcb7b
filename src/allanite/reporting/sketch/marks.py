"""What is drawn in a panel: lines, areas, boxes, segments and words, each a value that can write itself as SVG."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, Protocol

import numpy as np

from allanite.core.arrays import FloatArray

from . import svg as ink
from .axis import Unsketched, demanding

DATA, AXES, BLEND = "data", "axes", "blend"
"""What coordinates mean: data, fractions of the panel, or data along the abscissa and fractions up."""

Place = Callable[[FloatArray, FloatArray, str], tuple[FloatArray, FloatArray]]  # (x, y, meaning) -> points on the page

Points = tuple[FloatArray, FloatArray]


class Artist(Protocol):
    """Anything drawn in a panel."""

    @property
    def z(self) -> float:
        """Height: what is higher hides what is lower."""

    @property
    def label(self) -> str:
        """Words in the legend; empty if it is not there."""

    def extent(self) -> Points:
        """What the limits of the panel should hold: abscissas, ordinates."""

    def draw(self, place: Place) -> str:
        """As SVG."""

    def key(self, x: float, y: float, width: float, size: float) -> str:
        """As it stands in a legend, beside words of a size: from x on, around y."""


NOTHING = np.empty(0)

SHAPES: dict[str, Callable[[float], str]] = {
    "o": lambda r: f"m{-r:.3g} 0a{r:.3g} {r:.3g} 0 1 0 {2 * r:.3g} 0a{r:.3g} {r:.3g} 0 1 0 {-2 * r:.3g} 0z",
    "s": lambda r: f"m{-r:.3g} {-r:.3g}h{2 * r:.3g}v{2 * r:.3g}h{-2 * r:.3g}z",
    "D": lambda r: f"m0 {-1.41 * r:.3g}l{1.41 * r:.3g} {1.41 * r:.3g} {-1.41 * r:.3g} {1.41 * r:.3g} "
                   f"{-1.41 * r:.3g} {-1.41 * r:.3g}z",
    "^": lambda r: f"m0 {-r:.3g}l{r:.3g} {2 * r:.3g}h{-2 * r:.3g}z",
    "v": lambda r: f"m0 {r:.3g}l{-r:.3g} {-2 * r:.3g}h{2 * r:.3g}z",
    "P": lambda r: f"m{-r / 3:.3g} {-r:.3g}h{2 * r / 3:.3g}v{2 * r / 3:.3g}h{2 * r / 3:.3g}v{2 * r / 3:.3g}"
                   f"h{-2 * r / 3:.3g}v{2 * r / 3:.3g}h{-2 * r / 3:.3g}v{-2 * r / 3:.3g}h{-2 * r / 3:.3g}"
                   f"v{-2 * r / 3:.3g}h{2 * r / 3:.3g}z",
    "|": lambda r: f"m0 {-r:.3g}v{2 * r:.3g}", "_": lambda r: f"m{-r:.3g} 0h{2 * r:.3g}",
    ".": lambda r: SHAPES["o"](r / 2),
}  # fmt: skip
"""Markers as relative paths, by half their size."""

REACH = 8.0  # points at most from an abscissa to the edge of the strip in which its hint is shown

BARE = "|_"  # markers that have no inside


@dataclass(frozen=True)
class Marker:
    """What stands at the points of a line: shape, size, color inside and of the edge, width of the edge."""

    shape: str
    size: float
    inside: str
    edge: str
    width: float
    alpha: float | None = None

    def at(self, x: FloatArray, y: FloatArray) -> str:
        """At points of the page."""
        shape = SHAPES[self.shape](self.size / 2)
        visible = np.isfinite(x) & np.isfinite(y) & (np.abs(x) < ink.MAX_COORDINATE) & (np.abs(y) < ink.MAX_COORDINATE)
        places = zip(x[visible].tolist(), y[visible].tolist(), strict=True)
        d = "".join(f"M{ink.number(a)} {ink.number(b)}{shape}" for a, b in places)
        edge = ink.hexadecimal(self.edge) if self.width else None
        inside = "none" if self.shape in BARE else ink.hexadecimal(self.inside)
        return ink.element(d, ink.style(fill=inside, stroke=edge, stroke_width=f"{self.width:g}" if edge else None,
                                      opacity=self.alpha))  # fmt: skip


@dataclass(frozen=True, eq=False)
class LineMark:
    """A line through points, with or without markers."""

    x: FloatArray
    y: FloatArray
    color: str
    width: float
    dash: Sequence[float] = ()
    drawn: bool = True
    marker: Marker | None = None
    z: float = 2.0
    label: str = ""
    meaning: str = DATA
    reach: Points = field(default=(NOTHING, NOTHING))
    alpha: float | None = None

    def extent(self) -> Points:
        """See `Artist`."""
        return (self.x, self.y) if self.meaning == DATA else self.reach

    def draw(self, place: Place) -> str:
        """See `Artist`."""
        points = place(self.x, self.y, self.meaning)
        return self._through(points, points)

    def key(self, x: float, y: float, width: float, size: float) -> str:
        """See `Artist`."""
        ends = np.array([x, x + width]), np.array([y, y])
        return self._through(ends, (np.array([x + width / 2]), np.array([y])))

    def _through(self, points: Points, marked: Points) -> str:
        look = ink.stroke(self.color, self.width, self.dash, self.alpha)
        line = ink.element(ink.path(*points), look) if self.drawn else ""
        return line + (self.marker.at(*marked) if self.marker else "")


@dataclass(frozen=True, eq=False)
class Patch:
    """What is filled between two heights: in a legend a rectangle."""

    low: FloatArray
    high: FloatArray
    color: str
    alpha: float | None = None
    z: float = 1.0
    label: str = ""

    def key(self, x: float, y: float, width: float, size: float) -> str:
        """See `Artist`."""
        ends, half = np.array([x, x + width, x + width, x]), 0.35 * size
        around = np.array([y - half, y - half, y + half, y + half])
        return ink.element(ink.path(ends, around, closed=True), ink.fill(self.color, self.alpha))


@dataclass(frozen=True, eq=False, kw_only=True)
class Area(Patch):
    """What lies between two lines."""

    x: FloatArray

    def extent(self) -> Points:
        """See `Artist`."""
        return np.concatenate([self.x, self.x]), np.concatenate([self.low, self.high])

    def draw(self, place: Place) -> str:
        """See `Artist`."""
        (x, low), (_, high) = place(self.x, self.low, DATA), place(self.x, self.high, DATA)
        known = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
        edges = np.flatnonzero(np.diff(known, prepend=False, append=False)).reshape(-1, 2).tolist()
        d = "".join(
            ink.path(np.r_[x[a:b], x[a:b][::-1]], np.r_[low[a:b], high[a:b][::-1]], closed=True) for a, b in edges
        )
        return ink.element(d, ink.fill(self.color, self.alpha))


@dataclass(frozen=True, eq=False, kw_only=True)
class Boxes(Patch):
    """Rectangles: bars, and spans whose other side is the whole panel; `reach` is what limits should hold of them."""

    left: FloatArray
    right: FloatArray
    across: bool = False
    up: bool = False

    def extent(self) -> Points:
        """See `Artist`."""
        x = NOTHING if self.across else np.concatenate([self.left, self.right])
        return x, NOTHING if self.up else np.concatenate([self.low, self.high])

    def draw(self, place: Place) -> str:
        """See `Artist`."""
        corners = [(self.left, self.low), (self.right, self.high)]
        (x0, y0), (x1, y1) = (place(*corner, DATA) for corner in corners)
        if self.across:
            (x0, _), (x1, _) = (place(np.full(self.low.size, end), self.low, AXES) for end in (0.0, 1.0))
        if self.up:
            (_, y0), (_, y1) = (place(self.left, np.full(self.left.size, end), AXES) for end in (0.0, 1.0))
        d = "".join(ink.path(np.array([a, b, b, a]), np.array([c, c, e, e]), closed=True)
            for a, b, c, e in zip(x0.tolist(), x1.tolist(), y0.tolist(), y1.tolist(), strict=True))  # fmt: skip
        return ink.element(d, ink.fill(self.color, self.alpha))


class Beside:
    """What is in no legend, and for which no axis makes room."""

    label = ""

    def extent(self) -> Points:
        """See `Artist`."""
        return NOTHING, NOTHING

    def key(self, x: float, y: float, width: float, size: float) -> str:
        """See `Artist`."""
        return ""


@dataclass(frozen=True, eq=False)
class Words(Beside):
    """Text in a panel, on a ground of its own, with a line to what it is about."""

    text: str
    at: tuple[float, float]
    size: float
    color: str
    ha: str = "left"
    va: str = "baseline"
    bold: bool = False
    spacing: float = 1.2
    meaning: str = DATA
    offset: tuple[float, float] = (0.0, 0.0)
    pad: float | None = None
    opacity: float | None = None
    leader: tuple[float, float] | None = None
    z: float = 3.0

    def draw(self, place: Place) -> str:
        """See `Artist`."""
        x, y = self._point(place, self.at)
        x, y = x + self.offset[0], y - self.offset[1]
        lines, parts = ink.shown(self.text), []
        width, height = ink.size_of(lines, self.size, bold=self.bold, spacing=self.spacing)
        left = x - {"left": 0.0, "center": width / 2, "right": width}[self.ha]
        top = y - {"top": 0.0, "center": height / 2, "bottom": height, "baseline": height}[self.va]
        if self.leader is not None:
            # from the edge of the text to four points before what it is about; nothing if that is nearer
            centre = np.array([left + width / 2, top + height / 2])
            way = np.array(self._point(place, self.leader)) - centre
            length = float(np.hypot(*way))
            halves = zip((width / 2, height / 2), way.tolist(), strict=True)
            inside = min(((half + 1) / abs(part) for half, part in halves if part), default=1.0)
            outside = 1 - 4 / length if length else 0.0
            if inside < outside:
                ends = centre + np.outer([inside, outside], way)
                parts.append(ink.element(ink.path(ends[:, 0], ends[:, 1]), ink.stroke(self.color, 0.8)))
        if self.pad is not None:
            a, b = np.array([left, left + width]), np.array([top, top + height])
            beside = np.array([-self.pad, self.pad])
            a, b = a + beside, b + beside
            ground = ink.path(a[[0, 1, 1, 0]], b[[0, 0, 1, 1]], closed=True)
            parts.append(ink.element(ground, ink.fill("#ffffff", self.opacity)))
        parts.append(ink.words(lines, (x, y), self.size, color=self.color, ha=self.ha, va=self.va, bold=self.bold,
            spacing=self.spacing))  # fmt: skip
        return "".join(parts)

    def _point(self, place: Place, at: tuple[float, float]) -> tuple[float, float]:
        x, y = place(np.array([at[0]]), np.array([at[1]]), self.meaning)
        return float(x[0]), float(y[0])


@dataclass(frozen=True, eq=False)
class Hints(Beside):
    """What is shown under the cursor: a text for a strip about each abscissa; nothing for screen readers."""

    x: FloatArray
    texts: Sequence[str]
    z: float = 9.0

    def draw(self, place: Place) -> str:
        """See `Artist`."""
        x, _ = place(self.x, np.zeros(len(self.x)), BLEND)
        _, (foot, top) = place(np.zeros(2), np.array([0.0, 1.0]), AXES)
        between = (x[1:] + x[:-1]) / 2
        left, right = np.maximum(x - REACH, np.r_[-np.inf, between]), np.minimum(x + REACH, np.r_[between, np.inf])
        strips = (
            f'<path d="M{ink.number(a)} {ink.number(top)}H{ink.number(b)}V{ink.number(foot)}H{ink.number(a)}z">'
            f"<title>{escape(chr(10).join(ink.shown(text)))}</title></path>"
            for a, b, text in zip(left.tolist(), right.tolist(), self.texts, strict=True)
        )
        return f'<g aria-hidden="true" {ink.style(fill="transparent")}>{"".join(strips)}</g>'


SIZE = 8.0  # size of the letters, points

KEY, GAP, LEADING = 2.0 * SIZE, 0.8 * SIZE, 1.5 * SIZE
"""Length of a key, room between it and its words, and from line to line."""


class Legend:
    """Keys with words, filled column by column; columns `spacing` letters apart."""

    def __init__(self, handles: Sequence[Artist], labels: Sequence[str], columns: int, spacing: float = 2.0) -> None:
        self.labels = [" ".join(ink.shown(label)) for label in labels]
        count = max(1, min(columns, len(labels)))
        self.columns = [part.tolist() for part in np.array_split(np.arange(len(labels)), count)]
        self.handles, self.spacing = handles, spacing * SIZE
        self.widths = [max((KEY + GAP + ink.size_of([self.labels[i]], SIZE)[0] for i in column), default=0.0)
            for column in self.columns]  # fmt: skip

    def get_texts(self) -> list[str]:
        """None that matplotlib would read as a formula."""
        return []

    @property
    def width(self) -> float:
        """Points."""
        return sum(self.widths) + self.spacing * (len(self.widths) - 1)

    @property
    def height(self) -> float:
        """Points; none without entries."""
        return LEADING * max(map(len, self.columns)) + 4.0 if self.labels else 0.0

    def svg(self, left: float, top: float, color: str) -> str:
        """With its left upper corner there."""
        parts, x = [], left
        for column, width in zip(self.columns, self.widths, strict=True):
            for i, at in enumerate(column):
                y = top + (i + 0.5) * LEADING
                parts.append(self.handles[at].key(x, y, KEY, SIZE))
                parts.append(ink.words([self.labels[at]], (x + KEY + GAP, y), SIZE, color=color, va="center"))
            x += width + self.spacing
        return "".join(parts)


DASHES: dict[Any, tuple[float, ...]] = {"-": (), "": (), "--": (3.7, 1.6), ":": (1.0, 1.65)}
EDGE, DOT = 1.0, 6.0  # width of a marker's edge, and its size, where none is given

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
