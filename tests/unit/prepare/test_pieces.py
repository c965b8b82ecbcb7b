"""A record in pieces is prepared and inspected as a whole one, however it is cut."""

from itertools import pairwise
from unittest.mock import patch

import numpy as np
from hypothesis import given, settings, strategies as st
from tests import examples
from tests.rows import rows

import allanite as al
from allanite.core.record import Recording
from allanite.prepare import inspector
from allanite.prepare.inspector import Inspector
from allanite.prepare.quality import inspect
from allanite.prepare.transform import averaged, mark_motion
from allanite.prepare.window import excluded, trim

SIZE = 4000
BLOCK = 1024


def values_of(kind, seed=1):
    y = np.random.default_rng(seed).normal(size=SIZE)
    y[700] += 40.0
    if kind == "angle":
        return np.cumsum(y)
    return np.rint(20 * y).astype(np.int64) if kind == "count" else y


def record_of(kind, values=None, rate=10.0):
    unit = "arcsec" if kind in ("count", "angle", "increment") else "deg/h"
    return al.Record(values_of(kind) if values is None else values, rate, unit, kind, 0.1 if kind == "count" else None)


cuts = st.lists(st.integers(1, SIZE - 1), max_size=12, unique=True).map(sorted)


def cut_at(places, *columns):
    """Pieces of columns that end at these places."""
    ends = [0, *places, SIZE]
    return [(a, [column[a:b] for column in columns]) for a, b in pairwise(ends)]


def whole_of(found, size):
    """The samples of the first column of blocks, put together by their places."""
    whole = np.full(size, np.nan)
    for place, (values, *_) in found:
        whole[place : place + len(values)] = values
    return whole


@settings(max_examples=examples(40), deadline=None)
@given(cuts, st.integers(1, 1500), st.sampled_from([0, 1]))
def test_blocks_are_the_same_for_any_cut(places, size, points):
    y, counts = values_of("rate"), values_of("count")
    known = list(inspector.blocks(cut_at([], y, counts), size, points))
    found = list(inspector.blocks(cut_at(places, y, counts), size, points))
    assert [place for place, _ in found] == [place for place, _ in known]
    for (_, mine), (_, whole) in zip(found, known, strict=True):
        for one, other in zip(mine, whole, strict=True):
            np.testing.assert_array_equal(one, other, strict=True)
    np.testing.assert_array_equal(whole_of(found, SIZE), y)


@settings(max_examples=examples(40), deadline=None)
@given(cuts, st.sampled_from(["rate", "increment", "angle", "count"]), st.integers(2, 300))
def test_means_are_those_of_the_whole(places, kind, m):
    record = record_of(kind)
    (whole,) = averaged(Recording((record,)), m / record.rate)
    found = inspector.averaged(cut_at(places, record.values), [kind], m, BLOCK)
    np.testing.assert_array_equal(whole_of(found, len(whole.values)), whole.values)


@settings(max_examples=examples(40), deadline=None)
@given(cuts, st.sampled_from(["rate", "angle"]), st.integers(0, 200), st.integers(210, 399))
def test_pieces_are_left_out_and_cut_as_of_the_whole(places, kind, start, end):
    record = record_of(kind)
    spans = ((20.0, 50.0), (100.0, 390.0))
    (whole,) = trim(excluded(Recording((record,)), spans), float(start), float(end))
    samples = [(round(a * record.rate), round(b * record.rate)) for a, b in spans]
    points = int(kind == "angle")
    left = inspector.excluded(cut_at(places, record.values), [kind], samples)
    found = inspector.window(left, 10 * start, 10 * end + points)
    np.testing.assert_array_equal(whole_of(found, len(whole.values)), whole.values)


def looked(record, size=BLOCK, places=(), choice=None):
    """The findings about the blocks of a record that came in pieces."""
    seen = Inspector(SIZE, choice)
    found = list(inspector.blocks(cut_at(places, record.values), size, int(record.kind == "angle")))
    with patch.object(inspector, "BLOCK", size):
        for place, (values,) in found:
            kind = "increment" if record.kind == "count" and values.dtype.kind == "f" else record.kind
            block = al.Record(values, record.rate, record.unit, kind, record.scale, cut=place / record.rate)
            seen.look(block, alone=len(found) == 1)
        return seen.quality(record.rate, record.size).findings


def defective(kind):
    """A record with a stuck run, a quantized stretch of motion, and outliers."""
    y = values_of("rate", 3)
    y[1500:1560] = y[1500]
    y[[100, 3000]] += 50.0
    y[2000:2600] += 300 * np.random.default_rng(2).normal(size=600)
    y[3300:3340] = np.nan
    return record_of(kind, np.cumsum(y) if kind == "angle" else y)


@settings(max_examples=examples(25), deadline=None)
@given(cuts, st.sampled_from(["rate", "angle"]), st.sampled_from([BLOCK, 1 << 20]), st.sampled_from([None, "mark"]))
def test_findings_are_the_same_for_any_cut(places, kind, size, choice):
    record = defective(kind)
    known = looked(record, size, [], choice)
    assert looked(record, size, places, choice) == known
    assert "moving" in {finding.name for finding in known}


@rows("kind", ["rate", "angle", "count", "increment"])
def test_one_block_is_inspected_as_a_record(kind):
    record = record_of(kind)
    found = looked(record, 1 << 20, [7, 2000])
    assert found == inspect(record).findings
    assert "outliers" in {finding.name for finding in found}


def test_blocks_are_compared_with_each_other():
    y = values_of("rate")
    y[2048:3072] *= 3.0
    (level,) = [finding for finding in looked(record_of("rate", y)) if finding.name == "level"]
    assert "highest from 204.8 s on" in level.what
    assert "level" not in {finding.name for finding in looked(record_of("rate"))}


@rows("value", [np.inf, 1e200])
def test_impossible_values_are_refused_wherever_they_are(value):
    y = values_of("rate")
    y[3000] = value
    (finding,) = looked(record_of("rate", y))
    assert (finding.name, finding.fatal) == ("range", True)


def test_samples_that_are_missing_make_no_blocks():
    y = values_of("rate")
    found = list(inspector.blocks([(0, [y[:100]]), (5000, [y[100:150]])], BLOCK))
    assert [place for place, _ in found] == [0, 4096]
    assert [len(columns[0]) for _, columns in found] == [BLOCK, 5050 - 4096]
    assert np.isnan(found[1][1][0][: 5000 - 4096]).all()


@rows("kind", ["rate", "angle"])
def test_motion_is_left_out_in_all_channels_of_the_body(kind):
    rng = np.random.default_rng(5)
    still, moved, warm = rng.normal(size=(3, 20_000))
    moved[5000:5100] += 2000.0
    if kind == "angle":
        still, moved = np.cumsum(still), np.cumsum(moved)
    x, t = record_of(kind, still), al.Record(warm, 10.0, "K", "value")
    left = mark_motion((x, record_of(kind, moved), t))
    gone = [np.flatnonzero(np.isnan(record.steps)) for record in left]
    assert gone[0].tolist() == gone[1].tolist()
    assert set(range(5000, 5100)) <= set(gone[0])
    assert gone[0].size < 200
    assert left[2] is t
    assert "left out" in left[0].history[-1]
    assert mark_motion((x,))[0] is x
