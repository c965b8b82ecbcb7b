"""A figure of a page: panels in a grid, a legend above them, and all of it as SVG."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from . import svg as ink
from .axes_box import LABEL, TICK, PanelFrame
from .axis import Side
from .layout import arranged
from .legend import Legend
from .limits import Unsketched, limited
from .marks import Mark
from .panel import Panel

POINTS = 72.0
"""Points of an inch."""


class Look(NamedTuple):
    """Colors of a figure: of letters, and of axes."""

    ink: str
    edge: str


@limited
class Chart:
    """The part of matplotlib's `Figure` that figures of a page use.

    Examples
    --------
    >>> chart = Chart(4.0, 3.0, Look("#1a1a1a", "#555b63"))
    >>> panel = chart.subplots()
    >>> panel.plot([1, 2, 3], [1.0, 4.0, 9.0], color="#2e5c94", label="squares")
    >>> text = chart.svg()
    >>> text.startswith("<svg"), text.endswith("</svg>"), ">9</text>" in text
    (True, True, True)
    """

    def __init__(self, width: float, height: float, look: Look) -> None:
        self.width, self.height, self.look = width * POINTS, height * POINTS, look
        self.grid: list[list[Panel]] = []
        self.ratios: tuple[list[float], list[float]] = ([], [])
        self.key: Legend | None = None

    @property
    def axes(self) -> list[Panel]:
        """All panels, row by row."""
        return [panel for row in self.grid for panel in row]

    def get_figwidth(self) -> float:
        """Width in inches."""
        return self.width / POINTS

    def get_size_inches(self) -> tuple[float, float]:
        """Width and height."""
        return self.width / POINTS, self.height / POINTS

    def subplots(
        self,
        rows: int = 1,
        columns: int = 1,
        *,
        squeeze: bool = True,
        sharex: bool | str = False,
        width_ratios: Sequence[float] | None = None,
        height_ratios: Sequence[float] | None = None,
    ) -> Any:
        """Panels, shape (rows, columns), without dimensions of one unless `squeeze` is false."""
        if self.grid:
            raise Unsketched("panels twice")
        across = [Side(across=True) for _ in range(columns)]
        for i in range(rows):
            sides = across if sharex else [Side(across=True) for _ in range(columns)]
            self.grid.append([Panel(side, self.look.ink, (rows, columns)) for side in sides])
            for panel in self.grid[-1]:
                panel.figure = self
                panel.labelled = not sharex or i == rows - 1
        self.ratios = (list(width_ratios or [1.0] * columns), list(height_ratios or [1.0] * rows))
        found = np.empty((rows, columns), dtype=object)
        for i, row in enumerate(self.grid):
            for j, panel in enumerate(row):
                found[i, j] = panel
        if not squeeze:
            return found
        return found.item() if found.size == 1 else found.squeeze()

    def legend(
        self, handles: Sequence[Mark], labels: Sequence[str], *, loc: str, ncols: int, columnspacing: float
    ) -> Legend:
        """What the lines of all panels are, above them."""
        if loc != "outside upper center":
            raise Unsketched(f"legend {loc}")
        self.key = Legend(handles, labels, ncols, columnspacing)
        return self.key

    def svg(self) -> str:
        """The figure."""
        top = self.key.height + LABEL if self.key and self.key.labels else 0.0
        boxes = arranged(self.grid, self.ratios, (self.width, self.height, top))
        wide, high = (f"{length:g}" for length in (round(self.width, 1), round(self.height, 1)))
        ground = ink.element(f"M0 0H{wide}V{high}H0Z", ink.fill("#ffffff"))
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}pt" height="{high}pt" viewBox="0 0 {wide} {high}">'
            + ground
        ]
        for i, (panel, box) in enumerate((p, b) for p, b in boxes if p.axison):
            parts.append(PanelFrame(panel, box, self.look.edge).svg(i))
        if self.key is not None and self.key.labels:
            parts.append(self.key.svg((self.width - self.key.width) / 2, TICK, self.look.ink))
        return "".join([*parts, "</svg>"])
