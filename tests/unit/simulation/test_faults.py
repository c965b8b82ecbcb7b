"""Faults: what each does to a record, by its statistics."""

import numpy as np
import pytest
from tests.rows import paired, refused, rows

import allanite as al
from allanite.simulation import faults

RATE = 100.0
ARCSEC = np.pi / 180 / 3600


def white(n=40_000, seed=1, unit="deg/h"):
    return al.simulate(al.N(0.3, "deg/sqrt(h)"), n, RATE, rng=np.random.default_rng(seed), unit=unit)


def ratios(record, model):
    """The variances over those that are expected, and their degrees of freedom."""
    curve = al.deviation(record, "oadev", taus="octave", noise=model)
    return curve.to("rad/s").variance / al.expected(model, "oadev", curve.tau), curve.edf


@rows("dither, seed", paired([None, faults.Dither(), faults.Dither(30.0, frequency=7.3)], [1, 2, 3]))
def test_a_rounded_rate_is_white_noise(dither, seed):
    """N grows by lsb sqrt(tau0/12); every octave within 5 standard errors: one failure in 1e5."""
    lsb, N = 60.0, al.N(0.3, "deg/sqrt(h)")
    if dither is not None:
        N = al.N(0.02, "deg/sqrt(h)")  # far below one step: only the dither makes the error white
    record = al.simulate(N, 40_000, RATE, rng=np.random.default_rng(seed), unit="deg/h")
    rounded = faults.quantize_rate(record, lsb, "deg/h", dither=dither, rng=np.random.default_rng(seed + 10))
    both = al.Model((al.N(np.hypot(N.to("deg/sqrt(h)"), lsb / 3600 * np.sqrt(3600 / RATE / 12)), "deg/sqrt(h)"),))
    ratio, edf = ratios(rounded, both)
    assert np.all(np.abs(ratio - 1)[edf > 200] < 5 * np.sqrt(2 / edf[edf > 200]) + 0.01 * (dither is not None))


@rows("dither, seed", paired([None, faults.Dither(), faults.Dither(40.0, frequency=6.1)], [1, 2, 3]))
def test_a_rounded_angle_is_quantization_noise(dither, seed):
    """Q = lsb / sqrt(12) within 5 standard errors, by dither or by noise of 0.7 steps an interval."""
    lsb, N = 0.3, 0.001 if dither else 0.035
    model = al.N(N, "deg/sqrt(h)") + al.Q(lsb / np.sqrt(12), "arcsec")
    record = al.simulate(model["N"], 40_000, RATE, rng=np.random.default_rng(seed), unit="deg/h")
    rounded = faults.quantize_angle(record, lsb, "arcsec", dither=dither, rng=np.random.default_rng(seed + 20))
    assert rounded.kind == ("increment" if dither else "count")
    ratio, edf = ratios(rounded, model)
    assert np.all(np.abs(ratio - 1)[:4] < 5 * np.sqrt(2 / edf[:4]))


def test_the_angle_errs_by_half_a_step_at_most_and_at_rest_makes_a_pattern():
    """At a hundredth of a step a reading there are counts at every hundredth reading alone."""
    still = al.Record(np.full(1000, 0.01), rate=RATE, unit="arcsec", kind="increment")
    counts = faults.quantize_angle(still, 1.0, "arcsec")
    at = np.flatnonzero(counts.values)
    assert counts.values.sum() == 10
    assert np.abs(np.diff(at) - 100).max() <= 1
    record = white()
    counts = faults.quantize_angle(record, 0.5, "arcsec")
    assert np.abs(counts.angle - record.angle).max() <= 0.2500001 * ARCSEC
    assert counts.values.dtype == np.int64
    assert counts.history[-1] == "angle rounded to 0.5 arcsec"
    dither = faults.Dither(5.0, stripped=False)
    kept = faults.quantize_angle(white(), 0.1, "arcsec", dither=dither, rng=np.random.default_rng(1))
    assert kept.kind == "count"
    assert kept.rate_values.std() > 2 * white().rate_values.std() / 10


def test_gaps_and_outliers_have_the_share_and_the_size():
    lossy = faults.gaps(white(), 0.1, 0.5, rng=np.random.default_rng(1))
    lost = np.isnan(lossy.values)
    assert lost.mean() == pytest.approx(0.1, abs=0.03)
    stretches = int((np.diff(lost.astype(int)) > 0).sum())
    assert lost.sum() / stretches == pytest.approx(50, rel=0.3)
    assert not lost[[0, -1]].any()
    assert lossy.history[-1] == f"{lost.sum()} samples missing in {stretches} stretches"
    np.testing.assert_array_equal(lossy.values[~lost], white().values[~lost])
    rng = np.random.default_rng(1)
    np.testing.assert_array_equal(faults.gaps(white(), 0.0, 1.0, rng=rng).values, white().values)
    np.testing.assert_array_equal(faults.outliers(white(), 0.0, 20.0, rng=rng).values, white().values)
    jumps = faults.outliers(white(), 0.01, 20.0, rng=np.random.default_rng(1)).values - white().values
    hit = np.abs(jumps) > 0
    assert hit.mean() == pytest.approx(0.01, abs=0.003)
    assert np.abs(jumps[hit]) == pytest.approx(20 * white().values.std(), rel=0.02)
    assert 0.3 < (jumps[hit] > 0).mean() < 0.7


def test_a_step_and_a_profile_multiply_the_noise():
    record = white()
    end = record.size / record.rate
    y = faults.noise_profile(record, [0, end / 2, end / 2, end], [1, 3, 2, 2]).values
    before = record.values - record.values.mean()
    factor = (y - record.values.mean()) / before
    at = (np.arange(record.size) + 0.5) / record.rate
    np.testing.assert_allclose(factor, np.where(at < end / 2, 1 + 4 * at / end, 2.0), rtol=1e-6)


@rows("order", [1, 4])
def test_a_filter_takes_half_of_the_power_at_its_cutoff(order):
    density = al.spectrum(faults.low_pass(white(), 10.0, order=order), sides="two", bins=None)
    flat = np.median(density.density[(density.frequency > 0.2) & (density.frequency < 1)])
    near = np.mean(density.density[np.abs(density.frequency - 10) < 1])
    assert near / flat == pytest.approx(0.5, abs=0.12)


def test_a_constant_and_the_range_of_rates_and_increments():
    record = faults.constant(white(), 0.1, "deg/s")
    assert record.values.mean() == pytest.approx(360.0)
    clipped = faults.clip(record, 361.0, "deg/h")
    assert clipped.values.max() == 361.0
    assert "clipped at 361 deg/h" in clipped.history[-1]
    # 0.1 arcsec counts: 36 deg/h is 0.36 arcsec in 10 ms
    counts = al.Record([3, 1, 2], rate=100.0, unit="arcsec", kind="count", scale=0.1)
    moved = faults.constant(counts, 36.0, "deg/h")
    np.testing.assert_allclose(moved.values, [6.6, 4.6, 5.6])
    assert moved.kind == "increment"
    np.testing.assert_allclose(moved.rate_values - counts.rate_values, 36 * ARCSEC, rtol=1e-9)


NAN = al.Record(np.array([1.0, np.nan, 2.0]), rate=10.0, unit="deg/s")
ANGLE = al.Record(np.arange(4.0), rate=10.0, unit="deg", kind="angle")
RNG = np.random.default_rng(1)


@rows("fault, words", [
    *((lambda profile=profile: faults.noise_profile(white(), *profile), "a noise profile needs|must be between")
      for profile in (([], []), ([0, 1], [1]), ([1, 0], [1, 1]), ([0, 1], [1, -1]), ([0, np.nan], [1, 1]))),
    (lambda: faults.quantize_rate(NAN, 1.0, "deg/s"), "before samples"),
    (lambda: faults.quantize_angle(NAN, 1.0, "arcsec"), "before samples"),
    (lambda: faults.low_pass(NAN, 1.0), "before samples"),
    (lambda: faults.low_pass(white(), 80.0), "between 1e-05 and 50 Hz"),
    (lambda: faults.low_pass(white(), 8.0, order=0), "order must be between 1 and 10"),
    (lambda: faults.constant(ANGLE, 1.0, "deg/s"), "not to angles"),
    (lambda: faults.constant(white(), 1.0, "ug"), "neither a unit of a rate"),
    (lambda: faults.quantize_rate(white(), 1.0, "arcsec"), "is not a unit of rad/s samples"),
    (lambda: faults.quantize_angle(white(), 1.0, "deg/s"), "use arcsec"),
    (lambda: faults.quantize_rate(white(), 0.0, "deg/s"), "lsb must be between"),
    (lambda: faults.quantize_rate(white(), 1.0, "deg/s", dither=faults.Dither()), "drawn from a generator"),
    (lambda: faults.quantize_angle(white(), 1e-30, "arcsec"), "use a larger step"),
    (lambda: faults.gaps(al.Record([1.0, 2.0], 1.0, "deg/h"), 0.5, 1.0, rng=RNG), "no samples to remove"),
    (lambda: faults.Dither(0.0), "amplitude must be between"),
    (lambda: faults.clip(white(), -1.0, "deg/h"), "limit must be between"),
    (lambda: faults.gaps(white(), 1.5, 1.0, rng=RNG), "share must be at least 0 and below 1"),
    (lambda: faults.outliers(white(), -0.1, 1.0, rng=RNG), "between 0 and 1"),
])  # fmt: skip
def test_what_is_refused(fault, words):
    refused(al.UsageError, words, fault)


def test_they_compose_and_say_so():
    rng = np.random.default_rng(5)
    record = faults.constant(white(5000), 15.0, "deg/h")
    record = faults.gaps(faults.quantize_angle(record, 0.1, "arcsec"), 0.02, 0.3, rng=rng)
    assert [step.split()[0] for step in record.history][:3] == ["simulated:", "constant", "angle"]
    assert len(record.history) == 4
    assert record.kind == "increment"
    assert np.isnan(record.values).any()
