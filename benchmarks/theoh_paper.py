"""The claims of a paper on TheoH for optical gyros, measured on simulated records.

Tang, Cheng and Gao, Acta Armamentarii 36 (2015) 1688: two hours at 1 Hz, five noise terms.
"""

from table import SEEDS, Row, begin, covered, section, seeded, spread

import math

import numpy as np

import allanite as al
from allanite.planning.plan import properties

SIZE = 7200
FLAT = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h)"
TRUTHS = {
    "R 5": al.Model(f"{FLAT}, R 5 deg/h^2"), "R 1": al.Model(f"{FLAT}, R 1 deg/h^2"), "no R": al.Model(FLAT),
    "N and B": al.Model("N 0.02 deg/sqrt(h), B 0.3 deg/h"),
}  # fmt: skip
"""Stand-ins for the paper's fiber-optic gyro, whose record is not published."""

FOG = TRUTHS["R 5"]
UNITS = al.Model("Q 1 arcsec, N 1 deg/sqrt(h), B 1 deg/h, K 1 deg/h/sqrt(h), R 1 deg/h^2")

FITS = [
    ("ls", "oadev"), ("nnls", "oadev"), ("nnls", "theo1"), ("nnls", "theoh"), ("gls", "oadev"), ("gls", "theo1"),
    ("gls", "theoh"), ("whittle", None),
]  # fmt: skip
CLAIMS = ("gls", "whittle")  # methods that look for evidence of a term

CURVES = [("oadev", None), ("theoh", None), ("theoh", "model")]
"""Statistic, and what replaces its own bias ratio, whose whole curve is fitted as the paper does it."""

LIMITED = ("oadev", "theoh")  # statistics whose limits by gls are held against the truth

PROFILES = {
    "constant": np.ones_like,
    "three times in the second half": lambda t: np.where(t < 0.5, 1.0, 3.0),
    "three times in the middle": lambda t: 1 + 2 * np.exp(-(((t - 0.5) / 0.15) ** 2)),
}
"""Standard deviation of white noise over the record."""


def joint() -> list[Row]:
    """Expected TheoBR over the Allan deviation: at short times, and where TheoH consists of it."""
    rows = []
    for tau in (15, 30, 75, 150, 1500, 2700, 5400):
        pairs = [
            [al.expected(model, name, [float(tau)], rate=1.0, size=SIZE)[0] for name in ("theobr", "oadev")]
            for model in TRUTHS.values()
        ]
        rows.append((str(tau), *(f"{math.sqrt(theo / allan):.2f}" for theo, allan in pairs)))
    return rows


def fitted(job: tuple[str, int]) -> list[list[list[float]]]:
    """Relative errors by fit: of the coefficients of its model, and of those that it claims, the others 0."""
    record, errors = al.simulate(FOG, SIZE, 1.0, rng=seeded(job[-1], "fits")), []
    for method, statistic in FITS:
        fit = al.identify(record, method, terms="QNBKR", statistic=statistic)
        sizes = {t.symbol: abs(t.value) for t in fit.model}, {e.symbol: abs(e.value or 0.0) for e in fit}
        errors.append([[each.get(t.symbol, 0.0) / abs(t.value) - 1 for t in FOG] for each in sizes])
    return errors


def whole(job: tuple[str, int]) -> list[list[float]]:
    """Errors of the unweighted fits of whole curves of a record, in `UNITS`."""
    truth, number = job
    record, errors = al.simulate(TRUTHS[truth], SIZE, 1.0, rng=seeded(number, "curves", truth)), []
    for statistic, bias in CURVES:
        curve = al.deviation(record, statistic, taus="log", noise="identified" if bias else None, bias=bias)
        fit, true = (
            {t.symbol: abs(t.value) for t in model}
            for model in (al.identify(curve, "curve", terms="QNBKR").model, TRUTHS[truth])
        )
        errors.append([(fit.get(u.symbol, 0.0) - true.get(u.symbol, 0.0)) / u.value for u in UNITS])
    return errors


def whole_rows(truth: str, errors: list[list[list[float]]]) -> list[Row]:
    """Root mean square and mean errors by curve."""
    rows = []
    for (statistic, bias), each in zip(CURVES, np.array(errors).transpose(1, 2, 0), strict=True):
        sizes = (f"{math.sqrt((term**2).mean()):.2g} ({term.mean():+.2g})" for term in each)
        rows.append((truth, statistic, bias or ("own ratio" if statistic == "theoh" else "-"), *sizes))
    return rows


def held(job: tuple[str, int]) -> list[list[int]]:
    """Place of the truth by statistic and term, beside the limits of gls: -1 below, 0 within, 1 above."""
    record = al.simulate(FOG, SIZE, 1.0, rng=seeded(job[-1], "limits"))
    found = []
    for statistic in LIMITED:
        fit = al.identify(record, "gls", terms="QNBKR", statistic=statistic)
        ends = [(t.value, *fit[t.symbol].interval(0.95)) for t in FOG]
        found.append([-1 if value < low else int(value > high) for value, low, high in ends])
    return found


def varying(draws: int) -> list[Row]:
    """Mean Theo1 and Allan variances of white noise whose level changes, over that of its mean power."""
    rows, n = [], 1200
    t = (np.arange(n) + 0.5) / n
    for name, profile in PROFILES.items():
        rng, scale = seeded(0, "levels", name), profile(t)
        records = [al.Record(scale * rng.standard_normal(n), 1.0, "rad/s") for _ in range(draws)]
        for statistic, taus in (("oadev", (30.0, 300.0, 600.0)), ("theo1", (30.0, 300.0, 600.0, 900.0))):
            each = np.mean([al.deviation(r, statistic, taus=taus, noise=None).variance for r in records], axis=0)
            ratio = each * np.array(taus) / (scale**2).mean()
            rows.append((name, statistic, *(f"{x:.2f}" for x in ratio), *["-"] * (4 - len(taus))))
    return rows


def main() -> None:
    run = begin(__doc__ or "", records=60, curves=200, limits=240, draws=2000, processes=2)
    asked = run.asked
    ((_, fits),) = spread(fitted, [("fits",)], asked.records, asked.processes)
    ((_, places),) = spread(held, [("limits",)], asked.limits, asked.processes)
    curves = [
        row for (truth,), errors in spread(whole, zip(TRUTHS), asked.curves, asked.processes)
        for row in whole_rows(truth, errors)
    ]  # fmt: skip
    symbols, coefficients = [t.symbol for t in FOG], []
    for (method, statistic), (model, claimed) in zip(FITS, np.sqrt(np.square(fits).mean(axis=0)), strict=True):
        absent = [f"{x:.2f}" if method in CLAIMS else "-" for x in claimed[-2:]]
        coefficients.append((method, statistic or "-", *(f"{x:.2f}" for x in model), *absent))
    windows = [("formula of the paper, 1/sqrt(2 (k - 1))", f"{100 / math.sqrt(2 * 71):.2f}")]
    known = {name: properties(name, SIZE, m=[100]) for name in ("adev", "oadev")}  # of white noise: 1 / sqrt(2 edf)
    windows += [(name, f"{100 / math.sqrt(2 * p.edf[0, p.symbols.index('N')]):.2f}") for name, p in known.items()]
    notes = [
        f"{SEEDS}; records: {asked.records} for fits, {asked.curves} for those of whole curves, "
        f"{asked.limits} for limits",
        f"{SIZE} samples at 1 Hz of " + "; ".join(f"{name}: {model}" for name, model in TRUTHS.items()),
        f"Monte-Carlo standard error: {100 / math.sqrt(2 * asked.records):.0f} % of an rmse, "
        f"{100 / math.sqrt(2 * asked.curves):.0f} % of one of whole curves, "
        f"{100 * math.sqrt(0.05 * 0.95 / asked.limits):.1f} % of a coverage of 95 %",
    ]
    sections = (
        ("Error of the Allan deviation, 72 windows of 100 s, percent", ("", "exact"), windows),
        ("Expected TheoBR over the Allan deviation; from 1500 s on it is TheoH", ("tau, s", *TRUTHS), joint()),
        ("Coefficients: rmse over the truth",
         ("method", "statistic", *symbols, *(f"{s}, 0 if not claimed" for s in symbols[-2:])), coefficients),
        ("Unweighted fit of the whole curve (method curve): rms error (mean error)",
         ("truth", "statistic", "bias removed by", "Q, arcsec", "N, deg/√h", "B, deg/h", "K, deg/h/√h", "R, deg/h²"),
         curves),
        ("95 % limits of gls, percent of records in which they hold the truth (+ truth above them, - below)",
         ("statistic", *symbols),
         [(name, *map(covered, row)) for name, row in zip(LIMITED, np.array(places).transpose(1, 2, 0), strict=True)]),
        ("Noise that changes its level: variance times tau over the mean power",
         ("level", "statistic", "30 s", "300 s", "600 s", "900 s"), varying(asked.draws // 10)),
    )  # fmt: skip
    run.publish("TheoH for optical gyros", notes, [line for part in sections for line in section(*part)])


if __name__ == "__main__":
    main()
