"""Degrees of freedom of the statistics, expectation and coverage, and the power law found from one record.

Windows: errors of the degrees of freedom of the statistics over windows and of the total deviation against full
matrices 2 tr(A G A G), with A as each definition writes it, for single terms, halves of every pair, 200 random
mixtures (a ramp at most 0.9 of the variance) and three sensors; and, for an hour at 1 kHz, against windows of twice as
many points. Hybrids: TheoBR and TheoH against simulation, single noise with the ratio kf of the record, mixtures with
that of the model (`theo.KEPT` was taken from other records). Power law: pure noise, every m-th point of the angle is
what the methods see.
"""

from table import SEEDS, Row, begin, covered, section, seeded

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from unittest.mock import patch

import numpy as np
from tests.reference.dense import moments, quadratic_form

import allanite as al
from allanite.core.units import SIGNALS
from allanite.statistics import GRIDS, STATISTICS, integrated
from allanite.statistics.confidence.powerlaw import identify_power_law
from allanite.statistics.moments import folded, windowed

WINDOWS = ("theo1", "mtotdev", "htotdev", "pdev", "totdev")
SYMBOLS = "QNBKR"
TERMS = [al.terms.TERMS[s] for s in SYMBOLS]
KINDS = ("single", "pairs", "random", "sensors")
HOUR = 3_600_000


def mixtures(E: np.ndarray) -> dict[str, np.ndarray]:
    """Shares of the expected variance, (k, 5), by kind; of sensors at 100 and 0.1 Hz, which shows every term."""
    pairs = [np.bincount([i, j], minlength=5) / 2 for i in range(5) for j in range(i + 1, 5)]
    random = seeded(0, "mixtures").dirichlet(np.full(5, 0.5), 250)
    sensors = []
    for name, rate in product(al.planning.SENSORS, (100.0, 0.1)):
        power = {t.symbol: t.value**2 * rate ** (2 * t.row.power - 2) for t in al.sensor(name)}
        variance = np.array([power.get(s, 0.0) for s in SYMBOLS]) * E
        sensors.append(variance / variance.sum())
    shares = (np.eye(5)[:4], np.array(pairs), random[random[:, 4] < 0.9][:200], np.array(sensors))
    return dict(zip(KINDS, shares, strict=True))


def errors(ours: np.ndarray, exact: np.ndarray, E: np.ndarray) -> dict[str, float]:
    """Largest relative error of the degrees of freedom by kind of mixture, per cent."""
    worst = {}
    for kind, p in mixtures(E).items():
        shares = p * (E != 0)
        shares = shares[shares.sum(axis=1) > 0.05]
        inverse = [np.einsum("pi,ij,pj->p", shares, r, shares) for r in (ours, exact)]
        worst[kind] = 100 * float(np.max(np.abs(inverse[1] / inverse[0] - 1)))
    return worst


def relative(row: al.statistics.Statistic, m: int, n: int) -> np.ndarray:
    """Relative second moments of the terms."""
    return windowed.relative(row, TERMS, m, int(row.count(n, np.array([m]))[0]), n)


def largest_of(each: list[dict[str, float]]) -> list[str]:
    """Cells of the largest error of each kind."""
    return [f"{max(found[kind] for found in each):.2f}" for kind in KINDS]


def factors(name: str, n: int) -> list[int]:
    """About 40 averaging factors from the first to the last, odd ones too, and the last ones."""
    row = STATISTICS[name]
    largest = row.largest(n)
    grid = np.unique(np.rint(np.geomspace(1, largest, 60)).astype(int) // row.step * row.step)
    last = [largest - row.step * k for k in (1, 2, 5)]
    return sorted({int(m) for m in (*grid, *last) if m >= row.step})


def against_matrices(name: str, n: int) -> Row:
    """Errors of a statistic at all averaging factors of a short record."""
    row, each, expectation = STATISTICS[name], [], 0.0
    for m in factors(name, n):
        E, r = moments(quadratic_form(row, m, n), TERMS)
        ours = windowed.response(row, TERMS, m, n)
        expectation = max(expectation, float(np.max(np.abs(ours[E != 0] / E[E != 0] - 1))))
        each.append(errors(relative(row, m, n), r, E))
    return (name, str(n), f"{len(each)}", *largest_of(each), f"{expectation:.0e}")


def against_finer_windows(name: str) -> Row:
    """An hour at 1 kHz, octaves: windows of twice as many points, three times as many rows of the folded record."""
    row, scheme = STATISTICS[name], STATISTICS[name].scheme
    finer = replace(scheme, levels=tuple(2 * k for k in scheme.levels))
    if scheme.sharp is not None:
        finer = replace(finer, sharp=replace(scheme.sharp, levels=tuple(2 * k for k in scheme.sharp.levels)))
    octaves = [int(m) for m in GRIDS["octave"](row.largest(HOUR)) if m > 1]
    ours = [relative(row, m, HOUR) for m in octaves]
    with patch.object(folded, "ROWS", 3 * folded.ROWS):
        exact = [relative(replace(row, scheme=finer), m, HOUR) for m in octaves]
    sizes = (windowed.response(row, TERMS, m, HOUR) for m in octaves)
    return (name, str(HOUR), str(len(octaves)), *largest_of(list(map(errors, ours, exact, sizes))), "-")


SAMPLES, FEWEST = 512, 1.5
HYBRIDS = (
    ({"N": 1.0}, None), ({"B": 1.0}, None), ({"K": 1.0}, None), ({"N": 1.0, "K": 0.05}, "model"),
    ({"N": 1.0, "B": 0.3}, "model"), ({"Q": 2.0, "N": 1.0, "B": 0.3, "K": 0.02}, "model"),
)  # fmt: skip
FACTORS = {"theobr": (32, 100, 200, 400), "theoh": (8, 64, 200, 400)}


def hybrids(coefficients: dict[str, float], bias: str | None, records: int) -> Iterator[Row]:
    """The lines of a noise: TheoBR and TheoH of simulated records."""
    noise = "".join(coefficients)
    model = al.Model(tuple(al.Term(symbol, value, SIGNALS[0]) for symbol, value in coefficients.items()))
    made = [al.simulate(model, SAMPLES, 1.0, rng=seeded(k, "hybrids", noise)) for k in range(records)]
    for name, m in FACTORS.items():
        curves = [al.deviation(record, name, m=m, noise=model, bias=bias) for record in made]
        curve, ratio = curves[0], np.array([c.variance for c in curves])
        ratio /= al.expected(model, "oadev", curve.tau)
        low, high = (limit**2 / curve.variance for limit in curve.interval(0.95))
        for j in np.flatnonzero(curve.edf >= FEWEST):
            v = ratio[:, j]
            simulated = 2 * v.mean() ** 2 / v.var(ddof=1)
            places = 1 * (v * high[j] < 1) - (v * low[j] > 1)
            head = (noise, str(bias), name, str(m[j]), f"{curve.edf[j]:.2f}")
            yield (*head, f"{curve.edf[j] / simulated:.2f}", f"{v.mean():.3f}", covered(places))


NAMES = {2: "WPM", 1: "FPM", 0: "WFM", -1: "FFM", -2: "RWFM", -3: "FWFM", -4: "RRFM"}
PURE = {2: al.Q(1.0, "rad"), 0: al.N(1.0, "rad/sqrt(s)"), -1: al.B(1.0, "rad/s"), -2: al.K(1.0, "rad/s^1.5")}

LAWS = (
    *product(("oadev",), (2, 0, -1, -2), (1,), (4097, 513, 129, 65, 33, 25, 17, 13)),
    *product(("oadev",), (1,), (8,), (4097, 513, 129, 65)),
    *product(("ohdev",), (0, -1, -2, -3, -4), (8,), (257, 129, 65, 33, 17)),
)
"""Statistic, exponent of the noise, averaging factor, and points of the angle there are every so many samples."""


def record_of(alpha: int, n: int, rng: np.random.Generator) -> al.Record:
    """Noise of the angle and of the rate as the package simulates it; steeper noise is its sum."""
    if alpha == 1:  # of density 1/f up to half the rate, cut from a series four times as long
        spectrum = np.fft.rfft(rng.standard_normal(4 * (n + 1)))
        spectrum[1:] /= np.sqrt(np.arange(1, spectrum.size))
        spectrum[0] = 0
        return al.Record(np.diff(np.fft.irfft(spectrum, 4 * (n + 1))[: n + 1]), 1.0, "rad/s", kind="rate")
    if alpha > -3:
        return al.simulate(PURE[alpha], n, 1.0, rng=rng)
    return al.Record(np.cumsum(al.simulate(PURE[alpha + 2], n, 1.0, rng=rng).values), 1.0, "rad/s", kind="rate")


def named(name: str, alpha: int, m: int, points: int, records: int) -> Row:
    """How often a power law is named exactly."""
    row, laws = STATISTICS[name], []
    for k in range(records):
        record = record_of(alpha, m * (points - 1), seeded(k, name, alpha, m, points))
        laws += identify_power_law(integrated(record, row.order), row, np.array([float(m)]))
    hit = 100 * np.mean([law.alpha == alpha for law in laws])
    methods = "/".join(sorted({law.method for law in laws}))
    return (name, NAMES[alpha], str(m), str(points), methods, f"{hit:.1f}")


OF_WINDOWS = ("statistic", "n", "factors", *KINDS, "expectation")
OF_HYBRIDS = (
    "noise", "bias", "statistic", "m", "edf", "edf / simulated", "mean / expected", "95 %",
)  # fmt: skip
OF_LAWS = ("row", "noise", "m", "points", "method", "found %")
WINDOWS_ARE = (
    "Largest error of the degrees of freedom, %, over the averaging factors from the first to the last; "
    f"n = {HOUR}: against windows of twice as many points."
)
LAWS_ARE = (
    "Found: the law is named exactly. Method: lag1, b1 (fewer than 30 points) and rn (noise of the angle at m > 3). "
    "WPM, FPM: white and flicker noise of the angle; WFM, FFM, RWFM: of the rate; FWFM, RRFM: flicker and random walk "
    "of the ramp, simulated as sums of FFM and RWFM."
)


def main() -> None:
    run = begin(__doc__ or "", sizes=[128, 256, 513], hybrids=600, laws=200)
    asked = run.asked
    exact = [against_matrices(*cell) for cell in product(WINDOWS, asked.sizes)]
    exact += map(against_finer_windows, WINDOWS)
    scatter = [line for noise, bias in HYBRIDS for line in hybrids(noise, bias, asked.hybrids)]
    laws = [named(*law, asked.laws) for law in LAWS]
    notes = [
        SEEDS,
        f"{asked.hybrids} records of {SAMPLES} samples of each hybrid: the simulated degrees of freedom are known to "
        f"{100 * (2 / asked.hybrids) ** 0.5:.0f} % where they are many, worse where they are few",
        f"{asked.laws} records of each power law: Monte-Carlo standard error at 50 %: {50 / asked.laws**0.5:.1f} %",
    ]
    body = section("Windows", OF_WINDOWS, exact, WINDOWS_ARE)
    body += section("TheoBR and TheoH", OF_HYBRIDS, scatter)
    body += section("Power law", OF_LAWS, laws, LAWS_ARE)
    run.publish("Moments of the statistics", notes, body)


if __name__ == "__main__":
    main()
