"""Each application on ten inputs of stated seeds, against short independent computations; how often its limits hold.

Rates, lengths, orders, noises and latitudes differ from those of the papers, and plain numpy draws the samples.
"""

import math

import numpy as np
import pytest
from scipy.stats import f as fisher
from tests.reference import allan, angle as encoder, attitude, rate as referee, theo
from tests.reference.noise import covariance, draw
from tests.rows import rows
from tests.shares import binomial_tail

import allanite as al
from allanite.reporting import table

SEEDS = range(1, 11)
POWERS = {"Q": (0.0, ""), "N": (0.5, "/sqrt(s)"), "B": (1.0, "/s"), "K": (1.5, "/s/sqrt(s)")}
G = 9.80665


def model(sizes, rate, unit="rad"):
    """Noise of sizes per sample interval; of an accelerometer in m/s."""
    return al.Model(tuple(getattr(al, s)(v * rate ** POWERS[s][0], unit + POWERS[s][1]) for s, v in sizes.items()))


def sizes_of(rng, among, n):
    """Some of these terms, all of which matter to n samples."""
    typical = {"Q": math.sqrt(n), "N": 1.0, "B": 0.1, "K": 0.3 / math.sqrt(n)}
    chosen = [s for s in among if rng.random() < 0.6] or [among[0]]
    return {s: float(typical[s] * 10 ** rng.uniform(-0.7, 0.7)) for s in chosen}


def likely(hits):
    """Whether about 95 of 100 limits hold the truth (error probability 2e-3)."""
    return binomial_tail(int(np.sum(hits)), len(hits), 0.95) > 1e-3


@rows("seed", SEEDS)
def test_rates_and_their_standard_errors(seed):
    rng = np.random.default_rng(seed)
    n, rate, kind = int(rng.integers(5, 150)), 10 ** rng.uniform(-2, 3.5), ["rate", "increment", "angle"][seed % 3]
    sizes, slope = sizes_of(rng, "NQBK", n), rng.choice([0.0, 1.0]) / n
    y = draw(rng, sizes, n)[0] + rng.normal() + slope * np.arange(n)
    values = {"rate": y * rate, "increment": y, "angle": np.append(0.0, np.cumsum(y))}[kind]
    record = al.Record(values, rate=rate, unit="rad/s" if kind == "rate" else "rad", kind=kind)
    noise = al.Model((*model(sizes, rate), *([al.R(slope * rate**2, "rad/s^2")] if slope else [])))
    settled, C = covariance({s: v for s, v in sizes.items() if s in "QN"}, n), covariance(sizes, n)
    target = ["mean", "centre", "start"][seed // 4]
    aim = np.bincount({"mean": range(n), "centre": [(n - 1) // 2, n // 2], "start": [0]}[target], minlength=n)
    aim = aim / aim.sum()
    waves = [np.arange(n) / n] if slope else []
    shifted = C + 10 * np.abs(C).max()  # of flicker and random walk only contrasts have a variance
    linear = {
        "mean": np.full(n, 1 / n), "hamming": referee.weights(referee.hamming, n),
        "regression": referee.weights(lambda y: referee.regression(np.append(0.0, np.cumsum(y)), 1.0), n),
        "conditional": referee.weights(lambda y: np.mean(referee.lines(np.append(0.0, np.cumsum(y)), 1.0, 3)), n),
        "optimal": referee.best_linear(shifted, aim, settled, waves),
    }  # fmt: skip
    every = al.constant_rate.EstimatorSettings(lines=3, allowed=math.inf)
    for method, w in linear.items():
        found = al.constant_rate.estimate(record, method, model=noise, target=target, options=every)
        off = w - aim
        error = math.sqrt(w @ settled @ w + off @ (C - settled) @ off + slope**2 * (off @ np.arange(n)) ** 2)
        assert found.standard_error / rate == pytest.approx(error, rel=2e-4), method
        assert found.value / rate == pytest.approx(w @ y, abs=2e-3 * error), method


def test_limits_of_a_rate_under_noise_that_is_identified():
    hits = []
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        n, rate = int(rng.integers(1000, 2500)), 10 ** rng.uniform(-1, 3)
        y, slow = draw(rng, sizes_of(rng, "NQBK", n), n)
        record = al.Record(1e-6 * rate * (y + 100.0), rate=rate, unit="rad/s", name="z")
        noise = al.identify(record, terms="QNBK")
        for method in ("mean", "regression", "optimal"):
            low, high = al.constant_rate.estimate(record, method, model=noise).interval()
            hits.append(low < 1e-6 * rate * (slow.mean() + 100.0) < high)
    assert sum(hits) >= 25


@rows("seed", SEEDS)
def test_angle_sensors(seed):
    """Estimate, planned errors, and limits of ten repetitions; errors of the readings are not linearized."""
    rng = np.random.default_rng(seed)
    latitude, interval = rng.uniform(-1.2, 1.2), float(rng.choice([5.0, 12.0, 30.0]))
    n, start, turn = int(rng.integers(250, 400)), rng.uniform(-9000, 9000), rng.uniform(100, 900)
    orders = {a: tuple(sorted(rng.choice([64, 100, 180, 256, 360], 2, replace=False).tolist())) for a in "hq"}
    nuisance = [name for name in ("ax", "az", "A1", "A3") if rng.random() < 0.5 and seed > 1]
    time, prior = start + interval * np.arange(n), (3e-6, 1e-5) if seed % 2 else None
    A = np.array([encoder.row(t, latitude, "exact", orders, nuisance=nuisance, turn=turn) for t in time])
    known = None if prior is None else np.repeat(prior, [8, len(nuisance)])
    gimbals = al.angle.gimbals(time, latitude=latitude, turn_period=turn)
    truth = {a: {k: 1e-6 * rng.standard_normal(2) for k in orders[a]} for a in "hq"}
    cosine = np.array([encoder.difference(t, latitude, truth) for t in time])
    true = np.array([part for a in "hq" for pair in truth[a].values() for part in pair])
    hits = []
    for sigma in [1e-6, None] * 5:
        z = cosine + 1e-6 * rng.standard_normal(n)
        calibration = al.angle.estimate(z, gimbals, orders=orders, nuisance=nuisance, sigma=sigma, prior=prior)
        found = calibration.solution
        values, errors = encoder.least_squares(A, z, sigma, known)
        np.testing.assert_allclose(found.errors / errors, 1, atol=1e-5)
        np.testing.assert_allclose((found.values - values) / errors, 0, atol=1e-4)
        hits += [a < t < b for t, (a, b) in zip(true, map(found.interval, found.names), strict=False)]
    assert likely(hits) or prior is not None
    assert ("other estimated parameters" in table(calibration)) == bool(nuisance)
    settings = al.angle.AngleSettings(latitude, n * interval, interval, sigma=1e-6, turn_period=turn, prior=prior,
                                      orders=orders, nuisance=tuple(nuisance))  # fmt: skip
    planned = al.angle.plan(settings, start).errors
    np.testing.assert_allclose(planned / encoder.least_squares(A, z, 1e-6, known)[1], 1, atol=1e-5)


@rows("seed", SEEDS)
def test_an_encoder_against_a_reference(seed):
    rng = np.random.default_rng(seed)
    n, turns, trend = int(rng.integers(150, 900)), rng.choice([-1, 1]) * 10 ** rng.uniform(-0.5, 1), seed % 3
    orders = sorted(rng.choice([1, 2, 3, 8, 36, 64, 100], 3, replace=False).tolist())
    angle, number = 2 * np.pi * turns * np.sort(rng.random(n)), np.linspace(-1, 1, n)
    true, offset, hits = 1e-5 * rng.standard_normal(6), rng.uniform(-3.1, 3.1), []
    A = np.column_stack([w(k * angle) for k in orders for w in (np.sin, np.cos)])
    columns = np.column_stack([A, *(number**i for i in range(trend + 1))])
    for sigma in [3e-6, None] * 4:
        z = offset + A @ true + 3e-6 * rng.standard_normal(n) + trend * 1e-5 * number
        found = al.angle.calibrate(np.mod(angle, 2 * np.pi), np.mod(angle - z, 2 * np.pi), orders, sigma=sigma,
                                   trend=trend)  # fmt: skip
        values, errors = encoder.least_squares(columns, z, sigma)
        np.testing.assert_allclose(found.solution.errors / errors, 1, atol=1e-5)
        np.testing.assert_allclose((found.solution.values - values)[:6] / errors[:6], 0, atol=1e-3)
        limits = (found.interval(k) for k in orders)
        hits += [a < size < b for size, (a, b) in zip(np.hypot(true[::2], true[1::2]), limits, strict=True)]
    assert likely(hits)


AXES = ["x,y,z", "y,-x,z", "z,y,-x", "-y,-z,x", "x,-z,y", "-x,y,-z", "z,x,y", "-z,-x,y", "y,x,-z", "-y,x,z"]


@rows("seed", SEEDS)
def test_roll_and_pitch(seed):
    """The recursion, its error, the best time constant and the steady Kalman filter."""
    rng = np.random.default_rng(seed)
    n, rate, axes = int(rng.integers(400, 700)), 10 ** rng.uniform(0, 2.5), AXES[seed - 1].split(",")
    N = 10 ** rng.uniform(-4, -3)  # per sample, rad
    tilt, gains = N * 10 ** rng.uniform(0.8, 1.6), np.array([1 / 12, seed % 2 / 900]) * rate ** np.array([1, 2])
    roll, pitch = rng.uniform(-0.3, 0.3, 2)
    up = np.array([-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)])
    gyro, force = rate * N * rng.standard_normal((n, 3)), G * (up + tilt * rng.standard_normal((n, 3)))
    down = -1 if seed in (3, 6, 9) else 1
    place, sign = [" xyz".index(a[-1]) - 1 for a in axes], [-1 if a[0] == "-" else 1 for a in axes]
    mounted = np.empty((n, 6))
    mounted[:, place], mounted[:, [3 + i for i in place]] = gyro * sign, down * force * sign
    recording = al.Recording(tuple(al.Record(v, rate, "rad/s" if i < 3 else "m/s^2", name=f"{'ga'[i // 3]}{i % 3}")
                                   for i, v in enumerate(mounted.T)))  # fmt: skip
    noises = model({"N": N}, rate), model({"N": G * tilt / rate}, rate, "m/s")
    chosen = al.attitude.VerticalSettings(
        "second-order" if gains[1] else "complementary", 1 / gains[0], gains[1] ** -0.5 if gains[1] else None,
        axes=AXES[seed - 1], gyro=str(noises[0]), accelerometer=str(noises[1]),
    )  # fmt: skip
    study = al.attitude.vertical(recording, settings=chosen)
    wanted = attitude.recursion(gyro - gyro.mean(axis=0), force, gains, 1 / rate)
    np.testing.assert_allclose(np.stack([study.roll, study.pitch], axis=1), wanted, atol=0.01 * N)
    own = gains / rate ** np.array([1, 2])
    predicted = al.attitude.predicted_error(*noises, al.attitude.Loop(*gains), rate=rate).rms
    assert predicted**2 == pytest.approx(attitude.variance(own, N, tilt), rel=1e-3)
    assert study.angles[0].prediction.rms == pytest.approx(predicted, rel=0.03)  # of a finite run
    best = al.attitude.optimal_time_constant(*noises, rate=rate)
    P = (math.sqrt(N**4 + 4 * N**2 * tilt**2) - N**2) / 2  # of the scalar Riccati equation, after the update
    assert (best.first.rms**2, best.bound**2) == (pytest.approx(P, rel=1e-3), pytest.approx(P, rel=2e-3))
    assert best.time_constant * rate == pytest.approx(-1 / math.log(1 - P / tilt**2), rel=1e-3)


def test_coefficients_of_a_temperature():
    """Least squares where the noise is said to be white; the limits of 30 records where it is identified."""
    hits = []
    for seed in range(1, 41):
        rng = np.random.default_rng(seed)
        n, rate, slope = int(rng.integers(210, 600)), 10 ** rng.uniform(-1, 2), rng.choice([0.0, 0.1])
        temperature = 20 + 5 * np.sin(rng.uniform(9, 30) * np.arange(n) / n + rng.uniform(0, 6))
        y = rate * 1e-6 * (draw(rng, sizes_of(rng, "NQBK", n), n)[0] + slope * temperature)
        record, beside = al.Record(y, rate, "rad/s", name="z"), al.Record(temperature, rate, "degC", name="temp")
        terms = "N" if seed <= 10 else "QNBK"
        settings = al.compensation.FitSettings(terms=terms, least=0.5)
        found = al.compensation.compensate(record, beside, ["temp"], settings=settings)
        if terms == "N":
            values, errors = encoder.least_squares(np.column_stack([temperature, np.arange(n), np.ones(n)]), y)
            own = [values[0] + k * errors[0] for k in (0, -1.959964, 1.959964)]
            assert [getattr(found["temp"], name) for name in ("value", "low", "high")] == pytest.approx(own, rel=1e-5)
        else:
            hits.append(found["temp"].low < rate * 1e-6 * slope < found["temp"].high)
    assert likely(hits)


@rows("seed", SEEDS)
def test_rounding_by_a_converter(seed):
    rng = np.random.default_rng(seed)
    n, rate, bits = int(rng.integers(2000, 6000)), 10 ** rng.uniform(0, 3), int(rng.integers(5, 25))
    full, gain, scale = 10 ** rng.uniform(-2, 2), float(rng.choice([1, 4])), 10 ** rng.uniform(-2, 1)
    step, deviation = 2 * full / gain / 2**bits, full / gain / rng.uniform(5, 8)
    volts = step * np.round(deviation * rng.standard_normal(n) / step)
    stage = al.signals.Stage("ADC", bits, full, "V", gain)
    found = al.signals.budget(al.Record(volts, rate, "V", name="u"), [stage], scale=scale, sense=2.0,
                              recipe=al.Recipe(terms="N"))  # fmt: skip
    (part,) = found.stages
    assert (part.symbol, part.coefficient) == ("N", pytest.approx(step * scale / 2 / math.sqrt(12 * rate), rel=1e-9))
    assert part.measured == pytest.approx(volts.std() * scale / 2 / math.sqrt(rate), rel=3e-3)
    codes = np.rint(volts / step)
    assert (part.codes.distinct, part.codes.span) == (np.unique(codes).size, np.ptp(codes) + 1)
    shares = [(part.coefficient * 2.0 ** (bits - b) / part.measured) ** 2 for b in range(1, 60)]
    assert part.enough == 1 + next(i for i, share in enumerate(shares) if share < 0.01)
    assert part.matters is (shares[bits - 1] >= 0.01)
    assert not found.findings


@rows("seed", SEEDS)
def test_theoh(seed):
    rng = np.random.default_rng(seed)
    n, rate = int(rng.integers(95, 500)), 10 ** rng.uniform(-3, 4)
    y = draw(rng, sizes_of(rng, "NQBK", n), n)[0]
    x = np.append(0.0, np.cumsum(y - y.mean()))
    curve = al.deviation(al.Record(y, rate, "rad/s"), statistic="theoh", taus=["octave", "decade"][seed % 2])
    joint = max(m for j in range(9) for m in [[2**j], [10**j, 2 * 10**j, 4 * 10**j]][seed % 2] if m <= 0.2 * n)
    for tau, variance in zip(curve.tau * rate, curve.variance, strict=True):
        beyond = round(tau) > joint
        wanted = theo.theobr(x, round(tau / 0.75), 1.0) if beyond else allan.oadev(x, round(tau), 1.0)
        assert variance == pytest.approx(wanted, rel=1e-9), tau


@rows("seed", SEEDS)
def test_two_records_of_white_noise(seed):
    """Ratio, limits and p are those of Fisher's law."""
    rng = np.random.default_rng(seed)
    sizes, rate, ratio = rng.integers(400, 4000, 2).tolist(), 10 ** rng.uniform(-2, 3), rng.choice([0.9, 1.0, 1.05])
    pair = [k * rng.standard_normal(n) + rng.normal() for k, n in zip((1.0, ratio), sizes, strict=True)]
    found = al.compare(*(al.Record(y, rate, "rad/s", name="z") for y in pair), terms="N")
    (change,) = found.pairs[0].changes
    F = pair[1].var(ddof=1) / pair[0].var(ddof=1)
    law = fisher(sizes[1] - 1, sizes[0] - 1)
    assert change.ratio == pytest.approx(math.sqrt(F), rel=2e-3)
    np.testing.assert_allclose(change.limits(0.95), np.sqrt(F / law.ppf([0.975, 0.025])), rtol=3e-3)
    assert change.p == pytest.approx(2 * min(law.cdf(F), law.sf(F)), abs=0.02)
