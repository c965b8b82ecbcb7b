"""Coefficients of a stream: those of the record, as accurate as the bound, from every kind of stream."""

import pickle

import numpy as np
import pytest
from scipy.fft import dct
from tests import thinned
from tests.rows import refused, rows

import allanite as al
from allanite.planning.datasheets import sensor
from allanite.prepare.gaps import gaps_between
from allanite.stream.coefficients import Ladder
from allanite.stream.sums import basis, folded


def stream_of(record, parts=1):
    stream = al.Accumulator(record.rate, record.unit, record.kind, scale=record.scale, name=record.name)
    for part in np.array_split(record.values, parts):
        stream.push(part)
    return stream


@pytest.mark.slow("takes more than half a second")
@rows("name, rate, terms", thinned([("mems", 100.0, "NBK"), ("fog", 1.0, "QNBKR")], 1))
def test_as_accurate_as_the_bound(name, rate, terms):
    model, errors = sensor(name), []
    for seed in range(24):
        fit = stream_of(al.simulate(model, 2**18, rate, rng=np.random.default_rng(seed))).fit(terms, band="all")
        errors.append([abs((fit[s].value or 0.0) / model[s].value) - 1 for s in terms])
    bound = al.bound(model, 2**18, rate)
    rms = np.sqrt(np.mean(np.square(errors), axis=0)) / [bound[s] for s in terms]
    # 24 records know an rms to 14 %; benchmarks/streams.py has 200
    assert np.exp(np.log(rms).mean()) < 1.25
    assert rms.max() < 1.6


def test_coefficients_and_grade_are_near_those_of_the_record():
    record = al.simulate(sensor("mems"), 300_000, 100.0, rng=np.random.default_rng(1))
    fit, batch = stream_of(record, 40).fit(), al.identify(record)
    assert fit.validity == "explained"
    for estimate in fit:
        other = batch[estimate.symbol]
        # a term near its limit may be claimed by one alone
        assert estimate.claimed == other.claimed or "weak" in (estimate.status, other.status)
        if estimate.claimed:
            low, high = other.interval(0.95)
            assert low < estimate.value < high
    assert pickle.loads(pickle.dumps(fit)).model == fit.model


def test_parts_tell_what_the_whole_tells():
    record = al.simulate(sensor("fog"), 50_000, 1.0, rng=np.random.default_rng(2))
    first, second, third = (al.Accumulator(1.0, record.unit, record.kind, start=n) for n in (0, 13_001, 30_000))
    for part, values in zip((first, second, third), np.split(record.values, [13_001, 30_000]), strict=True):
        part.push(values)
    second.merge(third)
    first.merge(second)
    for one, other in zip(first.fit("QNBKR"), stream_of(record).fit("QNBKR"), strict=True):
        assert one.status == other.status
        assert one.interval() == pytest.approx(other.interval(), rel=1e-4)


def test_what_is_no_noise_is_not_explained():
    values = np.random.default_rng(3).normal(size=100_000) + np.sin(2 * np.pi * 0.07 * np.arange(100_000))
    assert stream_of(al.Record(values, 100.0, "deg/h")).fit(band="all").validity == "unexplained"


def test_a_gap_costs_no_more_than_it_is_long():
    record = al.simulate(sensor("mems"), 200_000, 100.0, rng=np.random.default_rng(5))
    values = np.where(np.arange(200_000) // 15_000 == 4, np.nan, record.values)
    fit = stream_of(record.with_values(values, "")).fit("NBK")
    assert fit["N"].value == pytest.approx(sensor("mems")["N"].value, rel=0.01)
    assert fit.validity == "explained"


def test_too_little_and_nothing_are_refused():
    stream = al.Accumulator(100.0, "deg/h", name="z")
    stream.push(np.zeros(150))
    refused(al.DataError, "150 samples are too few", stream.fit)
    stream.push(np.zeros(1500))
    refused(al.DataError, "'z' never changes", stream.fit)
    refused(al.UsageError, "unknown term", lambda: stream.fit("X"))


def test_the_variance_of_coefficients_under_angle_noise_is_that_of_its_matrix():
    """Its differences over cells, whose sums are divided by the root of the width."""
    n, width = 40, 8
    none = np.zeros(n - 1, np.int64)
    ladder = Ladder(n - 1, width, gaps_between(np.arange(n)), none, none, np.ones(n - 1))
    change = dct(np.diff(np.eye(n + 1), axis=0) / np.sqrt(width), axis=0, norm="ortho")
    wanted = np.sum(change**2, axis=1)[1:]
    np.testing.assert_allclose(ladder.row(al.terms.TERMS["Q"], ladder.cells, np.arange(1.0, n)), wanted, rtol=1e-10)


def test_the_basis_is_orthogonal_but_for_its_means_and_folding_is_the_same():
    rows, weights = basis(16), folded(16)
    np.testing.assert_allclose(rows @ rows.T, np.eye(14), atol=0.01)
    segment = np.random.default_rng(4).normal(size=32)
    a, b, c, d = np.split(segment * weights[0], 4)
    short = np.concatenate((-c[::-1] - d, a - b[::-1], [segment.sum()]))
    np.testing.assert_allclose(weights[1:, :17] @ short, rows @ segment, atol=1e-12)
