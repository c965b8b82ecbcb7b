"""What `check` says of claimed filters and rates: false alarms at the true cut-off, and what is wrong.

White noise at 200 Hz behind a filter, or none, is held against its own cut-off, against others and, without a filter,
against filters that are not there. The filters of the first table are those of rows of `FILTERS`; those of the second
are in no row, and their samples are rounded to a fourth of their standard deviation.
"""

from table import begin, section

import math
import sys
from collections.abc import Callable

import numpy as np
from scipy.signal import bessel, butter, lfilter

import allanite as al
from allanite.claims.checking import setting_rows
from allanite.claims.claim import CUTOFF, ClaimedSetting

RATE, SIZE, START = 200.0, 20_000, 1000
FACTORS = (1.0, 0.8, 1.25, 0.5, 2.0)
Filter = tuple[np.ndarray, np.ndarray]


def poles(order: int, cutoff: float) -> Filter:
    """RC filters one behind the other, their cut-off in cycles a sample."""
    p = math.exp(-2 * math.pi * cutoff)
    a = np.ones(1)
    for _ in range(order):
        a = np.convolve(a, [1.0, -p])
    return np.array([(1 - p) ** order]), a


def average(length: int) -> Filter:
    """A moving average."""
    return np.full(length, 1 / length), np.ones(1)


KNOWN: dict[str, tuple[Filter, float]] = {
    "RC": (poles(1, 0.15), 30.0),
    "Butterworth of order 2": (butter(2, 42.0, fs=RATE), 42.0),
    "moving average of 4 samples": (average(4), 0.443 / 4 * RATE),
}
OTHERS: dict[str, tuple[Filter, float]] = {
    "RC twice": (poles(2, 0.12), 16.0),
    "RC three times": (poles(3, 0.12), 12.6),
    "Bessel of order 2": (bessel(2, 42.0, norm="mag", fs=RATE), 42.0),
    "Butterworth of order 4": (butter(4, 42.0, fs=RATE), 42.0),
}
NONE: Filter = (np.ones(1), np.ones(1))


def outcomes(of: tuple[Filter, float], seed: tuple[int, ...], *, rounded: bool = False) -> list[str]:
    """What is said of the cut-off of one record, and of others."""
    return said_of(of[0], [factor * of[1] for factor in FACTORS], seed, rounded=rounded)


def said_of(through: Filter, claimed: list[float], seed: tuple[int, ...], *, rounded: bool = False) -> list[str]:
    """What is said of each claimed cut-off of one record."""
    x = 1e-3 * np.random.default_rng(seed).standard_normal(SIZE + START)
    y = lfilter(*through, x)[START:]
    step = y.std() / 4
    study = al.analyze(al.Record(step * np.round(y / step) if rounded else y, RATE, "rad/s", name="gx"))
    return [next(setting_rows(study, [ClaimedSetting(CUTOFF, c)], 0.05, 0.02)).outcome for c in claimed]


def line(name: str, records: int, one: Callable[[int], list[str]]) -> list[str]:
    """How often each claim is contradicted, and how often it is not decided on."""
    said = [one(seed) for seed in range(records)]
    columns = zip(*said, strict=True)
    cells = [f"{column.count('differs')} ({column.count('not shown')})" for column in columns]
    print(name, cells, file=sys.stderr, flush=True)
    return [name, str(records), *cells]


def main() -> None:
    """Run what is asked for."""
    run = begin(__doc__, records=40, others=10)
    rows = [
        line(name, run.asked.records, lambda seed, i=i, of=of: outcomes(of, (1, i, seed)))
        for i, (name, of) in enumerate(KNOWN.items())
    ]
    absent = [20.0, 42.0, 60.0, 80.0, 88.0]
    none = line("no filter", run.asked.records, lambda seed: said_of(NONE, absent, (2, seed)))
    others = [
        line(name, run.asked.others, lambda seed, i=i, of=of: outcomes(of, (3, i, seed), rounded=True))
        for i, (name, of) in enumerate(OTHERS.items())
    ]
    alarms, total = sum(int(row[2].split()[0]) for row in rows), run.asked.records * len(rows)
    headings = ("filter", "records", "true", "0.8 times", "1.25 times", "half", "twice")
    run.publish(
        "Check of claimed filters",
        (
            "seeds: (1, filter, record), (2, record) and (3, filter, record)",
            f"white noise, {SIZE} samples at {RATE:g} Hz; contradicted, and in brackets not decided",
            f"false alarms at the true cut-off: {alarms} of {total} records, nominal 5 %",
        ),
        section("Filters that are rows", headings, rows)
        + section("No filter", ("filter", "records", *(f"{c:g} Hz" for c in absent)), [none])
        + section("Filters of no row", headings, others),
    )


if __name__ == "__main__":
    main()
