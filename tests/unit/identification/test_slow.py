"""What is slow and no noise: the pieces against literal forms, and each thing named in a record that has it."""

import math
import re

import numpy as np
import pytest
from scipy.fft import dct
from scipy.special import zeta
from scipy.stats import kurtosis, kurtosistest
from tests.rows import paired, rows
from tests.unit.identification import records
from tests.unit.identification.records import RATE, B, K, N, claimed, covers, forms_of, rates_of

import allanite as al
from allanite.identification.checks.residuals import _normal, jumps
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import likelihood, wave_directions, with_warm_up
from allanite.study.noise import noise_of


def record_of(model, n=2**15, seed=1, spoil=None):
    y = rates_of(model, n, seed)
    if spoil is not None:
        spoil(y, model, np.random.default_rng(seed + 1000))
    return al.Record(y, RATE, "rad/s")


def power_law(a, corner):
    """Noise of density f^-a that equals N at the corner, Hz, as means over samples."""

    def add(y, model, rng):
        m = 8 * y.size
        f = np.arange(1, m // 2 + 1) / m
        density = np.sin(np.pi * f) ** 2 / np.pi**2 * (zeta(2 + a, f) + zeta(2 + a, 1 - f))
        size = model["N"].value * math.sqrt(RATE) * (corner / RATE) ** (a / 2)
        c = rng.standard_normal((f.size, 2)).view(np.complex128)[:, 0] * np.sqrt(density * m / 2)
        y += size * np.fft.irfft(np.concatenate(([0], c)), m)[: y.size]

    return add


def settling(size, share):
    def add(y, model, rng):
        y += size * model["B"].value * np.exp(-np.arange(y.size) / (share * y.size))

    return add


def warmed(seen, symbols, tau):
    return with_warm_up(likelihood(seen, symbols), seen, np.ones(seen.first.size, dtype=bool), tau)


@rows("tau", [40.0, 300.0])
def test_directions_are_sums_of_literal_transforms(tau):
    """Edges, warm-up and ramp, by bins: exact where a bin holds one coefficient, nearly so where it holds several."""
    n = 700
    seen = spectrum(record_of(N + B, n), detrend=True)
    part = warmed(seen, "QNBKR", tau)
    assert part.flat.tolist() == [False, False, True, True]
    y = np.asarray(record_of(N + B, n).values) - seen.slope * (np.arange(n) - (n - 1) / 2)
    first, warm, ramp = (dct(x, norm="ortho") for x in (np.eye(n)[0], np.exp(-np.arange(n) / tau), np.arange(n)))
    even = np.arange(n) % 2 == 0
    ramp[65:] = 0.0
    U = np.stack((first * even, first * ~even, warm, ramp))[:, 1:]
    c = dct(y, norm="ortho")[1:]
    at = seen.first - 1
    UU, Uc = np.add.reduceat(U[:, None] * U, at, axis=2), np.add.reduceat(U * c, at, axis=1)
    single = seen.count == 1
    np.testing.assert_allclose(part.UU[single], np.moveaxis(UU, 2, 0)[single], rtol=1e-9, atol=1e-9 * UU.max())
    np.testing.assert_allclose(part.UU, np.moveaxis(UU, 2, 0), rtol=0.01, atol=1e-6 * UU.max())
    np.testing.assert_allclose(part.Uc, Uc.T, atol=2e-3 * np.abs(Uc).max())


def test_a_warm_up_with_gaps_is_that_of_the_readings_that_are_left():
    y = record_of(N + B, 20_000).values.copy()
    y[3000:4500] = np.nan
    seen = spectrum(al.Record(y, RATE, "rad/s"), detrend=True)
    tau = 4000.0
    part = warmed(seen, "NBKR", tau)
    literal = dct(np.exp(-np.flatnonzero(np.isfinite(y)) / tau), norm="ortho")[1:65]
    np.testing.assert_allclose(part.UU[:64, 2, 2], literal**2, rtol=2e-3, atol=1e-5 * literal.max() ** 2)


def test_kurtosis_as_a_normal_deviate():
    for n in (30, 300, 3000):
        x = np.random.default_rng(n).standard_t(6, n)
        assert _normal(kurtosis(x), n) == pytest.approx(kurtosistest(x).statistic, rel=1e-6, abs=1e-9)


def test_the_size_of_a_burst_in_white_noise_and_outliers_are_none():
    """A window over it sees a burst of its own length whole."""
    sigma, at = 0.01, np.arange(2**15)
    white, u = al.Model("N 0.001 rad/sqrt(s)"), np.random.default_rng(1).standard_normal(2**15).astype(np.float32)
    burst, outliers = (u + np.float32(size) * ((at >= 8000) & (at < end)) for size, end in ((0.8, 8256), (60, 8004)))
    found = jumps(burst, white, RATE)
    assert found.weight > 1
    assert (found.length, found.jump) == (pytest.approx(256, rel=0.5), pytest.approx(0.8 * sigma, rel=0.25))
    assert found.largest == pytest.approx(8128, abs=100)
    assert jumps(burst[:4000], white, RATE) is jumps(outliers, white, RATE) is None


@rows("periods", [1.7, 3.0, 6.2])
def test_the_directions_of_a_wave_are_its_cosine_transforms(periods):
    n = 3000
    seen = spectrum(record_of(N, n), detrend=True)
    phase = 2 * math.pi * periods / n * (np.arange(n) + 0.5 - n / 2)
    for (even, odd), wave in zip(wave_directions(seen, periods), (np.cos(phase), np.sin(phase)), strict=True):
        known = dct(wave, norm="ortho")[1:65]
        assert np.where(seen.first[:64] % 2, odd[:64], even[:64]) == pytest.approx(known, abs=1e-3)


@rows("lost", [0, 2000])
def test_a_slow_wave_is_named_and_is_no_random_walk(lost):
    """In white noise it was K in 93 % of records, and K was wrong in three of four that have it."""
    n, amplitude = 2**14, 3.5e-4
    t = (np.arange(n) + 0.5) / RATE
    y = record_of(al.Model((N,)), n, 3).values + amplitude * np.sin(2 * np.pi * 0.019 * t + 0.7)
    y[5000 : 5000 + lost] = np.nan
    record = records.record_of(y)
    fit = al.identify(record)
    (line,), (finding,) = fit.lines, fit.findings
    assert finding.name == "wave"
    assert abs(line.amplitude - amplitude) < 3 * line.standard_error
    assert (line.frequency, line.phase) == (pytest.approx(0.019, rel=0.02), pytest.approx(0.7, abs=0.2))
    assert claimed(fit) == {"N"}
    assert al.residuals(record, fit).explained


def test_a_warm_up_is_named_and_taken_off_the_noise():
    record = record_of(N + B, 2**16, 3, settling(-30, 0.2))
    fit = al.identify(record)
    (finding,) = fit.findings
    assert finding.name == "warm-up"
    size, error = map(float, re.search(r"starts (\S+) ± (\S+) deg/h", finding.what).groups())
    assert abs(size + 30 * 7.2) < 3 * error
    assert finding.what in fit.notes
    assert not {"K", "R"} & claimed(fit)
    assert covers(fit, B)
    left = al.residuals(record, fit)
    assert left.findings == (finding,)
    assert fit.validity == left.grade == "approximate"
    assert left.verdict.count("the sensor warms up") == 1
    back = al.Fit.from_dict(fit.to_dict())
    assert (back.findings, back.warm_up) == (fit.findings, fit.warm_up)
    first = float(re.search(r"prepare\.trim\(recording, ([0-9.]+)\)", finding.remedy)[1])
    rest = al.identify(al.Record(record.values[round(first * RATE) :], RATE, "rad/s"))
    assert (rest.findings, rest.goodness.explained) == ((), True)


@pytest.mark.slow("seconds of analyses")
@rows("seed, terms", paired([3, 4, 31, 32], ["auto", "N,W"]))
def test_a_strong_warm_up_is_explained_and_so_is_the_record(seed, terms):
    """Alone and with white noise as the only other term."""
    y = np.random.default_rng(seed).standard_normal(40_000) - 3 * np.exp(-np.arange(40_000) / 4000)
    noise = noise_of(al.Record(y, 20.0, "deg/h"), al.Recipe(terms=terms))
    assert (noise.validity, noise.fit.scope.until) == ("approximate", None)
    assert all(check.passed for check in noise.residuals.checks)
    assert noise.fit.warm_up.value == pytest.approx(math.radians(3 / 3600), rel=0.05)
    assert covers(noise.fit, al.N(20**-0.5, "deg/h*sqrt(s)"))


def test_a_share_of_the_coefficients_bounds_what_directions_explain():
    """Where all terms vanish, directions explain no more than the power: the likelihood has no end below."""
    seen = spectrum(record_of(N + B, 2000, spoil=settling(-1000, 0.15)), detrend=True)
    part = warmed(seen, "QNR", 300.0).trusted(np.full(seen.first.size, 0.4))
    theta = part.minimise(np.array([False, True]))[0]
    values = [part.value(theta * 10.0**-k) for k in range(0, 40, 4)]
    assert values == sorted(values)


@rows("share", [0.2, 0.04, 0.015])
def test_a_short_warm_up_is_no_step(share):
    fit = al.identify(record_of(N + B, 2**14, 5, settling(-90, share)))
    (finding,) = fit.findings
    assert finding.name == "warm-up"
    tau = float(re.search(r"time constant of (\S+) s", finding.what)[1])
    assert tau == pytest.approx(share * 2**14 / RATE, rel=0.2)


@rows("kind", ["rate", "increment", "count", "angle"])
def test_the_noise_between_steps_is_checked_without_them(kind):
    y = np.random.default_rng(3).normal(scale=0.05, size=2**14) + 0.05 * (np.arange(2**14) >= 6000)
    record = forms_of(np.rint(1e6 * y / RATE).astype(np.int64), 1e-6, "deg")[kind]
    fit = al.identify(record)
    ((time, size),) = fit.steps
    assert (time, np.degrees(size)) == pytest.approx((6000 / RATE, 0.05), rel=0.05)
    assert al.residuals(record, fit).explained
    assert al.analyze(record).channels[0].fit.validity == "approximate"
    assert al.from_dict(fit.to_dict()).steps == fit.steps


@pytest.mark.slow("takes more than half a second")
def test_a_warm_up_that_fills_the_record_is_to_be_waited_for():
    remedy = al.identify(record_of(N + B, 2**16, 2, settling(200, 0.3))).findings[0].remedy
    assert "record again, starting at least" in remedy
    assert "trim" not in remedy


@rows("a", [0.8, 1.2])
def test_another_power_law_is_named(a):
    model = al.Model((N,))
    record = record_of(model, 2**18, 1, power_law(a, 1.0))
    fit = al.identify(record)
    (finding,) = fit.findings
    assert finding.name == "flicker exponent"
    found, low, high = map(float, re.search(r"f\^-(\S+) \((\S+) to (\S+)\)", finding.what).groups())
    assert low < a < high
    assert low < found < high
    value, error = map(float, re.search(r"N = (\S+) ± (\S+) deg/sqrt", finding.consequence).groups())
    assert abs(value - 0.3) < 3 * error
    assert fit["N"].to("deg/sqrt(h)") == pytest.approx(value, rel=1e-3)
    assert {fit[s].status for s in "BK"} == {"not valid"}
    assert not fit["Q"].claimed
    assert al.residuals(record, fit).grade == "approximate"


def test_without_flicker_or_a_low_end_nothing_is_looked_for():
    record = record_of(N + B, 2**15, 3, settling(60, 0.2))
    assert "flicker exponent" not in [finding.name for finding in al.identify(record, terms="QNK").findings]
    assert al.identify(record, band=(0.5, 50.0)).findings == ()


def test_bursts_are_named_with_a_window_without_them():
    values = record_of(N + B + K, 2**16, 3).values.copy()
    values[40_000:40_500] += 15 * B.value
    record = al.Record(values, RATE, "rad/s")
    left = al.residuals(record, al.identify(record))
    finding = next(f for f in left.findings if f.name == "popcorn")
    size, at = map(float, re.search(r"largest burst, (\S+) deg/h, is at (\S+) s", finding.what).groups())
    assert (size, at) == (pytest.approx(15 * 7.2, rel=0.3), pytest.approx(402.5, abs=2))
    assert finding.place[0] < 402.5 < finding.place[1]
    assert not left.explained
    first, last = map(int, re.search(r"trim\(recording, (\d+), (\d+)\)", finding.remedy).groups())
    part = al.Record(record.values[first * 100 : last * 100], RATE, "rad/s")
    assert al.residuals(part, al.identify(part)).findings == ()


QUIET = {
    **{name: al.sensor(name) for name in ("mems", "fog", "rlg")}, "N, 10 K": N + al.K(3e-3, "deg/s/sqrt(s)"),
    "N, 3 B": N + al.B(0.006, "deg/s"), "N B R": N + B + al.R(1e-4, "deg/s/s"),
    "N GM 5 s": al.N(3, "deg/h*sqrt(s)") + al.GM(5, "deg/h", time_constant=5.0),
}  # fmt: skip


@rows("sensor", list(QUIET))
def test_nothing_slow_is_named_in_noise(sensor):
    record = record_of(QUIET[sensor], 2**15, 4)
    assert al.residuals(record, al.identify(record)).findings == ()


@pytest.mark.filterwarnings("error")
def test_where_no_bin_tells_of_the_drift_none_is_looked_for():
    """Angle noise so strong that each piece is read by itself at all frequencies."""
    values = al.simulate(al.Q(0.7, "arcsec"), 3000, 40.0, rng=np.random.default_rng(1)).values.copy()
    values[1466:1468] = np.nan
    torn = al.Record(values, 40.0, "rad/s")
    seen = spectrum(torn, detrend=False)
    assert seen.pieces.low == 0
    assert not warmed(seen, "QNBK", 300.0).UU.any()
    assert al.identify(torn).warm_up is None
