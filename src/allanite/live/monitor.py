"""Monitor: one channel of a live stream, looked at second by second."""

import math
from collections import deque

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.finding import Finding
from allanite.core.record import Record
from allanite.phrases.phrase import say, say_count
from allanite.phrases.wording import percent
from allanite.prepare.readings import clipped, stuck
from allanite.prepare.stillness import AT_REST, MOVING, busy
from allanite.prepare.view import View
from allanite.stream.accumulator import Accumulator

from .defects import BEFORE, Steps, spikes

BLOCKS = 64
"""Blocks of a second that are remembered: what a new one is compared with."""

FEWEST = BEFORE
"""Blocks that must have come before motion can be told."""

TOGETHER = 4
"""Blocks at the beginning that are judged together: there is nothing else to compare them with."""

STEP = (
    say("a step makes the slow terms (B, K, R) too large"),
    say("analyze what was recorded before it and after it separately"),
)
"""What follows from a step, and what can be done."""


class Monitor:
    """Accumulates a channel without the blocks in which it moves and without outliers, and remembers what was found.

    A block is a second, at least 32 samples. It moves if its RMS about the median of the last still blocks is more than
    20 times that of the quietest tenth of them, as `prepare` has it for a record. An outlier is replaced by the median
    of its block: without it all windows that hold it would be lost. Points of an angle (`points`) are differenced.
    """

    def __init__(self, stream: Accumulator, *, points: bool = False) -> None:
        self.stream = stream
        self.last: float | None = math.nan if points else None
        self.begun = False
        self.span = max(32, round(stream.like.rate))
        self.waiting: list[FloatArray] = []
        self.recent: deque[FloatArray] = deque(maxlen=BLOCKS)
        self.moved: list[list[int]] = []
        self.seen: dict[str, Finding] = {}
        self.replaced: list[int] = []
        self.steps = Steps(BLOCKS)
        self.stepped: list[tuple[int, float]] = []

    @property
    def now(self) -> int:
        """Samples so far, missing ones and those that wait included."""
        return self.stream.stop + sum(part.size for part in self.waiting)

    def push(self, values: FloatArray) -> list[Finding]:
        """Add samples; what was found in the blocks that they complete, each finding once."""
        self.waiting.append(self._differenced(values))
        # the first blocks are judged together
        least = self.span if self.recent else TOGETHER * self.span
        return self._blocks() if sum(part.size for part in self.waiting) >= least else []

    def gap(self, samples: int) -> list[Finding]:
        """Go on after missing samples; what was found before."""
        found = self.finish()
        self.stream.skip(samples)
        if self.last is not None:
            self.last = math.nan
        return found

    def finish(self) -> list[Finding]:
        """Add what waits for the rest of its block; what was found."""
        found = self._blocks() if self.waiting else []
        for part in self.waiting:
            self.stream.push(part)
        self.waiting = []
        return found

    def _differenced(self, values: FloatArray) -> FloatArray:
        """Samples; of an angle its steps, of which the first of all is none."""
        if self.last is None or not values.size:
            return values
        steps = np.diff(values, prepend=self.last)
        first, self.begun, self.last = not self.begun, True, float(values[-1])
        return steps[1:] if first else steps

    def _blocks(self) -> list[Finding]:
        """Judge and add the blocks that are complete."""
        whole = np.concatenate(self.waiting)
        used = whole.size - whole.size % self.span
        self.waiting = [whole[used:]]
        blocks = whole[:used].reshape(-1, self.span)
        off = spikes(blocks, self.recent, self._record)
        return [one for block, bad in zip(blocks, off, strict=True) for one in self._block(block, bad)]

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
        if self.replaced:
            first, last = (at / stream.like.rate for at in (self.replaced[0], self.replaced[-1] + 1))
            what = say_count(
                len(self.replaced),
                "{count} outlier, at {first:.6g} s, is replaced by the median of its block",
                "{count} outliers, the first at {first:.6g} s, are replaced by the medians of their blocks",
                first=first,
            )
            found.append(Finding("outliers", what, place=(first, last)))
        if self.stepped:
            first, last = (at / stream.like.rate for at in (self.stepped[0][0], self.stepped[-1][0] + self.span))
            count = say_count(len(self.stepped), "{count} place", "{count} places")
            what = say("the mean jumps in {places}, the first at {first:.4g} s, by {size:.3g} {unit}", places=count,
                       first=first, size=self.stepped[0][1], unit=stream.like.unit)  # fmt: skip
            found.append(Finding("step", what, *STEP, place=(first, last)))
        return (*found, *self.seen.values())

    def _block(self, block: FloatArray, bad: BoolArray) -> list[Finding]:
        place, found = self.stream.stop, list[Finding]()
        if bad.any():
            if not self.replaced:
                what = say("outlier at {time:.6g} s; it is replaced, and so are further ones",
                           time=(place + int(bad.argmax())) / self.stream.like.rate)  # fmt: skip
                found.append(Finding("outliers", what))
            self.replaced += (place + np.flatnonzero(bad)).tolist()
            block = np.where(bad, np.median(block), block)
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
            found += self._step(place, float(block.mean()))
        return found + self._single(place)

    def _step(self, place: int, mean: float) -> list[Finding]:
        step = self.steps.push(place, mean)
        if step is None:
            return []
        self.stepped.append(step)
        what = say("the mean jumps at {time:.4g} s, by {size:.3g} {unit}", time=step[0] / self.stream.like.rate,
                   size=step[1], unit=self.stream.like.unit)  # fmt: skip
        return [Finding("step", what, *STEP)]

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
