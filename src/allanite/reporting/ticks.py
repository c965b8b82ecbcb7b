"""Ticks, labels and grid of an axis drawn at once; matplotlib's one object a tick takes most of a figure's time.

Within `drawn_at_once` the axes of a figure are hidden, and an artist that draws the same replaces each. The figure
is an ordinary one before and afterwards; what matplotlib draws itself is the reference.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.layout_engine import LayoutEngine
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import NullLocator
from matplotlib.transforms import Bbox

from allanite.core.arrays import BoolArray, FloatArray

from .measure import Measure

NEAR = 1e-10
"""A tick so far outside of the view, relative to its width, is drawn."""


@contextmanager
def drawn_at_once(figure: Figure, measure: Measure | None = None) -> Iterator[None]:
    """Save a figure with its ticks drawn by `Ticks`, and without drawing it for its layout.

    `measure` gives the size of a text, instead of the renderer.
    """
    panels = [axes for axes in _panels(figure.axes) if axes.axison and axes.get_visible()]
    made = [Ticks(axis) for axes in panels for axis in (axes.xaxis, axes.yaxis) if axis.get_visible()]
    try:
        for ticks in made:
            ticks.begin()
        vars(figure)["draw"] = partial(_draw, figure, figure.get_layout_engine(), measure)
        yield
    finally:
        vars(figure).pop("draw", None)
        for ticks in made:
            ticks.end()


def _draw(figure: Figure, layout: LayoutEngine | None, measure: Measure | None, renderer: RendererBase) -> None:
    """`savefig` draws a figure twice: with its layout and nothing to see, and as it is then, without one."""
    if measure is not None:
        vars(renderer)["get_text_width_height_descent"] = measure
    if layout is None or figure.get_layout_engine() is not layout:
        type(figure).draw(figure, renderer)
    else:
        layout.execute(figure)


def _panels(panels: Sequence[object]) -> Iterator[Axes]:
    for axes in panels:
        if isinstance(axes, Axes):
            yield axes
            yield from _panels(axes.child_axes)


class Ticks(Artist):
    """Draws an axis, in its place."""

    def __init__(self, axis: Axis) -> None:
        super().__init__()
        self.axis = axis
        self.across = axis is axis.axes.xaxis
        self.set_zorder(axis.get_zorder())
        self.boxes: dict[tuple[float, str], Bbox] = {}  # of labels, from their places

    def begin(self) -> None:
        """Take the place of the axis."""
        self.axis.axes.add_artist(self)
        self.set_clip_on(False)
        self.axis.set_visible(False)

    def end(self) -> None:
        """Give it back."""
        self.axis.set_visible(True)
        self.remove()

    def get_tightbbox(self, renderer: RendererBase | None = None) -> Bbox | None:
        """What the ticks, their labels and the name of the axis cover; a name has no length, as in other layouts."""
        assert renderer is not None  # noqa: S101 - a layout has one
        boxes = [box for kind in self._kinds() for *_, box in self._labels(kind, renderer)]
        offset, label = self._offset(boxes), self._name(boxes)
        boxes += [offset.get_window_extent(renderer)] if offset.get_text() and offset.get_visible() else []
        if label.get_text() and label.get_visible():
            box = label.get_window_extent(renderer)
            x, y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
            thin = (x - 0.5, box.y0, x + 0.5, box.y1) if self.across else (box.x0, y - 0.5, box.x1, y + 0.5)
            boxes.append(Bbox.from_extents(*thin))
        return Bbox.union(boxes) if boxes else None

    def draw(self, renderer: RendererBase) -> None:
        """Draw grid, ticks and labels."""
        boxes = []
        for kind in self._kinds():
            tick, places, _ = kind
            for line, ends in ((tick.gridline, (0.0, 1.0)), (tick.tick1line, (0.0,)), (tick.tick2line, (1.0,))):
                if line.get_visible():
                    self._line(line, places, ends).draw(renderer)
            for text, position, words, box in self._labels(kind, renderer):
                text.set(text=words, position=position)
                text.draw(renderer)
                boxes.append(box)
        for further in (self._name(boxes), self._offset(boxes)):
            further.draw(renderer)

    def _kinds(self) -> list[tuple[Tick, FloatArray, list[str]]]:
        """A tick as an example, the places within the view and their labels, of major and of minor ticks."""
        axis = self.axis
        found = []
        for locator, formatter, places, example in (
            (axis.get_major_locator(), axis.get_major_formatter(), axis.get_majorticklocs, axis.get_major_ticks),
            (axis.get_minor_locator(), axis.get_minor_formatter(), axis.get_minorticklocs, axis.get_minor_ticks),
        ):
            if not isinstance(locator, NullLocator):
                at = np.asarray(places(), dtype=float)
                labels = formatter.format_ticks(at.tolist())
                seen = self._within(at)
                found.append(
                    (example(1)[0], at[seen], [label for label, is_in in zip(labels, seen, strict=True) if is_in])
                )
        return found

    def _within(self, places: FloatArray) -> BoolArray:
        transform = self.axis.get_transform()
        low, high = np.sort(transform.transform(np.asarray(self.axis.get_view_interval())))
        at = transform.transform(places)
        slack = NEAR * (high - low)
        return np.asarray((at >= low - slack) & (at <= high + slack))

    def _line(self, example: Line2D, places: FloatArray, ends: tuple[float, ...]) -> Line2D:
        """The marks of all ticks, or with two ends their grid lines, as one line."""
        gaps = (*ends, np.nan) if len(ends) > 1 else ends
        along, aside = np.repeat(places, len(gaps)), np.tile(gaps, len(places))
        line = Line2D(*((along, aside) if self.across else (aside, along)))
        line.update_from(example)
        line.set_figure(self.axis.axes.figure)
        return line

    def _labels(
        self, kind: tuple[Tick, FloatArray, list[str]], renderer: RendererBase
    ) -> Iterator[tuple[Text, tuple[float, float], str, Bbox]]:
        """The labels that are shown: an object to draw them with, where, what, and what it covers."""
        tick, places, labels = kind
        for example, end in ((tick.label1, 0.0), (tick.label2, 1.0)):
            if not example.get_visible() or not any(labels):
                continue
            text = Text()
            text.update_from(example)
            text.set_figure(self.axis.axes.figure)
            positions = [(place, end) if self.across else (end, place) for place in places.tolist()]
            shown = text.get_transform().transform(positions)
            for position, (x, y), words in zip(positions, shown, labels, strict=True):
                if words:
                    if (key := (end, words)) not in self.boxes:
                        text.set(text=words, position=position)
                        self.boxes[key] = text.get_window_extent(renderer).translated(-x, -y)
                    yield text, position, words, self.boxes[key].translated(x, y)

    def _name(self, boxes: Sequence[Bbox]) -> Text:
        """The name of the axis, beyond the labels."""
        axis, label = self.axis, self.axis.label
        side = axis.get_label_position()
        edge = axis.axes.spines[side].get_window_extent() if side in axis.axes.spines else axis.axes.bbox
        pad = axis.labelpad * self._pixels()
        around = Bbox.union([*boxes, edge])
        at = {"bottom": around.y0 - pad, "top": around.y1 + pad, "left": around.x0 - pad, "right": around.x1 + pad}[
            side
        ]
        x, y = label.get_position()
        label.set_position((x, at) if self.across else (at, y))
        return label

    def _offset(self, boxes: Sequence[Bbox]) -> Text:
        """What the labels are to be multiplied by or added to, at the end of the axis."""
        axis, text = self.axis, self.axis.offsetText
        text.set_text(axis.get_major_formatter().get_offset())
        pad = axis.OFFSETTEXTPAD * self._pixels()
        bottom = Bbox.union(boxes).y0 if boxes else axis.axes.bbox.ymin
        text.set_y(bottom - pad if self.across else axis.axes.bbox.ymax + pad)
        return text

    def _pixels(self) -> float:
        """Pixels of a point."""
        figure = self.axis.get_figure(root=True)
        assert figure is not None  # noqa: S101 - an axis that is drawn has one
        return figure.dpi / 72
