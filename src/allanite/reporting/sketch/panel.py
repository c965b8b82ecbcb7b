"""A panel of a figure: what is drawn in it, its axes and titles."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray

from .axis import Side, Unsketched, limited
from .marks import AXES, BLEND, DASHES, DATA, DOT, EDGE, Area, Artist, Boxes, Hints, Legend, LineMark, Words, line_of

CORNER, ABOVE = "upper right", "lower center"  # where a legend stands: of a panel in its corner, or of a point above it


@limited
class Panel:
    """The part of matplotlib's `Axes` that figures of a page use; lengths in points."""

    def __init__(self, x: Side, ink: str, geometry: tuple[int, int]) -> None:
        self.xaxis, self.yaxis, self.ink = x, Side(across=False), ink
        self.marks: list[Artist] = []
        self.grids: dict[str, tuple[str, float, float | None]] = {}  # color, width, opacity
        self.titles: dict[str, tuple[str, float, str, bool]] = {}  # text, size, color, whether it is bold
        self.legends: tuple[Legend, bool] | None = None  # and whether it stands in the corner
        self.axison, self.labelled, self.equal = True, True, False
        self.minor_length = 2.0
        self.figure: Any = None
        self.geometry = geometry

    transAxes = AXES  # noqa: N815 - as matplotlib has it

    def get_xaxis_transform(self) -> str:
        """Data along the abscissa, fractions of the panel up."""
        return BLEND

    def get_figure(self, *, root: bool = False) -> Any:
        """The figure."""
        return self.figure

    def get_subplotspec(self) -> "Panel":
        """Something with a grid that has a geometry."""
        return self

    get_gridspec = get_subplotspec

    def get_geometry(self) -> tuple[int, int]:
        """Rows and columns of panels."""
        return self.geometry

    def set(self, **properties: Any) -> None:
        """Several properties at once; scales first."""
        for name in sorted(properties, key=lambda name: not name.endswith("scale")):
            getattr(self, f"set_{name}")(properties[name])

    def set_xscale(self, scale: str) -> None:
        """Linear or logarithmic."""
        self.xaxis.scale = scale

    def set_yscale(self, scale: str) -> None:
        """Linear or logarithmic."""
        self.yaxis.scale = scale

    def set_xlabel(self, label: str) -> None:
        """What the abscissa is."""
        self.xaxis.label = label

    def set_ylabel(self, label: str, *, parse_math: bool = False) -> None:
        """What the ordinate is."""
        if parse_math:
            raise Unsketched("formulas")
        self.yaxis.label = label

    def set_xlim(self, low: Any, high: Any = None) -> None:
        """Ends of the abscissa."""
        self.xaxis.limits = (float(low), float(high)) if high is not None else (float(low[0]), float(low[1]))

    def set_ylim(self, low: Any, high: Any = None) -> None:
        """Ends of the ordinate."""
        self.yaxis.limits = (float(low), float(high)) if high is not None else (float(low[0]), float(low[1]))

    def set_xticks(self, places: Sequence[float]) -> None:
        """Ticks of the abscissa."""
        self.xaxis.set_ticks(places)

    def get_xlim(self) -> tuple[float, float]:
        """Ends of the abscissa."""
        return self.xaxis.get_view_interval()

    def get_ylim(self) -> tuple[float, float]:
        """Ends of the ordinate."""
        return self.yaxis.get_view_interval()

    def set_axis_off(self) -> None:
        """Draw nothing but what was drawn."""
        self.axison = False

    def set_axis_on(self) -> None:
        """Draw the axes."""
        self.axison = True

    def set_aspect(self, aspect: str, *, adjustable: str, anchor: str) -> None:
        """Equal lengths on both axes, at the top of the place."""
        if (aspect, adjustable, anchor) != ("equal", "box", "N"):
            raise Unsketched(f"aspect {aspect}")
        self.equal = True

    def grid(self, *, which: str, color: str, linewidth: float, alpha: float | None = None) -> None:
        """Lines at major or minor ticks."""
        self.grids[which] = color, linewidth, alpha

    def tick_params(self, *, which: str = "", length: float = 2.0, labelbottom: bool | None = None) -> None:
        """Length of minor ticks; whether the abscissa has labels."""
        if which:
            self.minor_length = length
        if labelbottom is not None:
            self.labelled = labelbottom

    def set_title(
        self, text: str, *, loc: str = "center", fontsize: float = 10.0, color: str = "", fontweight: str = "",
        parse_math: bool = False,
    ) -> None:  # fmt: skip
        """A title at the left, right or middle."""
        if parse_math:
            raise Unsketched("formulas")
        self.titles[loc] = text, float(fontsize), color or self.ink, fontweight == "bold"

    def legend(
        self, handles: Sequence[Artist] | None = None, labels: Sequence[str] = (), *, loc: str, ncols: int = 1,
        columnspacing: float = 2.0, bbox_to_anchor: tuple[float, float] | None = None,
    ) -> Any:  # fmt: skip
        """What the lines are: in a corner of the panel, or above it."""
        if (loc, bbox_to_anchor) not in ((CORNER, None), (ABOVE, (0.5, 1.0))):
            raise Unsketched("legend")
        if handles is None:
            handles, labels = self.get_legend_handles_labels()
        self.legends = Legend(handles, labels, ncols, columnspacing), loc == CORNER
        return self.legends[0]

    def hint(self, x: Any, texts: Sequence[str]) -> None:
        """Texts that are shown under the cursor, which matplotlib has not."""
        self._add(Hints(np.asarray(x, dtype=float), texts))

    def get_legend_handles_labels(self) -> tuple[list[Artist], list[str]]:
        """What stands in a legend."""
        named = [mark for mark in self.marks if mark.label]
        return named, [mark.label for mark in named]

    def plot(self, x: Any, y: Any, form: str = "", **look: Any) -> None:
        """A line, markers, or both."""
        self._add(line_of(x, y, form, **{"color": look.get("mec") or self.ink} | look))

    def fill_between(
        self, x: Any, low: Any, high: Any, *, color: str, alpha: float | None = None, lw: float = 0, label: str = "",
        zorder: float = 1.0,
    ) -> None:  # fmt: skip
        """What lies between two lines."""
        x, low, high = np.broadcast_arrays(*(np.asarray(part, dtype=float) for part in (x, low, high)))
        self._add(Area(low, high, color, alpha, zorder, label, x=x), wide=bool(lw))

    def axhspan(self, low: float, high: float, *, color: str, alpha: float, lw: float = 0, zorder: float = 1.0) -> None:
        """A strip across the panel."""
        ends, nothing = (np.array([low], dtype=float), np.array([high], dtype=float)), np.zeros(1)
        self._add(Boxes(*ends, color, alpha, zorder, left=nothing, right=nothing, across=True), wide=bool(lw))

    def axvspan(
        self, low: float, high: float, *, color: str, lw: float = 0, zorder: float = 1.0, label: str = ""
    ) -> None:
        """A strip up the panel."""
        left, right, nothing = np.array([low], dtype=float), np.array([high], dtype=float), np.zeros(1)
        self._add(Boxes(nothing, nothing, color, None, zorder, label, left=left, right=right, up=True), wide=bool(lw))

    def axhline(self, at: float, *, color: str, lw: float, ls: Any = "-", zorder: float = 2.0, label: str = "") -> None:
        """A line across the panel."""
        self._rule(np.array([0.0, 1.0]), np.full(2, float(at)), "rule", (color, lw, ls, zorder, label))

    def axvline(self, at: float, *, color: str, lw: float, ls: Any = "-", zorder: float = 2.0, label: str = "") -> None:
        """A line up the panel."""
        self._rule(np.full(2, float(at)), np.array([0.0, 1.0]), BLEND, (color, lw, ls, zorder, label))

    def _rule(self, x: FloatArray, y: FloatArray, meaning: str, look: tuple[str, float, Any, float, str]) -> None:
        color, lw, ls, zorder, label = look
        dash = ls[1] if isinstance(ls, tuple) else DASHES[ls]
        reach = (np.empty(0), y) if meaning == "rule" else (x, np.empty(0))
        self._add(LineMark(x, y, color, lw, dash, z=zorder, label=label, meaning=meaning, reach=reach))

    def hlines(self, y: Any, left: Any, right: Any, *, color: str, lw: float, zorder: float = 2.0) -> None:
        """Lines across, of their own lengths."""
        y, left, right = np.broadcast_arrays(*(np.asarray(part, dtype=float) for part in (y, left, right)))
        self._segments((left, right), (y, y), color, lw, zorder)

    def errorbar(  # noqa: PLR0913 - as matplotlib has it
        self, x: Any, y: Any, error: Any, *, fmt: str, color: str = "", ecolor: str = "", lw: float = 1.5,
        elinewidth: float = 0.0, capsize: float = 0.0, ms: float = DOT, mew: float = EDGE, zorder: float = 2.0,
        label: str = "",
    ) -> None:  # fmt: skip
        """Lines up, around points, which `fmt` "none" leaves out; errors of shape (k,), or (2, k) below and above."""
        error = np.broadcast_to(np.asarray(error, dtype=float), (2, np.size(x)))
        ends, line = (y - error[0], y + error[1]), ecolor or color
        self._segments((np.asarray(x, dtype=float),) * 2, ends, line, elinewidth or lw, zorder)
        if capsize:
            for end in ends:
                self.plot(x, end, "_", color=line, ms=2 * capsize, zorder=zorder)
        if fmt != "none":
            self.plot(x, y, fmt, color=color, ms=ms, mew=mew, zorder=zorder, label=label)

    def _segments(
        self, x: tuple[FloatArray, FloatArray], y: tuple[FloatArray, FloatArray], color: str, lw: float, zorder: float
    ) -> None:
        between = np.full(x[0].size, np.nan)
        along, up = (np.column_stack([*ends, between]).ravel() for ends in (x, y))
        self._add(LineMark(along, up, color, lw, z=zorder))

    def stairs(self, values: Any, edges: Any, *, baseline: None, color: str, lw: float) -> None:
        """Steps between edges."""
        if baseline is not None:
            raise Unsketched("stairs with a base")
        self._add(LineMark(np.repeat(edges, 2)[1:-1], np.repeat(values, 2), color, lw))

    def bar(
        self, x: Any, height: Any, width: Any = 0.8, *, color: str, align: str = "center", alpha: float | None = None,
        zorder: float = 1.0,
    ) -> None:  # fmt: skip
        """Bars from zero."""
        x, height, width = np.broadcast_arrays(*(np.asarray(part, dtype=float) for part in (x, height, width)))
        left = x - width / 2 if align == "center" else x
        self._add(Boxes(np.zeros(x.size), height, color, alpha, zorder, left=left, right=left + width))

    def text(  # noqa: PLR0913 - as matplotlib has it
        self, x: float, y: float, text: str, *, transform: str = DATA, ha: str = "left", va: str = "baseline",
        fontsize: float = 9.0, color: str = "", zorder: float = 3.0, bbox: dict[str, Any] | None = None,
    ) -> None:  # fmt: skip
        """Words at a point."""
        pad, opacity = _ground(bbox)
        at = (float(x), float(y))
        self._add(Words(text, at, fontsize, color or self.ink, ha, va, meaning=transform, pad=pad, opacity=opacity,
                        z=zorder))  # fmt: skip

    def annotate(  # noqa: PLR0913 - as matplotlib has it
        self, text: str, xy: Any, xytext: Any = None, *, xycoords: Any = DATA, textcoords: Any = None, ha: str = "left",
        va: str = "baseline", fontsize: float = 9.0, color: str = "", zorder: float = 3.0, linespacing: float = 1.2,
        parse_math: bool = False, bbox: dict[str, Any] | None = None, arrowprops: dict[str, Any] | None = None,
    ) -> None:  # fmt: skip
        """Words beside a point, with a line to it."""
        pad, opacity = _ground(bbox)
        meaning = {"axes fraction": AXES, "data": DATA, ("data", "axes fraction"): BLEND}.get(xycoords)
        if meaning is None or parse_math:
            raise Unsketched("annotation")
        moved = textcoords == "offset points"
        at = xy if moved or xytext is None else xytext
        offset = (float(xytext[0]), float(xytext[1])) if moved else (0.0, 0.0)
        leader = None if arrowprops is None else (float(xy[0]), float(xy[1]))
        self._add(Words(text, (float(at[0]), float(at[1])), fontsize, color or self.ink, ha, va, spacing=linespacing,
            meaning=meaning, offset=offset, pad=pad, opacity=opacity, leader=leader, z=zorder))  # fmt: skip

    def _add(self, mark: Artist, *, wide: bool = False) -> None:
        if wide:
            raise Unsketched("edge of an area")
        x, y = mark.extent()
        self.xaxis.known.append(x)
        self.yaxis.known.append(y)
        self.marks.append(mark)


def _ground(bbox: dict[str, Any] | None) -> tuple[float | None, float | None]:
    """Room around words on a white ground, and how opaque it is."""
    if bbox is None:
        return None, None
    if bbox["facecolor"] != "white" or bbox["edgecolor"] != "none":
        raise Unsketched("ground of words")
    return float(bbox["pad"]), bbox.get("alpha")


def place_in(panel: Panel, box: tuple[float, float, float, float]) -> Any:
    """Where things of a panel are on the page, whose left upper corner, width and height are given."""
    left, top, width, height = box

    def place(x: FloatArray, y: FloatArray, meaning: str) -> tuple[FloatArray, FloatArray]:
        across = x if meaning in (AXES, "rule") else panel.xaxis.share(x)
        up = y if meaning in (AXES, BLEND) else panel.yaxis.share(y)
        return left + width * across, top + height * (1 - up)

    return place
