"""The dynamic form of every statistic against that of each window by itself."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests import examples
from tests.rows import refused, rows

import allanite as al


def record_of(y, **options):
    return al.Record(y, **({"rate": 10.0, "unit": "deg/h", "kind": "rate", "name": "z"} | options))


def noise(n, seed=1):
    return np.random.default_rng(seed).standard_normal(n)


def alone(record, start, samples, surface):
    extra = 1 if record.kind == "angle" else 0
    part = record.with_values(record.values[start : start + samples + extra], "")
    return al.deviation(part, surface.statistic, m=surface.m.tolist())


@pytest.mark.parametrize("name", list(al.statistics.STATISTICS))
@given(data=st.data())
@settings(max_examples=examples(15), deadline=None)
def test_every_window_equals_its_own_deviation(name, data):
    n = data.draw(st.integers(110, 300))
    samples, stride = data.draw(st.integers(100, n)), data.draw(st.integers(max(1, n // 20), n))
    kind = data.draw(st.sampled_from(["rate", "angle"]))
    y = np.cumsum(noise(n + 1, data.draw(st.integers(0, 999)))) + 100
    record = record_of(y[: n + (kind == "angle")], kind=kind, unit={"rate": "deg/h", "angle": "arcsec"}[kind])
    surface = al.dynamic(record, name, window=samples / 10, step=stride / 10)
    assert surface.time.size == (n - samples) // stride + 1
    for i, row in enumerate(surface.variance):
        curve = alone(record, i * stride, samples, surface)
        np.testing.assert_allclose(row, curve.variance, rtol=1e-10, atol=1e-24)
        np.testing.assert_array_equal(surface.count[i], curve.count)
        np.testing.assert_allclose(surface.time[i], (i * stride + samples / 2) / 10)
    np.testing.assert_allclose(surface.tau, curve.tau)


@rows("name", [name for name, row in al.statistics.STATISTICS.items() if row.sliding])
def test_long_records(name):
    record = record_of(noise(30_000) + 1e6)
    for samples, stride in ((5000, 700), (1000, 3000), (300, 1)):
        surface = al.dynamic(record, name, window=samples / 10, step=stride / 10, taus="log")
        for i in range(0, surface.time.size, max(1, surface.time.size // 7)):
            curve = alone(record, i * stride, samples, surface)
            np.testing.assert_allclose(surface.variance[i], curve.variance, rtol=1e-10)


def test_a_shock_leaves_nothing_behind():
    y = noise(20_000)
    calm = al.dynamic(record_of(y), window=50.0, step=5.0)
    y[9000] += 1e9
    shaken = al.dynamic(record_of(y), window=50.0, step=5.0)
    before, after = shaken.time + 25 < 900.0, shaken.time - 25 > 900.1
    assert after.sum() > 100
    # before the shock the angle is as it was; behind it, it has lost the digits that 1e9 takes
    np.testing.assert_allclose(shaken.variance[before], calm.variance[before], rtol=1e-12)
    np.testing.assert_allclose(shaken.variance[after], calm.variance[after], rtol=1e-5)


@rows("name", list(al.statistics.STATISTICS))
def test_windows_that_have_lost_samples(name):
    y = noise(3000)
    y[1000:1400] = np.nan
    surface = al.dynamic(record_of(y), name, window=30.0, step=10.0)
    start = surface.time - 15.0
    whole, lost = (start + 30 <= 100.0) | (start >= 140.0), (start >= 100.0) & (start + 30 <= 140.0)
    assert np.isfinite(surface.variance[whole]).all()
    assert np.array_equal(np.isfinite(surface.variance), surface.count > 0)
    assert lost.sum() == 2
    assert np.isnan(surface.variance[lost]).all()
    assert not surface.count[lost].any()
    refused(al.DataError, "no window", lambda: al.dynamic(record_of(np.full(500, np.nan)), name, window=10.0))
    refused(al.UsageError, "no values", lambda: surface.curve(start[lost][0] + 15))


def test_the_law_is_that_of_a_window():
    model = al.N(0.1, "deg/sqrt(h)") + al.B(1.0, "deg/h")
    record = al.simulate(model, 8000, 10.0, rng=np.random.default_rng(1))
    curve = al.dynamic(record, window=100.0, step=25.0, noise=model).curve(412.0)
    alike = al.deviation(al.simulate(model, 1000, 10.0, rng=np.random.default_rng(2)), noise=model)
    np.testing.assert_allclose(curve.edf, alike.edf)
    low, high = curve.interval()
    assert np.all((low < curve.deviation) & (curve.deviation < high))
    assert "window of 100 s at 400 s" in curve.history[-1]


def test_the_value_as_rows():
    y = noise(1000)
    y[100] = np.nan
    surface = al.dynamic(record_of(y), window=30.0, step=10.0).to("deg/h")
    headings, rows = surface.rows()
    assert headings == ["time [s]", "m", "tau [s]", "oadev [deg/h]", "count"]
    assert len(rows) == surface.variance.size
    assert rows[-1][3] == surface.deviation[-1, -1]
    assert np.nanmedian(surface.deviation[:, 0]) == pytest.approx(1.0, rel=0.05)


def test_what_is_refused_and_that_threads_give_the_same_numbers():
    record = record_of(noise(500))
    for options, words in [
        ({"window": 51.0}, "50 s long"), ({"window": 0.5}, "8 samples is 0.8 s"),
        ({"window": -1.0}, "the window must be between"), ({"step": 0.0}, "the step must be between"),
        ({"window": 10.0, "taus": [6.0]}, "up to 5 s for a record of 10 s"),
        ({"window": 10.0, "statistic": "nadev"}, "did you mean adev"),
        ({"window": 10.0, "threads": 0}, "number of threads must be at least 1"),
    ]:  # fmt: skip
        with pytest.raises(al.UsageError, match=words):
            al.dynamic(record, **options)
    one, two = (al.dynamic(record_of(noise(3000)), "mdev", window=50.0, threads=threads) for threads in (1, 2))
    np.testing.assert_array_equal(two.variance, one.variance)
