"""How often a comparison calls equal devices different, and how often it sees a change, against prediction.

    python benchmarks/comparison.py [--models N NK QNBK] [--pairs 2000] [--write PATH]

Pairs of records of one model are simulated with seeds 1, 2, 3, ... and compared as a user would compare them. A change
of a device in which all is larger by one factor needs no new records: ratio and models scale with it exactly. Ends with
exit code 1 if a share is out of bounds.
"""

import argparse
import math
import platform
import subprocess
import sys
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import numpy as np
from scipy.special import fdtr, fdtri

import allanite as al
from allanite.model import Model, Term
from allanite.noise.contrast import Contrast, chi_square, homogeneity
from allanite.noise.joint import joint
from allanite.noise.selection import select, subsets
from allanite.noise.whittle import likelihood, spectrum
from allanite.statistics.ratio import RatioLaw, ratio_law, shared_factors

SAMPLES, RATE = 4096, 100.0
MODELS = {
    "N": al.Model((al.N(0.3, "deg/sqrt(h)"),)),
    "NK": al.N(0.3, "deg/sqrt(h)") + al.K(200, "deg/h/sqrt(h)"),
    "QNBK": al.Q(2, "arcsec") + al.N(0.3, "deg/sqrt(h)") + al.B(20, "deg/h") + al.K(500, "deg/h/sqrt(h)"),
}
CHANGES = (0.0, 0.1, 0.2, 0.5)
"""Relative changes of the deviation."""

SMALL = (0.02, 0.05)
"""Relative changes of N, of which the likelihood sees less than the curve at its shortest time."""

FEWEST = 1.5
"""Degrees of freedom below which nothing is promised."""

SIZE = (3.5, 6.5)
"""Bounds of the share of equal pairs that are called different, percent, at a level of 5 %."""

NEAR = 3.0
"""Bound of the difference of measured and predicted power, percent."""


def pair_of(model: str, seed: int) -> tuple[al.Record, al.Record]:
    rng = np.random.default_rng(seed)
    one, two = (al.simulate(MODELS[model], SAMPLES, RATE, rng=rng, name=name) for name in "ab")
    return one, two


def fitted(record: al.Record) -> Model:
    """The model of ``identify(record, terms="QNBK")``, without the intervals."""
    seen = spectrum(record, detrend=False)
    theta = select(subsets(likelihood(seen, "QNBK"))).theta
    size = [seen.unit_factor * RATE ** -al.TERMS[s].power for s in "QNBK"]
    values = np.sqrt(theta) * size
    return Model(tuple(Term(s, float(v), record.signal) for s, v in zip("QNBK", values, strict=True) if v > 0))


def verdict(model: str, seed: int) -> dict[str, float]:
    """P of the verdict, the same by plain chi-square, and of each coefficient of the model."""
    both = joint(pair_of(model, seed), "QNBKR")
    test = homogeneity(both, np.random.default_rng(seed))
    found = {"verdict": test.p, "chi-square": chi_square(test.statistic, test.dof)}
    return found | {t.symbol: Contrast(both, both.symbols.index(t.symbol)).p for t in MODELS[model]}


def small(seed: int) -> list[float]:
    """P of the verdict for white noise that is a little larger in the second record."""
    one, two = pair_of("N", seed)
    found = []
    for change in SMALL:
        louder = al.Record(two.values * (1 + change), RATE, two.unit, name="b")
        found.append(homogeneity(joint([one, louder], "QNBKR"), np.random.default_rng(seed)).p)
    return found


def ratios(model: str, seed: int) -> np.ndarray:
    """P of the ratio of variances, shape (changes, taus)."""
    records = pair_of(model, seed)
    m = shared_factors(records, "oadev", "octave")
    law = ratio_law(records, "oadev", m, [fitted(record) for record in records])
    before, after = (
        al.deviation(record, "oadev", m=factors.tolist(), noise=None).variance
        for record, factors in zip(records, m, strict=True)
    )
    return np.array([law.p(after / before * (1 + change) ** 2) for change in CHANGES])


def predicted(law: RatioLaw, change: float) -> np.ndarray:
    """Power of the two-sided test, percent: the law of the ratio (F where the degrees of freedom are many), scaled."""
    size = (1 + change) ** 2
    low, high = law.quantile(0.025), law.quantile(0.975)
    return 100 * (law.below(low / size) + 1 - law.below(high / size))


def predicted_for_white(dof: float, change: float) -> float:
    """Power of the two-sided F test, percent: F scaled by the change."""
    size = (1 + change) ** 2
    low, high = fdtri(dof, dof, 0.025), fdtri(dof, dof, 0.975)
    return float(100 * (fdtr(dof, dof, low / size) + 1 - fdtr(dof, dof, high / size)))


def share(p: list[float]) -> float:
    return 100 * float(np.mean(np.array(p) <= 0.05))


def verdict_rows(model: str, pairs: int) -> Iterator[tuple[str, ...]]:
    found = [verdict(model, seed) for seed in range(1, pairs + 1)]
    for what in found[0]:
        yield model, what, f"{share([row[what] for row in found]):.2f}"


def small_rows(pairs: int) -> Iterator[tuple[str, ...]]:
    found = np.array([small(seed) for seed in range(1, pairs + 1)])
    # one coefficient of n - 1 powers, all alike
    for change, p in zip(SMALL, found.T, strict=True):
        power = predicted_for_white(SAMPLES - 1.0, change)
        yield "N", f"{100 * change:g}", f"{share(p):.1f}", f"{power:.1f}"


def ratio_rows(model: str, pairs: int) -> Iterator[tuple[str, ...]]:
    found = np.array([ratios(model, seed) <= 0.05 for seed in range(1, pairs + 1)])
    measured = 100 * found.mean(axis=0)
    record = pair_of(model, 1)[0]
    m = shared_factors([record, record], "oadev", "octave")
    law = ratio_law((record, record), "oadev", m, [MODELS[model]] * 2)
    edf, powers = law.edf[0], [predicted(law, change) for change in CHANGES]
    for j in np.flatnonzero(edf >= FEWEST):
        cells = [f"{measured[i, j]:.1f} / {powers[i][j]:.1f}" for i, change in enumerate(CHANGES) if change]
        yield model, f"{m[0][j] / RATE:g}", f"{edf[j]:.1f}", f"{measured[0, j]:.2f}", *cells


VERDICT = ("model", "test", "called different %")
SMALL_HEADINGS = ("model", "change of N %", "called different %", "predicted %")
RATIO = ("model", "tau, s", "edf", "size %", *(f"power at {100 * c:g} %, measured / predicted" for c in CHANGES if c))


def missed(rows: dict[str, list[tuple[str, ...]]]) -> list[str]:
    """What is out of bounds."""
    out = [f"{r[0]} {r[1]} {r[2]}" for r in rows["verdict"] if r[1] == "verdict" and not _within(r[2])]
    out += [f"{r[0]} tau {r[1]} size {r[3]}" for r in rows["ratio"] if not _within(r[3])]
    for row in rows["ratio"]:
        for cell in row[4:]:
            measured, prediction = map(float, cell.split(" / "))
            out += [f"{row[0]} tau {row[1]} power {cell}"] if abs(measured - prediction) > NEAR else []
    return out


def _within(cell: str) -> bool:
    return SIZE[0] <= float(cell) <= SIZE[1]


def table(headings: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    lines = ["| " + " | ".join(headings) + " |", "|" + "---|" * len(headings)]
    return [*lines, *("| " + " | ".join(row) + " |" for row in rows), ""]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", nargs="+", default=list(MODELS), choices=list(MODELS))
    parser.add_argument("--pairs", type=int, default=2000)
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    start = time.perf_counter()
    rows: dict[str, list[tuple[str, ...]]] = {"verdict": [], "small": list(small_rows(options.pairs)), "ratio": []}
    for model in options.models:
        rows["verdict"] += verdict_rows(model, options.pairs)
        rows["ratio"] += ratio_rows(model, options.pairs)
        print(f"{model} done, {time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False
    ).stdout.strip()
    out = missed(rows)
    error = 100 * math.sqrt(0.05 * 0.95 / options.pairs)
    lines = [
        "# Comparison of two records: size and power",
        "",
        f"- commit {commit}, {date.today()}, {platform.machine()}, Python {platform.python_version()}, "
        f"numpy {np.__version__}, {time.perf_counter() - start:.0f} s",
        f"- command: `python benchmarks/comparison.py --models {' '.join(options.models)} --pairs {options.pairs}`",
        f"- seeds 1..{options.pairs}; records of {SAMPLES} samples at {RATE:g} Hz; all five terms asked for; "
        f"level 5 %, standard error of a share of 5 %: {error:.2f} %",
        *(f"- {name}: {model}" for name, model in MODELS.items()),
        f"- out of bounds: {len(out)}" + (f" ({'; '.join(out)})" if out else ""),
        "",
        "## Equal devices",
        "",
        "verdict: the likelihood ratio with its law drawn, as printed; chi-square: the same likelihood ratio by "
        "chi-square; symbols: one coefficient by its profile, not adjusted. Bounds of the verdict: "
        f"{SIZE[0]} to {SIZE[1]} %.",
        "",
        *table(VERDICT, rows["verdict"]),
        "## A small change of white noise",
        "",
        f"The likelihood ratio of {options.pairs} pairs against an F test with {SAMPLES - 1} degrees of freedom "
        "each, the best there is if nothing but white noise could be there.",
        "",
        *table(SMALL_HEADINGS, rows["small"]),
        "## Ratio of variances by averaging time",
        "",
        "Overlapped Allan variance at octaves, the law under the model fitted to each record. Predicted: the law of "
        "the true model (an F with both degrees of freedom where these are many), scaled by the square of the change. "
        f"Bounds: size {SIZE[0]} to {SIZE[1]} %, power within {NEAR:g} points of the prediction; from {FEWEST} degrees "
        "of freedom on.",
        "",
        *table(RATIO, rows["ratio"]),
    ]
    text = "\n".join(lines)
    print(text)
    if options.write:
        options.write.write_text(text)
    sys.exit(1 if out else 0)


if __name__ == "__main__":
    main()
