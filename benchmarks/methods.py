"""How good is each method: error, bias and coverage against the Cramer-Rao bound, on the same records.

Each method is asked for the true terms and no others, and the likelihood reads all frequencies: a record in a hundred
fails the test by chance, and would be read in a band. A term that a method does not find counts as 0, or as what its
model has of it. The bound is checked against full matrices: a referee makes the covariance of the differences of the
rates, and the information tr(P C_i P C_j) / 2 from it.
"""

from table import SEEDS, Row, begin, section, seeded, spread

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.linalg import cho_factor, cho_solve, toeplitz

import allanite as al

RATE = 100.0
SENSORS = {name.upper(): al.sensor(name) for name in al.planning.SENSORS}

WAYS: dict[str, dict[str, tuple[str, str | None]]] = {
    "Each method": {name: (name, None) for name in al.identification.METHODS}
    | {f"gls of {s}": ("gls", s) for s in ("ohdev", "mdev")},
    "Curves of other statistics": {
        f"gls of {s}": ("gls", s) for s in ("oadev", "theo1", "theobr", "theoh", "pdev", "mtotdev", "htotdev")
    },
}
"""Method and statistic by the name in the table, of each section."""

Found = dict[str, list[tuple[float, float, float]]]

HEADINGS = ("sensor", "n", "term", "bound %", "method", "rmse", "bias", "cover %")

MODELS = {
    **al.planning.SENSORS,
    "N B K": "N 1 rad/sqrt(s), B 0.3 rad/s, K 0.1 rad/s^1.5",
    "Q N": "Q 1 rad, N 0.1 rad/sqrt(s)",
    "Q K": "Q 1 rad, K 0.01 rad/s^1.5",
    "N GM K": "N 1 rad/sqrt(s), GM 1 rad/s 5 s, K 0.01 rad/s^1.5",
}
"""Of the check of the bound."""

BOUND_HEADINGS = ("model", "rate, Hz", "ramp", "parameter", "full matrices, %", "bound, %", "ratio")


def identified(job: tuple[str, str, int, int]) -> Found:
    """(value, low, high) of every term, by way."""
    title, sensor, n, number = job
    record, every = al.simulate(SENSORS[sensor], n, RATE, rng=seeded(number, "methods", sensor, n)), {}
    terms = "".join(t.symbol for t in SENSORS[sensor])
    for way, (method, statistic) in WAYS[title].items():
        band = "all" if "band" in al.identification.METHODS[method].options else None
        fit = al.identify(record, method, terms=terms, statistic=statistic, band=band)
        model = {t.symbol: t.value for t in fit.model}
        every[way] = [(model.get(e.symbol, 0.0) if e.value is None else e.value, *e.interval(0.95)) for e in fit]
    return every


def rows_of(sensor: str, n: int, records: list[Found]) -> list[Row]:
    """Rows of the table, one a term and way."""
    limit = al.bound(SENSORS[sensor], n, RATE)
    bounds = dict(zip(limit.names, limit.errors.tolist(), strict=True))
    rows = []
    for (i, term), way in product(enumerate(SENSORS[sensor]), records[0]):
        value, low, high = np.array([record[way][i] for record in records]).T
        relative, bound = value / term.value - 1, bounds[term.symbol]
        covered = f"{100 * ((low <= term.value) & (term.value <= high)).mean():.0f}" if np.isfinite(low[0]) else "-"
        rmse, bias = np.sqrt((relative**2).mean()) / bound, relative.mean() / bound
        rows.append((sensor, str(n), term.symbol, f"{100 * bound:.2f}", way, f"{rmse:.2f}", f"{bias:+.2f}", covered))
    return rows


def dense(model: al.Model, n: int, rate: float, ramp: bool) -> tuple[np.ndarray, float]:
    """Relative errors of coefficients and time constants, and the standard error of the ramp, from full matrices."""

    def covariance(t: al.Term) -> np.ndarray:
        return t.power(rate) * toeplitz(t.sampled(rate).increments(np.arange(n - 1.0)))

    parts, noise = [], [t for t in model if t.row.waveform is None]
    for t in noise:
        parts.append(covariance(t))
        for T in t.shape:
            up, down = (covariance(al.Term(t.symbol, t.value, t.signal, (T * f,))) for f in (1.001, 1 / 1.001))
            parts.append((up - down) / (4 * math.log(1.001)))
    C = sum(covariance(t) for t in noise)
    scale = C.max()
    factor, ones = cho_factor(C / scale), np.ones(n - 1)
    solved, u = [cho_solve(factor, part / scale) for part in parts], cho_solve(factor, ones)
    if ramp:
        solved = [W - np.outer(u, ones @ W) / (ones @ u) for W in solved]
    F = np.array([[np.sum(A * B.T) / 2 for B in solved] for A in solved])
    return np.sqrt(np.diag(np.linalg.inv(F))) / 2, math.sqrt(scale / (ones @ u)) * rate


def bound_rows(n: int) -> Iterator[Row]:
    """The bound beside full matrices; a ramp's error is shown for one of 1e-6 rad/s^2."""
    for name, model in MODELS.items():
        noise = al.Model(tuple(t for t in al.Model(model) if t.row.waveform is None))
        for rate, ramp in product((1.0, RATE) if name in al.planning.SENSORS else (1.0,), (False, True)):
            errors, slope = dense(noise, n, rate, ramp)
            bound = al.bound(noise, n, rate, ramp=ramp)
            rows = list(zip(bound.names, errors, bound.errors, strict=True))
            rows += [("R", slope / 1e-6, bound.ramp / 1e-6)] if ramp else []
            for parameter, a, b in rows:
                cells = f"{100 * a:.4g}", f"{100 * b:.4g}", f"{b / a:.4f}"
                yield name, f"{rate:g}", "unknown" if ramp else "none", parameter, *cells


def main() -> None:
    sizes = [2**16, 2**18]
    run = begin(__doc__ or "", sensors=list(SENSORS), sizes=sizes, records=100, curves=40, readings=2048, processes=2)
    asked, body = run.asked, []
    for title, lengths, records in zip(
        WAYS, (asked.sizes, asked.sizes[:1]), (asked.records, asked.curves), strict=True
    ):
        rows: list[Row] = []
        for cell, answers in spread(identified, product([title], asked.sensors, lengths), records, asked.processes):
            rows += rows_of(*cell[1:], answers)
        body += section(title, HEADINGS, rows, f"{records} records a cell.")
    bounds = list(bound_rows(asked.readings))
    notes = [
        f"{SEEDS}; the same records for every method; 100 Hz; the true terms are known",
        "rmse, bias: of the coefficient, over the bound; cover: the 95 % interval as printed holds the truth (from 0 "
        "to the one-sided limit for a term not found), - for a method without intervals",
        f"standard error with {asked.records} records: {100 / math.sqrt(2 * asked.records):.0f} % of an rmse, "
        f"{100 * math.sqrt(0.05 * 0.95 / asked.records):.0f} % of a coverage",
    ]
    off = max(abs(float(row[-1]) - 1) for row in bounds)
    about = f"{asked.readings} readings; standard errors (1 sigma), %. Largest deviation of a ratio from 1: {off:.4f}."
    body += section("The bound against full matrices", BOUND_HEADINGS, bounds, about)
    run.publish("Methods of identification against the Cramer-Rao bound", notes, body)


if __name__ == "__main__":
    main()
