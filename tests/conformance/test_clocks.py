"""Faults planted in stamps are named, and clean stamps are let through."""

import numpy as np
import pytest
from tests import examples
from tests.rows import paired, rows

from allanite.core.errors import AllaniteError
from allanite.readers.columns.column import FileColumn
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

SIZE = 20_000
CLOCKS = {  # rate, resolution of the stamps, s
    "100 Hz in us": (100.0, 1e-6), "100 Hz in ms": (100.0, 1e-3), "400 Hz in ms": (400.0, 1e-3),
    "96.07 Hz in us": (96.07, 1e-6), "1 kHz in 0.1 ms": (1000.0, 1e-4),
}  # fmt: skip


def clean(clock, rng):
    """Stamps with a jitter of 1 %, rounded, and readings."""
    rate, resolution = CLOCKS[clock]
    stamps = (np.arange(SIZE) + 0.01 * rng.standard_normal(SIZE)) / rate + rng.uniform(0, 1000)
    return np.rint(stamps / resolution).astype(np.int64), rng.standard_normal(SIZE)


def read(clock, stamps, values, **options):
    scaled = stamps * round(CLOCKS[clock][1] / 1e-6)  # of all resolutions microseconds are whole
    columns = (FileColumn(scaled, 1, "time", "us"), FileColumn(values, 2, "gx", "deg/s"))
    return FileTable(columns).recording(Options(**options))


def interval(stamps):
    return (stamps[-1] - stamps[0]) / (SIZE - 1)


def lost(stamps, values, rng):
    gone = rng.choice(np.arange(10, SIZE - 10), 30, replace=False)
    return np.delete(stamps, gone), np.delete(values, gone)


def outage(stamps, values, rng):
    start = rng.integers(100, SIZE - 3000)
    return np.delete(stamps, np.s_[start : start + 2000]), np.delete(values, np.s_[start : start + 2000])


def half_lost(stamps, values, rng):
    kept = np.sort(rng.choice(SIZE, SIZE // 2, replace=False))
    return stamps[kept], values[kept]


def jitter(stamps, values, rng):
    return np.sort(stamps + np.rint(rng.uniform(-0.45, 0.45, SIZE) * interval(stamps)).astype(int)), values


def bursts(stamps, values, rng):
    step = interval(stamps)
    last = stamps.reshape(-1, 10)[:, -1:]  # ten at a time arrive with the last, a tenth of a step apart
    late = np.rint(rng.uniform(0, 2, last.shape) * step).astype(int)
    return (last + late + np.rint(np.arange(10) * step / 10).astype(int)).ravel(), values


def whole_seconds(stamps, values, rng, second):
    return stamps // second * second, values


def repeated_rows(stamps, values, rng):
    again = np.arange(0, SIZE, 10)
    return np.insert(stamps, again, stamps[again]), np.insert(values, again, values[again])


def repeated_stamps(stamps, values, rng):
    again = rng.choice(np.arange(10, SIZE - 10), 50, replace=False)
    stamps[again] = stamps[again - 1]
    return stamps, values


def swapped_rows(stamps, values, rng):
    for k in rng.choice(np.arange(10, SIZE - 10, 5), 20, replace=False):
        stamps[[k, k + 1]], values[[k, k + 1]] = stamps[[k + 1, k]], values[[k + 1, k]]
    return stamps, values


def damaged(stamps, values, rng):
    at, step = rng.choice(np.arange(2, SIZE - 2, 7), 5, replace=False), interval(stamps)
    stamps[at] += np.rint(rng.choice([-1, 1], 5) * 10 ** rng.uniform(1, 7, 5) * step).astype(int)
    return stamps, values


def set_back(stamps, values, rng):
    at = rng.integers(5000, SIZE - 5000)
    stamps[at:] -= (stamps[2000] - stamps[0]) + 3
    return stamps, values


def drift(stamps, values, rng):
    k, slope = np.arange(SIZE), interval(stamps) * rng.uniform(1e-3, 2e-3)
    return stamps + np.rint(slope * k * (SIZE - k) / SIZE / 2).astype(int), values


FAULTS = {
    "lost": ("missing samples", lost), "outage": ("missing samples", outage),
    "half lost": ("missing samples", half_lost), "jitter": ("jitter", jitter),
    "bursts": ("bursty time stamps", bursts), "whole seconds": ("coarse time stamps", whole_seconds),
    "repeated rows": ("duplicate time stamps", repeated_rows), "swapped rows": ("reversed time stamps", swapped_rows),
    "repeated stamps": ("duplicate time stamps", repeated_stamps), "damaged": ("damaged time stamps", damaged),
    "set back": ("reversed time stamps", set_back), "drift": ("clock drift", drift),
    "constant": ("constant time stamps", lambda stamps, values, rng: (np.full(SIZE, stamps[0]), values)),
}  # fmt: skip
RATES = {"bursts": 2e-3, "drift": 2e-3, "jitter": 1e-4, "whole seconds": 1e-4}
"""How closely the rate is known, where a stamp may be off by an interval or more."""

ALONG = {("400 Hz in ms", "jitter"): ("duplicate time stamps",)}
"""What a fault brings along: jitter of more than an interval in stamps that are rounded to a part of it."""

NO_RATE = ("set back", "constant")
"""Faults after which the stamps give no rate: it is asked for, and the rows are then taken as evenly spaced."""


def planted(clock, fault, seed):
    rng = np.random.default_rng(seed)
    more = (round(1 / CLOCKS[clock][1]),) if fault == "whole seconds" else ()
    return FAULTS[fault][1](*clean(clock, rng), rng, *more)


@pytest.mark.ensemble
@rows("fault, clock", paired(list(FAULTS), list(CLOCKS)))
def test_a_fault_is_named_and_the_rate_is_right(clock, fault):
    """In at least 9 of 10 records."""
    named, rates, records, options = 0, [], examples(10), {}
    if fault in NO_RATE:
        with pytest.raises(AllaniteError):
            read(clock, *planted(clock, fault, 1))
        options = {"rate": CLOCKS[clock][0]}
    for seed in range(1, 1 + records):
        recording = read(clock, *planted(clock, fault, seed), **options)
        names = [finding.name for finding in recording.findings]
        named += FAULTS[fault][0] in names
        assert set(names) <= {FAULTS[fault][0], *ALONG.get((clock, fault), ())}, (seed, recording.findings)
        rates.append(recording["gx"].rate)
    assert named >= 0.9 * records
    np.testing.assert_allclose(rates, CLOCKS[clock][0], rtol=RATES.get(fault, 2e-5))


@pytest.mark.ensemble
@rows("clock", list(CLOCKS))
def test_clean_stamps_are_let_through(clock):
    """At most 2 % of findings are false: 0 or 1 in 60 records."""
    found = [read(clock, *clean(clock, np.random.default_rng(seed))).findings for seed in range(1, 1 + examples(60))]
    assert sum(bool(findings) for findings in found) <= 1, [findings for findings in found if findings]


@pytest.mark.ensemble
@rows("fault, clock", paired(["lost", "outage", "half lost"], list(CLOCKS)))
def test_what_was_lost_is_a_gap_in_its_place(clock, fault):
    for seed in range(1, 1 + examples(5)):
        whole = clean(clock, np.random.default_rng(seed))[1]
        record = read(clock, *planted(clock, fault, seed))["gx"]
        kept = ~np.isnan(record.values)
        # the half that was kept may begin or end a few samples later or earlier
        offset = int(np.argmax(whole == record.values[0]))
        np.testing.assert_array_equal(record.values[kept], whole[offset : offset + record.size][kept])
        assert any("marked as gaps" in entry for entry in record.history)


@rows("fault, entry", [("repeated rows", "repeated rows removed"), ("swapped rows", "rows sorted by time stamp")])
def test_rows_are_put_in_order_and_that_is_said(fault, entry):
    for seed in range(1, 6):
        record = read("100 Hz in us", *planted("100 Hz in us", fault, seed))["gx"]
        np.testing.assert_array_equal(record.values, clean("100 Hz in us", np.random.default_rng(seed))[1])
        assert record.history == (entry,)
