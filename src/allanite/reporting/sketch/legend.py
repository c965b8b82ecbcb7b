"""A legend: keys of marks with words."""

from collections.abc import Sequence

import numpy as np

from . import svg as ink
from .marks import Artist

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
        self.widths = [
            max((KEY + GAP + ink.size_of([self.labels[i]], SIZE)[0] for i in column), default=0.0)
            for column in self.columns
        ]

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
