"""How good is each method: error, bias and coverage against the Cramer-Rao bound, on the same records.

The records of benchmarks/identification.py, seeds 1, 2, 3, ...; each method is asked for the true terms and no others,
and the likelihood reads all frequencies: a record in a hundred fails the test by chance, and would be read in a band.
A term that a method does not find counts as 0, or as what its model has of it. With --ways curves it is generalized
least squares of the curve of each statistic, and every cell has seeds of its own.
"""

from table import Row, begin, markdown

import itertools
import math
import sys
from functools import partial
from multiprocessing import Pool

import numpy as np

import allanite as al
from identification import RATE, SENSORS, Job, asked, bounds

WAYS: dict[str, dict[str, tuple[str, str | None]]] = {
    "methods": {name: (name, None) for name in al.identification.METHODS}
    | {f"gls of {s}": ("gls", s) for s in ("ohdev", "mdev")},
    "curves": {f"gls of {s}": ("gls", s) for s in ("oadev", "theo1", "theobr", "theoh", "pdev", "mtotdev", "htotdev")},
}
"""Method and statistic by the name in the table, of both tables."""

TITLES = {
    "methods": "Methods of identification against the Cramer-Rao bound",
    "curves": "Generalized least squares of the curve of each statistic",
}

HEADINGS = ("sensor", "n", "term", "bound %", "method", "rmse", "bias", "cover %")

Found = dict[str, list[tuple[float, float, float]]]


def identified(job: Job, ways: str = "methods") -> Found:
    """(value, low, high) of every term, by way."""
    own = [list(SENSORS).index(job.sensor), job.n] if ways == "curves" else []
    record = al.simulate(SENSORS[job.sensor], job.n, RATE, rng=np.random.default_rng([*own, job.seed]))
    found = {}
    for way, (method, statistic) in WAYS[ways].items():
        band = "all" if "band" in al.identification.METHODS[method].options else None
        fit = al.identify(record, method, terms=asked("known", job.sensor), statistic=statistic, band=band)
        model = {t.symbol: t.value for t in fit.model}
        found[way] = [(model.get(e.symbol, 0.0) if e.value is None else e.value, *e.interval(0.95)) for e in fit]
    return found


def rows_of(sensor: str, n: int, records: list[Found]) -> list[Row]:
    """Rows of the table, one a term and way."""
    limits = bounds(SENSORS[sensor], n)
    rows = []
    for (i, term), way in itertools.product(enumerate(SENSORS[sensor]), records[0]):
        value, low, high = np.array([record[way][i] for record in records]).T
        relative, bound = value / term.value - 1, limits[term.symbol]
        covered = f"{100 * ((low <= term.value) & (term.value <= high)).mean():.0f}" if np.isfinite(low[0]) else "-"
        rmse, bias = np.sqrt((relative**2).mean()) / bound, relative.mean() / bound
        rows.append((sensor, str(n), term.symbol, f"{100 * bound:.2f}", way, f"{rmse:.2f}", f"{bias:+.2f}", covered))
    return rows


def table(sensors: list[str], sizes: list[int], seeds: range, ways: str) -> list[Row]:
    """All rows."""
    rows = []
    with Pool() as pool:
        for n, sensor in itertools.product(sizes, sensors):
            jobs = [Job("known", sensor, n, seed) for seed in seeds]
            rows += rows_of(sensor, n, pool.map(partial(identified, ways=ways), jobs, chunksize=2))
            print(f"{sensor} {n} done", file=sys.stderr, flush=True)
    return rows


def main() -> None:
    run = begin(__doc__, sensors=list(SENSORS), sizes=[2**16, 2**18], records=100, ways="methods")
    asked = run.asked
    rows = table(asked.sensors, asked.sizes, range(1, asked.records + 1), asked.ways)
    cell = ", of each cell its own" if asked.ways == "curves" else ""
    notes = [
        f"seeds 1..{asked.records}, the same records for every method{cell}; 100 Hz; the true terms are known",
        "rmse, bias: of the coefficient, over the bound; cover: the 95 % interval as printed holds the truth (from 0 "
        "to the one-sided limit for a term not found), - for a method without intervals. Monte-Carlo standard error: "
        f"{100 / math.sqrt(2 * asked.records):.0f} % of an rmse, "
        f"{100 * math.sqrt(0.05 * 0.95 / asked.records):.0f} % of a coverage of 95 %.",
    ]
    run.publish(TITLES[asked.ways], notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    main()
