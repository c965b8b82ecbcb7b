"""Sums of a stream: those of the record at the same windows, however it is cut and whoever sums the parts."""

from copy import deepcopy
from itertools import pairwise
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests import examples, thinned
from tests.rows import paired, refused, rows

import allanite as al
from allanite.stream.accumulator import streamable
from allanite.stream.coefficients import grid

RATE = 10.0
N = 3000


def literal(values, statistic, q, level):
    """Sum of the squared differences over m = q 2^level at every 2^level-th point, and how many; complete ones only."""
    order, ends = 2 if statistic in ("oadev", "haar") else 3, 0
    there = np.isfinite(values)
    rest = np.where(there, values - np.nanmean(values), 0.0)
    x, lost = np.concatenate(([0.0], np.cumsum(rest))), np.concatenate(([0], np.cumsum(~there)))
    if statistic in ("mdev", "tdev"):
        # the window from point k of the sum takes x from k to k + 3 m - 1, and no sample before the k-th
        x, lost = np.concatenate(([0.0], np.cumsum(x))), np.concatenate((lost, lost[-1:]))
        ends = -1
    m, step = q << level, 1 << level
    at = np.arange(0, x.size - order * m, step)
    total = sum((-1) ** k * comb(order, k) * x[at + k * m] for k in range(order + 1))
    whole = lost[at + order * m + ends] == lost[at]
    return float((total[whole] ** 2).sum()), int(whole.sum())


def noise(seed=1, bias=0.0, ramp=0.0, n=N):
    rng = np.random.default_rng(seed)
    return rng.normal(size=n) + 0.02 * np.cumsum(rng.normal(size=n)) + bias + ramp * np.arange(n)


def stream_of(values, statistic="oadev", start=0, cuts=()):
    stream = al.Accumulator(RATE, "deg/h", statistic=statistic, start=start)
    for part in np.split(values, cuts):
        stream.push(part)
    return stream


def agree(stream, statistic, values):
    """Check sums and counts at each factor and level of the grid that fits the record; how many have windows."""
    state, used = stream.sums.state, 0
    for i, (q, level) in enumerate(zip(*(part.tolist() for part in grid()), strict=True)):
        if q << level <= values.size:
            total, count = literal(values, statistic, q, level)
            assert (state.counts[i], state.sums[i]) == (count, pytest.approx(total, rel=1e-9, abs=0)), i
            used += count > 0
    return used


def same(one, other, tolerance=1e-9):
    state, known, cells, kept = one.sums.state, other.sums.state, one.sums.cells, other.sums.cells
    for mine, theirs in ((state.counts, known.counts), (state.segments, known.segments), (cells.count, kept.count)):
        np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_allclose(state.sums, known.sums, rtol=tolerance)
    np.testing.assert_allclose(state.powers, known.powers, rtol=tolerance)
    np.testing.assert_allclose(cells.total, kept.total, rtol=tolerance, atol=1e-6)
    assert (one.size, one.start, one.stop) == (other.size, other.start, other.stop)


places = st.lists(st.integers(1, N - 1), max_size=8).map(sorted)


@pytest.mark.parametrize("statistic", streamable())
@settings(max_examples=examples(12), deadline=None)
@given(cuts=places, bias=st.sampled_from([0.0, 1e3, -1e6]), ramp=st.sampled_from([0.0, 1e-2]))
def test_sums_are_those_of_the_record_at_any_chunking(statistic, cuts, bias, ramp):
    values = noise(bias=bias, ramp=ramp)
    assert agree(stream_of(values, statistic, cuts=cuts), statistic, values) > 50


@pytest.mark.parametrize("statistic", streamable())
@settings(max_examples=examples(12), deadline=None)
@given(cuts=places, data=st.data())
def test_parts_merged_in_any_order_are_one_stream(statistic, cuts, data):
    values = noise(bias=50.0)
    parts = [stream_of(values[a:b], statistic, a) for a, b in pairwise([0, *cuts, N])]
    while len(parts) > 1:
        i = data.draw(st.integers(0, len(parts) - 2))
        parts[i].merge(parts.pop(i + 1))
    same(parts[0], stream_of(values, statistic))
    assert agree(parts[0], statistic, values) > 50


holes = st.lists(st.tuples(st.integers(0, N - 1), st.integers(1, 40)), max_size=5)


def with_holes(holes):
    values = noise()
    for at, length in holes:
        values[at : at + length] = np.nan
    return values


@pytest.mark.parametrize("statistic", streamable())
@settings(max_examples=examples(20), deadline=None)
@given(cuts=places, holes=holes)
def test_windows_with_missing_samples_are_omitted(statistic, cuts, holes):
    values = with_holes(holes)
    stream = stream_of(values, statistic, cuts=cuts)
    agree(stream, statistic, values)
    assert stream.missing == np.isnan(values).sum()


HOLES = [[], [(0, 7)], [(3, 1)], [(50, 1), (52, 1), (700, 64)], [(2990, 10)]]


@rows("statistic, holes", paired(streamable(), HOLES))
def test_curve_is_that_of_the_record_without_incomplete_windows(statistic, holes):
    values = with_holes(holes)
    batch = al.deviation(al.Record(values, RATE, "deg/h"), statistic, m=range(1, 16), noise=None, gaps="complete")
    for cuts in ((), (1, 51, 699)):
        curve = stream_of(values, statistic, cuts=cuts).curve()
        np.testing.assert_array_equal(curve.count[:15], batch.count)
        np.testing.assert_allclose(curve.deviation[:15], batch.deviation, rtol=1e-9)
        np.testing.assert_allclose(curve.tau[:15], batch.tau)
        assert curve.unit == batch.unit


@rows("statistic, at", paired(streamable(), thinned([0, 1000], 1)))
def test_merge_over_a_gap_is_a_stream_with_missing_samples(statistic, at):
    values = with_holes([(at, 99)])
    first, gap, last = (stream_of(values[a:b], statistic, a) for a, b in ((0, at), (at, at + 99), (at + 99, N)))
    first.merge(gap)
    first.merge(last)
    same(first, stream_of(values, statistic))


def test_merge_does_not_change_the_part_that_is_added():
    values = noise()
    first, second = stream_of(values[:777]), stream_of(values[777:], start=777)
    before = deepcopy(second)
    first.merge(second)
    same(second, before, 0)


@rows("kind, unit, scale", [("increment", "arcsec", None), ("count", "arcsec", 0.1), ("angle", "arcsec", None)])
def test_every_kind_of_samples(kind, unit, scale):
    steps = np.rint(10 * noise(n=5000))
    values = np.concatenate(([5.0], 5.0 + np.cumsum(steps))) if kind == "angle" else steps
    stream = al.Accumulator(RATE, unit, kind, scale=scale)
    for part in np.array_split(values, 7):
        stream.push(part)
    batch = al.deviation(al.Record(values, RATE, unit, kind, scale), m=range(1, 16), noise=None)
    np.testing.assert_allclose(stream.curve().deviation[:15], batch.deviation, rtol=1e-9)


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
def test_intervals_at_a_stride_hold_the_truth():
    model = al.N(1, "deg/sqrt(h)") + al.K(30, "deg/h/sqrt(h)")
    inside = []
    for seed in range(60):
        record = al.simulate(model, 4000, 1.0, rng=np.random.default_rng(seed))
        stream = al.Accumulator(1.0, record.unit)
        stream.push(record.values)
        curve = stream.curve(model)
        low, high = curve.interval(0.9)
        truth = np.sqrt(al.expected(model, "oadev", curve.tau, rate=1.0))
        inside.append((low < truth) & (truth < high))
    share = np.mean(inside, axis=0)
    assert np.all(share > 0.75)
    assert 0.87 < share.mean() < 0.93


def test_state_is_small_and_does_not_grow():
    stream = stream_of(noise(n=200_000))
    before = stream.nbytes
    stream.push(noise(n=500_000))
    assert stream.nbytes == before < 32_000


def test_long_streams_with_a_bias_and_a_ramp_keep_their_digits():
    white = np.random.default_rng(3).normal(size=4_000_000)
    biased = white + 1e6 + 1e-3 * np.arange(white.size)
    curve = stream_of(biased, cuts=range(500_000, white.size, 500_000)).curve()
    exact = al.deviation(al.Record(biased, RATE, "deg/h"), m=[1, 7, 15], noise=None).deviation
    np.testing.assert_allclose(curve.deviation[[0, 6, 14]], exact, rtol=1e-9)


def test_refusals_say_what_to_do():
    made, stream = al.Accumulator, stream_of(noise())
    refused(al.UsageError, r"no 'theo1': choose one of oadev, mdev", lambda: made(1.0, "deg/h", statistic="theo1"))
    refused(al.UsageError, "start, the place of the first sample", lambda: made(1.0, "deg/h", start=-1))
    refused(al.UsageError, "does not fit kind", lambda: made(1.0, "arcsec", "rate"))
    refused(al.DataError, "too few for oadev", lambda: made(1.0, "deg/h").curve())
    refused(al.DataError, "an Accumulator of its own", lambda: stream.push(np.zeros((3, 2))))
    refused(al.DataError, "row of real numbers", lambda: stream.push(["a"]))
    refused(al.UsageError, r"sample 2999", lambda: stream.merge(stream_of(noise(), start=2999)))
    refused(al.UsageError, "parts of one stream", lambda: stream.merge(stream_of(noise(), "ohdev", start=3000)))
    refused(al.UsageError, "missing samples must be between 0 and", lambda: stream.skip(-1))
    refused(al.UsageError, "a noise model must be a Model", lambda: stream.curve("auto").interval())
