"""The quality of a channel that is read in parts: what is found in every part, and in blocks here and there."""

from dataclasses import replace

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.finding import Finding, Quality
from allanite.core.record import Record
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import percent
from allanite.prepare.outliers import Outliers, outliers
from allanite.prepare.quality import inspect
from allanite.prepare.readings import clipped, outlying, stuck
from allanite.prepare.view import View

BLOCK = 1 << 16
"""Samples of a block that is inspected as a whole record is."""

BLOCKS = 32
"""Blocks that are inspected, at most about so many, evenly spread."""

RUN = 10
"""Equal values below which none is stuck or clipped."""

FEWEST = 64
"""Samples in which anything is looked for."""

OWN = {"short", "gaps", "outliers", "heavy tails", "stuck", "clipped", "too little left", "too short", "constant"}
"""Findings of a block that are not those of the record, or are found in every part."""

NONE = np.empty(0, np.int64)


class Inspection:
    """Looks at the samples of a channel part by part.

    Parameters
    ----------
    head : Record
        The first samples.
    size : int
        Number of samples of the whole.
    choice : {"mark", "keep"}, optional
        What is done with outliers; those that are kept are not looked for.
    """

    def __init__(self, head: Record, size: int, choice: str | None) -> None:
        kind = "increment" if head.integrated else head.kind
        self.like = replace(head, values=np.zeros(2), kind=kind, start=None, history=())
        self.size, self.choice = size, choice
        self.seen: dict[str, tuple[Finding, int, int]] = {}
        self.parts = self.blocks = self.count = self.lost = self.next = 0
        self.found = self.heavy = 0
        self.limit = self.largest = 0.0
        self.first = self.last = 0
        self.constant: Finding | None = None

    def look(self, steps: FloatArray, place: int) -> IntArray:
        """Look at a part that begins at a place of the whole; the indices of its outliers."""
        from allanite.kernels.passing import looked

        left, low, high, ends, run = looked(steps)
        self.lost += steps.size - left
        self.parts += 1
        if left < FEWEST:
            return NONE
        self._change(float(low), float(high))
        view = self._view(steps, place)
        # shorter runs, and fewer equal extremes, are never reported
        self._keep(stuck(view) if run >= RUN else None, 0)
        self._keep(clipped(view) if ends >= RUN and low < high else None, 0)
        if place >= self.next and steps.size >= min(BLOCK, self.size // 2):
            self._block(steps[:BLOCK], place)
        return NONE if self.choice == "keep" or low == high else self._outliers(view, place)

    def quality(self, rate: float, size: int) -> Quality:
        """All findings, at the sampling rate and length of the whole."""
        if self.constant is not None or not self.count:
            why = say("no part has {count} samples that are finite", count=FEWEST)
            return Quality((self.constant or Finding("not finite", why, fatal=True),))
        found = [*self._gaps(size), *self._outlying(rate), *(self._words(*one) for one in self.seen.values())]
        return Quality(tuple(found))

    @property
    def history(self) -> tuple[str, ...]:
        """History entry of marking the outliers."""
        if self.choice != "mark" or not self.found:
            return ()
        return (say("{outliers}: marked as missing", outliers=self._all().words(self.like)),)

    def _view(self, steps: FloatArray, place: int) -> View:
        return View(replace(self.like, values=steps, cut=place / self.like.rate))

    def _change(self, low: float, high: float) -> None:
        """Note that the signal is constant so far."""
        self.count += 1
        what = say("the signal never changes (always {value:.10g})", value=low)
        same = self.count == 1 or (self.constant is not None and self.constant.what == what)
        remedy = say("check that the sensor is connected and this is its column")
        self.constant = Finding("constant", what, remedy=remedy, fatal=True) if low == high and same else None

    def _block(self, steps: FloatArray, place: int) -> None:
        """Inspect a block as if it were the record."""
        self.next = place + max(BLOCK, self.size // BLOCKS)
        self.blocks += 1
        for one in inspect(self._view(steps, place).record).findings:
            if one.name not in OWN:
                self._keep(replace(one, fatal=False), 1)

    def _keep(self, one: Finding | None, block: int) -> None:
        if one is not None:
            first, count, _ = self.seen.get(one.name, (one, 0, block))
            self.seen[one.name] = (first, count + 1, block)

    def _outliers(self, view: View, place: int) -> IntArray:
        found = outliers(view.record, self.size)
        self.limit = max(self.limit, found.limit)
        self.heavy += found.heavy
        if found.at.size:
            self.first = self.first if self.found else place + int(found.at[0])
            self.last = place + int(found.at[-1])
            self.found += found.at.size
            self.largest = max(self.largest, found.largest)
        return found.at

    def _all(self) -> Outliers:
        """The outliers of all parts; only the first one and their number are kept."""
        return Outliers(np.broadcast_to(np.int64(self.first), self.found), self.limit, self.largest)

    def _outlying(self, rate: float) -> list[Finding]:
        like = replace(self.like, rate=rate)
        heavy = outlying(like, Outliers(NONE, self.limit, heavy=self.heavy), self.size)
        if self.choice == "mark" or not self.found:
            return [heavy] if heavy else []
        found = outlying(like, self._all(), self.size)
        place = (self.first / rate, (self.last + 1) / rate)
        return [one for one in (heavy, found and replace(found, place=place)) if one]

    def _gaps(self, size: int) -> list[Finding]:
        if not self.lost:
            return []
        what = say("{lost} of {size} samples are missing ({share})", lost=self.lost, size=size,
                   share=percent(self.lost / size))  # fmt: skip
        return [Finding("gaps", what, say("gaps are not filled: windows with missing samples are omitted"))]

    def _words(self, one: Finding, count: int, block: int) -> Finding:
        """A finding, and in how many parts or blocks it was made."""
        many = self.blocks if block else self.parts
        if many == 1:
            return one
        where = (
            say("in {count} of {many} blocks of {size} samples that were inspected, first", count=count, many=many,
                size=BLOCK)
            if block
            else say("in {count} of {many} parts of the record, first", count=count, many=many)
        )  # fmt: skip
        return replace(one, what=join(": ", (where, one.what)), place=None)
