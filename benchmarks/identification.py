"""How good is the identification: coverage, width, false and missed terms against the Cramer-Rao bound.

Records of three sensors are simulated with seeds 1, 2, 3, ... and identified twice: "auto" as a user would, who does
not know which terms there are (Gauss-Markov noise and sinusoids are looked for too), and "known" with the true terms
asked for and no others. The bound is that of the coefficients with the true terms known (and the ramp unknown where
there is one).
"""

from table import begin, markdown

import itertools
import math
import sys
from dataclasses import dataclass
from multiprocessing import Pool

import numpy as np

import allanite as al

RATE = 100.0
SENSORS = {name.upper(): al.sensor(name) for name in al.planning.SENSORS}
LONG, FEW = 2**18, 300  # samples above which there are at most so many records

HEADINGS = (
    "terms", "sensor", "n", "term", "bound %", "claimed %", "identified %", "cover %", "profile %", "width", "rmse",
    "rmse of square", "bias",
)  # fmt: skip


def bounds(model: al.Model, n: int) -> dict[str, float]:
    """Relative Cramer-Rao bounds of the coefficients."""
    found = al.bound(model, n, RATE)
    return dict(zip(found.names, found.errors.tolist(), strict=True))


@dataclass(frozen=True)
class Job:
    """One record."""

    terms: str
    sensor: str
    n: int
    seed: int


def asked(terms: str, sensor: str) -> str:
    """What is asked of `identify`."""
    return "auto" if terms == "auto" else "".join(t.symbol for t in SENSORS[sensor])


def identified(job: Job) -> list[tuple[str, float, float, float, float, float]]:
    """(status, value, low, high, profile low, profile high) of the terms asked for; "auto" asks for Q, N, B, K, R."""
    record = al.simulate(SENSORS[job.sensor], job.n, RATE, rng=np.random.default_rng(job.seed))
    fit = al.identify(record, terms=asked(job.terms, job.sensor))
    rows = []
    for e in (fit[s] for s in symbols(job.terms, job.sensor)):
        low, high = e.interval(0.95)
        value = sum(t.value for t in fit.model if t.symbol == e.symbol)
        rows.append((e.status, value, low, high, *(e.profile(0.95) if e.profile else (low, high))))
    return rows


def symbols(terms: str, sensor: str) -> str:
    """The terms that are looked at."""
    return "QNBKR" if terms == "auto" else asked(terms, sensor)


def table(sensors: list[str], sizes: list[int], records: int, first: int) -> list[tuple[str, ...]]:
    """Rows of the table, one a sensor, length and term."""
    rows = []
    with Pool() as pool:
        for terms, n, sensor in itertools.product(("auto", "known"), sizes, sensors):
            number = records if n <= LONG else min(records, FEW)
            jobs = [Job(terms, sensor, n, seed) for seed in range(first, first + number)]
            found = pool.map(identified, jobs, chunksize=5)
            rows += [
                summary(jobs[0], symbol, [record[i] for record in found])
                for i, symbol in enumerate(symbols(terms, sensor))
            ]
            print(f"{terms} {sensor} {n} done", file=sys.stderr, flush=True)
    return rows


def summary(job: Job, symbol: str, found: list[tuple]) -> tuple[str, ...]:
    sensor, n = job.sensor, job.n
    present = {t.symbol: t.value for t in SENSORS[sensor]}
    truth = present.get(symbol, 0.0)
    bound = bounds(SENSORS[sensor], n).get(symbol, math.nan)
    status = np.array([row[0] for row in found])
    value, low, high, profile_low, profile_high = np.array([row[1:] for row in found], dtype=float).T
    claimed = np.isin(status, ("identified", "weak")).mean()
    cells = [job.terms, sensor, str(n), symbol + ("" if symbol in present else " (absent)")]
    cells += [f"{100 * bound:.2f}" if symbol in present else "-", f"{100 * claimed:.1f}"]
    cells += [f"{100 * (status == 'identified').mean():.1f}"]
    cells += [f"{100 * ((low <= truth) & (truth <= high)).mean():.1f}"]
    cells += [f"{100 * ((profile_low <= truth) & (truth <= profile_high)).mean():.1f}"]
    if symbol not in present:
        return (*cells, "-", "-", "-", "-")
    relative = value / truth - 1
    cells += [f"{np.median(high - low) / truth / 3.92 / bound:.3f}"]
    of_square = ((1 + relative) ** 2 - 1) / 2
    cells += [f"{np.sqrt((error**2).mean()) / bound:.2f}" for error in (relative, of_square)]
    return (*cells, f"{relative.mean() / bound:+.2f}")


def main() -> None:
    run = begin(__doc__, sensors=list(SENSORS), sizes=[2**16, 2**18], records=400, first=1)
    asked = run.asked
    rows = table(asked.sensors, asked.sizes, asked.records, asked.first)
    notes = [
        f"seeds {asked.first}..{asked.first + asked.records - 1}, above {LONG} samples at most {FEW}; 100 Hz; "
        f"Monte-Carlo standard error of a coverage of 95 %: {100 * math.sqrt(0.05 * 0.95 / asked.records):.1f} %",
        "cover: the interval as printed holds the truth (from 0 to the one-sided limit for a term not found); "
        "profile: the two-sided profile interval does; width: median width over 3.92 bounds; rmse, bias: of the "
        "coefficient in the model, over the bound; rmse of square: half that of its square, which has no bend at zero.",
    ]
    run.publish("Identification against the Cramer-Rao bound", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    main()
