"""Channels of a log merged from several rates, which have a sample in every k-th row only."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from allanite.core.arrays import complete
from allanite.core.record import Record
from allanite.phrases.phrase import say

FILLED, FEWEST = 0.5, 32
"""Share of every k-th row that must have a sample, and samples: of fewer the distance may be chance."""


def stride(records: Sequence[Record]) -> tuple[int, int]:
    """First row with a sample, and the distance of such rows: 1 unless all channels have samples in every k-th only."""
    if any(complete(record.values) for record in records):
        return 0, 1
    there = np.flatnonzero(np.logical_or.reduce([np.isfinite(record.values) for record in records]))
    step = int(np.gcd.reduce(np.diff(there))) if there.size > 1 else 1
    filled = there.size >= FEWEST and there.size * step > FILLED * len(records[0].values)
    return (int(there[0]), step) if step > 1 and filled else (0, 1)


def thinned(records: Sequence[Record], first: int, step: int) -> tuple[Record, ...]:
    """Every `step`-th sample, at the rate of these."""
    what = say("only one row in {step} has samples: the others are left out", step=step)
    return tuple(
        replace(
            record, values=record.values[first::step], rate=record.rate / step,
            start=None if record.start is None else record.start + first / record.rate,
            history=(*record.history, what),
        )
        for record in records
    )  # fmt: skip


def note(records: Sequence[Record], step: int) -> str:
    """The note on their rate."""
    return say(
        "rate {rate:.7g} Hz, since only one row in {step} has samples of {names}; if others were lost rather than "
        "averaged, N is too large by up to sqrt({step})",
        rate=records[0].rate / step, step=step, names=", ".join(record.name for record in records),
    )  # fmt: skip
