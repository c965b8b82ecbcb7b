"""Monitor: one channel of a live stream, looked at second by second."""

from collections import deque

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding
from allanite.core.language import say, say_count
from allanite.core.record import Record
from allanite.core.wording import percent
from allanite.prepare.readings import clipped, stuck
from allanite.prepare.stillness import AT_REST, MOVING, busy
from allanite.prepare.view import View
from allanite.stream.accumulator import Accumulator

BLOCKS = 64
"""Blocks of a second that are remembered: what a new one is compared with."""

FEWEST = 16
"""Blocks that must have come before motion can be told."""


class Monitor:
    """Accumulates a channel without the blocks in which it moves, and remembers what was found.

    A block is a second, at least 32 samples. It moves if its RMS about the median of the last still blocks is more than
    20 times that of the quietest tenth of them, as `prepare` has it for a record.
    """

    def __init__(self, stream: Accumulator) -> None:
        self.stream = stream
        self.span = max(32, round(stream.like.rate))
        self.waiting: list[FloatArray] = []
        self.recent: deque[FloatArray] = deque(maxlen=BLOCKS)
        self.moved: list[list[int]] = []
        self.seen: dict[str, Finding] = {}

    @property
    def now(self) -> int:
        """Samples so far, missing ones and those that wait included."""
        return self.stream.stop + sum(part.size for part in self.waiting)

    def push(self, values: FloatArray) -> list[Finding]:
        """Add samples; what was found in the blocks that they complete, each finding once."""
        self.waiting.append(values)
        if sum(part.size for part in self.waiting) < self.span:
            return []
        whole = np.concatenate(self.waiting)
        used = whole.size - whole.size % self.span
        self.waiting = [whole[used:]]
        return [one for block in whole[:used].reshape(-1, self.span) for one in self._block(block)]

    def gap(self, samples: int) -> None:
        """Go on after missing samples."""
        self.finish()
        self.stream.skip(samples)

    def finish(self) -> None:
        """Add what waits for the rest of its block."""
        for part in self.waiting:
            self.stream.push(part)
        self.waiting = []

    def findings(self) -> tuple[Finding, ...]:
        """What was found so far."""
        stream, found = self.stream, []
        if self.moved:
            first, last = (at / stream.like.rate for at in (self.moved[0][0], self.moved[-1][1]))
            count = say_count(len(self.moved), "{count} place", "{count} places")
            what = say(
                "moved in {places}, from {first:.4g} s to {last:.4g} s; these samples are left out",
                places=count,
                first=first,
                last=last,
            )
            found.append(Finding("moving", what, AT_REST, place=(first, last)))
        lost, size = stream.missing - sum(last - first for first, last in self.moved), stream.stop - stream.start
        if lost > 0:
            share = percent(lost / size)
            what = say("{lost} of {size} samples are missing ({share})", lost=lost, size=size, share=share)
            rule = say("gaps are not filled: windows with missing samples are omitted")
            found.append(Finding("gaps", what, rule))
        return (*found, *self.seen.values())

    def _block(self, block: FloatArray) -> list[Finding]:
        place = self.stream.stop
        if self._moves(block):
            self.stream.skip(block.size)
            if self.moved and self.moved[-1][1] == place:
                self.moved[-1][1] += block.size
                return []
            self.moved.append([place, place + block.size])
            what = say(
                "the sensor moves at {time:.4g} s (RMS over {times:g} times that at rest)",
                time=place / self.stream.like.rate, times=MOVING,
            )  # fmt: skip
            return [Finding("moving", what, AT_REST)]
        self.stream.push(block)
        if np.isfinite(block).all():
            self.recent.append(block)
        return self._single(place)

    def _moves(self, block: FloatArray) -> bool:
        if len(self.recent) < FEWEST or not np.isfinite(block).all():
            return False
        centre = float(np.median([part.mean() for part in self.recent]))
        still = min(float(part.std()) for part in self.recent)
        # of most blocks this is enough to say that they do not
        if np.sqrt(np.square(block - centre).mean()) <= MOVING * still:
            return False
        return bool(busy(View(self._record([*self.recent, block])))[-1])

    def _single(self, place: int) -> list[Finding]:
        """Defects of single samples in the last blocks, which are looked for whenever all of them are new."""
        if len(self.recent) < BLOCKS or (place // self.span) % BLOCKS:
            return []
        view = View(self._record(self.recent, cut=(place + self.span) / self.stream.like.rate))
        found = [one for one in (stuck(view), clipped(view)) if one is not None and one.name not in self.seen]
        self.seen |= {one.name: one for one in found}
        return found

    def _record(self, blocks: "deque[FloatArray] | list[FloatArray]", cut: float = 0.0) -> Record:
        like, values = self.stream.like, np.concatenate(blocks)
        kind = "increment" if like.kind == "count" else like.kind
        return Record(values, like.rate, like.unit, kind, like.scale, like.name,
                      cut=max(0.0, cut - values.size / like.rate))  # fmt: skip
