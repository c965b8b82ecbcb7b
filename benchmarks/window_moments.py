"""The degrees of freedom of the statistics over windows and of the total deviation: how exact, how fast.

Errors are those of EDF against full matrices 2 tr(A G A G), with A as each definition writes it, for single terms,
halves of every pair, 200 random mixtures (seed 1, a ramp at most 0.9 of the variance) and three sensors; and, for an
hour at 1 kHz, against windows of twice as many points. Times are per averaging time, five terms at once.
"""

from table import begin, markdown

import time
from dataclasses import replace

import numpy as np
from tests.reference.dense import moments, quadratic_form

import allanite as al
from allanite.statistics import GRIDS
from allanite.statistics.moments import folded, windowed
from allanite.statistics.moments.compact import compact, mean_weights
from identification import RATE, SENSORS

ROWS = ["theo1", "mtotdev", "htotdev", "pdev", "totdev"]
SYMBOLS = "QNBKR"
TERMS = [al.terms.TERMS[s] for s in SYMBOLS]
HOUR, LONG = 3_600_000, 10**9


def mixtures() -> dict[str, np.ndarray]:
    """Shares of the expected variance, (k, 5), by kind."""
    pairs = [np.bincount([i, j], minlength=5) / 2 for i in range(5) for j in range(i + 1, 5)]
    random = np.random.default_rng(1).dirichlet(np.full(5, 0.5), 250)
    return {"single": np.eye(5)[:4], "pairs": np.array(pairs), "random": random[random[:, 4] < 0.9][:200]}


def sensors(E: np.ndarray, rates: tuple[float, ...] = (RATE, 0.1)) -> np.ndarray:
    """Shares in three sensors, sampled fast and slowly, so that short records show every term."""
    shares = []
    for model in SENSORS.values():
        for rate in rates:
            power = {t.symbol: t.value**2 * rate ** (2 * t.row.power - 2) for t in model}
            variance = np.array([power.get(s, 0.0) for s in SYMBOLS]) * E
            shares.append(variance / variance.sum())
    return np.array(shares)


def errors(ours: np.ndarray, exact: np.ndarray, E: np.ndarray) -> dict[str, float]:
    """Largest relative error of EDF by kind of mixture, per cent."""
    found = {}
    for kind, p in (mixtures() | {"sensors": sensors(E)}).items():
        shares = p * (E != 0)
        shares = shares[shares.sum(axis=1) > 0.05]
        inverse = [np.einsum("pi,ij,pj->p", shares, r, shares) for r in (ours, exact)]
        found[kind] = 100 * float(np.max(np.abs(inverse[1] / inverse[0] - 1)))
    return found


def relative(name: str, m: int, n: int) -> np.ndarray:
    row = al.statistics.STATISTICS[name]
    return windowed.relative(row, TERMS, m, int(row.count(n, np.array([m]))[0]), n)


def factors(name: str, n: int) -> list[int]:
    """About 40 averaging factors from the first to the last, odd ones too, and the last ones."""
    row = al.statistics.STATISTICS[name]
    largest = row.largest(n)
    grid = np.unique(np.rint(np.geomspace(1, largest, 60)).astype(int) // row.step * row.step)
    last = [largest - row.step * k for k in (1, 2, 5)]
    return sorted({int(m) for m in (*grid, *last) if m >= row.step})


def against_matrices(name: str, n: int) -> tuple[str, ...]:
    row, worst, expectation = al.statistics.STATISTICS[name], {}, 0.0
    for m in factors(name, n):
        E, r = moments(quadratic_form(row, m, n), TERMS)
        ours = windowed.response(row, TERMS, m, n)
        expectation = max(expectation, float(np.max(np.abs(ours[E != 0] / E[E != 0] - 1))))
        found = errors(relative(name, m, n), r, E)
        worst = {kind: max(value, worst.get(kind, 0.0)) for kind, value in found.items()}
    cells = [f"{worst[kind]:.2f}" for kind in ("single", "pairs", "random", "sensors")]
    return (name, str(n), f"{len(factors(name, n))}", *cells, f"{expectation:.0e}")


def against_finer_windows(name: str) -> tuple[str, ...]:
    """An hour at 1 kHz, octaves: windows of twice as many points, three times as many rows of the folded record."""
    row = al.statistics.STATISTICS[name]
    octaves = [int(m) for m in GRIDS["octave"](row.largest(HOUR)) if m > 1]
    ours = {m: relative(name, m, HOUR) for m in octaves}
    scheme, rows = row.scheme, folded.ROWS
    finer = replace(scheme, levels=tuple(2 * k for k in scheme.levels))
    if scheme.sharp is not None:
        finer = replace(finer, sharp=replace(scheme.sharp, levels=tuple(2 * k for k in scheme.sharp.levels)))
    al.statistics.STATISTICS[name] = replace(row, scheme=finer)
    folded.ROWS = 3 * rows
    worst: dict[str, float] = {}
    for m in octaves:
        E = windowed.response(row, TERMS, m, HOUR)
        found = errors(ours[m], relative(name, m, HOUR), E)
        worst = {kind: max(value, worst.get(kind, 0.0)) for kind, value in found.items()}
    folded.ROWS = rows
    al.statistics.STATISTICS[name] = row
    cells = [f"{worst[kind]:.2f}" for kind in ("single", "pairs", "random", "sensors")]
    return (name, str(HOUR), str(len(octaves)), *cells, "-")


def times(name: str, n: int) -> tuple[str, ...]:
    """Milliseconds per averaging time: response and relative of five terms."""
    row = al.statistics.STATISTICS[name]
    grid = [int(m) // row.step * row.step for m in GRIDS["log"](row.largest(n)) if m >= row.step]
    for cache in (compact, mean_weights):
        cache.cache_clear()
    rounds = []
    for _ in range(4):
        taken = []
        for m in grid:
            start = time.perf_counter()
            windowed.response(row, TERMS, m, n)
            relative(name, m, n)
            taken.append(1e3 * (time.perf_counter() - start))
        rounds.append(taken)
    best = np.min(rounds[1:], axis=0)
    return (name, str(n), str(len(grid)), f"{np.median(best):.1f}", f"{best.max():.1f}", f"{sum(rounds[0]) / 1e3:.2f}")


ERRORS = ("statistic", "n", "factors", "single", "pairs", "random", "sensors", "expectation")
TIMES = ("statistic", "n", "times", "median", "largest", "first")


def main() -> None:
    run = begin(__doc__, sizes=[128, 256, 513])
    exact = [against_matrices(name, n) for name in ROWS for n in run.asked.sizes]
    hour = [against_finer_windows(name) for name in ROWS]
    speed = [times(name, n) for name in ROWS for n in (HOUR, LONG)]
    notes = [
        "seed 1",
        "largest error of EDF, %, over the averaging factors from the first to the last; n = 3600000: against "
        "windows of twice as many points",
    ]
    told = "Time per averaging time, ms, expectation and ratios of five terms; first: a whole curve, nothing cached, s."
    body = [*markdown(ERRORS, exact + hour), told, "", *markdown(TIMES, speed)]
    run.publish("Degrees of freedom of the statistics over windows", notes, body)


if __name__ == "__main__":
    main()
