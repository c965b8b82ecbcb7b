"""How often a comparison calls equal devices different, and how often it sees a change, against prediction.

Pairs of records of one model are simulated with seeds 1, 2, 3, ... and compared as `compare` does; where a device has
changed, the second record of each pair is louder by a factor. Ends with exit code 1 if a share is out of bounds.
"""

from table import begin, section

import math
import sys
from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing import Pool
from typing import Any

import numpy as np
from scipy.special import fdtr, fdtri

import allanite as al
from allanite.comparison.change import holm
from allanite.comparison.common_likelihood import Joint, joint
from allanite.comparison.contrast import Contrast, chi_square, homogeneity, partly_common
from allanite.comparison.ratio import RatioLaw, ratio_law
from allanite.core.model import Model

SAMPLES, RATE = 4096, 100.0
MODELS = {
    "N": al.Model((al.N(0.3, "deg/sqrt(h)"),)),
    "NK": al.N(0.3, "deg/sqrt(h)") + al.K(200, "deg/h/sqrt(h)"),
    "QNBK": al.Q(2, "arcsec") + al.N(0.3, "deg/sqrt(h)") + al.B(20, "deg/h") + al.K(500, "deg/h/sqrt(h)"),
}
FACTORS = 4 ** np.arange(6)  # averaging factors
CHANGES = (0.0, 0.1, 0.2, 0.5)  # relative changes of the deviation
SMALL = (0.02, 0.05)  # relative changes of N, of which the likelihood sees less than the curve at its shortest time
FEWEST = 1.5  # degrees of freedom below which nothing is promised
SIZE = (3.5, 6.5)  # bounds of the share of equal pairs that are called different, percent, at a level of 5 %
NEAR = 3.0  # bound of the difference of measured and predicted power, percent


def pair_of(model: str, seed: int) -> tuple[al.Record, al.Record]:
    rng = np.random.default_rng(seed)
    one, two = (al.simulate(MODELS[model], SAMPLES, RATE, rng=rng, name=name) for name in "ab")
    return one, two


def supposed(both: Joint) -> list[Model]:
    """The models under which `compare` takes the law of the ratio."""
    p = holm([Contrast(both, i).p for i in range(len(both.symbols))])
    apart = [symbol for symbol, adjusted in zip(both.symbols, p, strict=True) if adjusted <= 0.05]
    found = partly_common(both, apart)
    return [Model(tuple(both.term(s, v) for s, v in values.items() if v > 0)) for values in found]


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
    m = [FACTORS, FACTORS]
    before, after = (
        al.deviation(record, "oadev", m=factors.tolist(), noise=None).variance
        for record, factors in zip(records, m, strict=True)
    )
    found = []
    for change in CHANGES:
        changed = records[0], al.Record(records[1].values * (1 + change), RATE, records[1].unit, name="b")
        law = ratio_law(changed, "oadev", m, supposed(joint(changed, "QNBKR")))
        found.append(law.p(after / before * (1 + change) ** 2))
    return np.array(found)


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


def verdict_rows(model: str, pairs: int, processes: int = 1) -> Iterator[tuple[str, ...]]:
    found = made(partial(verdict, model), pairs, processes)
    for what in found[0]:
        yield model, what, f"{share([row[what] for row in found]):.2f}"


def small_rows(pairs: int, processes: int = 1) -> Iterator[tuple[str, ...]]:
    found = np.array(made(small, pairs, processes))
    # one coefficient of n - 1 powers, all alike
    for change, p in zip(SMALL, found.T, strict=True):
        power = predicted_for_white(SAMPLES - 1.0, change)
        yield "N", f"{100 * change:g}", f"{share(p):.1f}", f"{power:.1f}"


def ratio_rows(model: str, pairs: int, processes: int = 1) -> Iterator[tuple[str, ...]]:
    found = np.array(made(partial(ratios, model), pairs, processes)) <= 0.05
    measured = 100 * found.mean(axis=0)
    record = pair_of(model, 1)[0]
    law = ratio_law((record, record), "oadev", [FACTORS, FACTORS], [MODELS[model]] * 2)
    edf, powers = law.edf[0], [predicted(law, change) for change in CHANGES]
    for j in np.flatnonzero(edf >= FEWEST):
        cells = [f"{measured[i, j]:.1f} / {powers[i][j]:.1f}" for i, change in enumerate(CHANGES) if change]
        yield model, f"{FACTORS[j] / RATE:g}", f"{edf[j]:.1f}", f"{measured[0, j]:.2f}", *cells


def made(one: Callable[[int], Any], pairs: int, processes: int) -> list[Any]:
    """Of the pairs 1, 2, 3, ..."""
    seeds = range(1, pairs + 1)
    if processes == 1:
        return [one(seed) for seed in seeds]
    with Pool(processes) as pool:
        return pool.map(one, seeds, chunksize=20)


VERDICT = ("model", "test", "called different %")
SMALL_HEADINGS = ("model", "change of N %", "called different %", "predicted %")
RATIO = ("model", "tau, s", "edf", "size %", *(f"power at {100 * c:g} %, measured / predicted" for c in CHANGES if c))


def missed_verdicts(rows: list[tuple[str, ...]]) -> list[str]:
    """What is out of bounds."""
    return [f"{r[0]} {r[1]} {r[2]}" for r in rows if r[1] == "verdict" and not _within(r[2])]


def missed_ratios(rows: list[tuple[str, ...]]) -> list[str]:
    """What is out of bounds."""
    out = [f"{r[0]} tau {r[1]} size {r[3]}" for r in rows if not _within(r[3])]
    for row in rows:
        for cell in row[4:]:
            measured, prediction = map(float, cell.split(" / "))
            out += [f"{row[0]} tau {row[1]} power {cell}"] if abs(measured - prediction) > NEAR else []
    return out


def _within(cell: str) -> bool:
    return SIZE[0] <= float(cell) <= SIZE[1]


def verdict_part(models: list[str], pairs: int, processes: int) -> tuple[list[str], list[str]]:
    """Text, and what is out of bounds."""
    rows = [row for model in models for row in verdict_rows(model, pairs, processes)]
    about = (
        "verdict: the likelihood ratio with its law drawn, as printed; chi-square: the same likelihood ratio by "
        "chi-square; symbols: one coefficient by its profile, not adjusted. Bounds of the verdict: "
        f"{SIZE[0]} to {SIZE[1]} %."
    )
    about_small = (
        f"The likelihood ratio of {pairs} pairs against an F test with {SAMPLES - 1} degrees of freedom each, the best "
        "there is if nothing but white noise could be there."
    )
    small = list(small_rows(pairs, processes))
    text = section("Equal devices", VERDICT, rows, about)
    return text + section("A small change of white noise", SMALL_HEADINGS, small, about_small), missed_verdicts(rows)


def ratio_part(models: list[str], pairs: int, processes: int) -> tuple[list[str], list[str]]:
    """Text, and what is out of bounds."""
    rows = [row for model in models for row in ratio_rows(model, pairs, processes)]
    about = (
        "Overlapped Allan variance, the law under what is supposed of each pair. Predicted: the law of the true model "
        "(an F with both degrees of freedom where these are many), scaled by the square of the change. "
        f"Bounds: size {SIZE[0]} to {SIZE[1]} %, power within {NEAR:g} points of the prediction; from {FEWEST} degrees "
        "of freedom on."
    )
    return section("Ratio of variances by averaging time", RATIO, rows, about), missed_ratios(rows)


PARTS = {"verdict": verdict_part, "ratio": ratio_part}


def main() -> None:
    run = begin(__doc__, part=tuple(PARTS), models=list(MODELS), pairs=2000, processes=1)
    pairs = run.asked.pairs
    body, out = PARTS[run.asked.part](run.asked.models, pairs, run.asked.processes)
    notes = [
        f"seeds 1..{pairs}; records of {SAMPLES} samples at {RATE:g} Hz; all five terms asked for; "
        f"level 5 %, standard error of a share of 5 %: {100 * math.sqrt(0.05 * 0.95 / pairs):.2f} %",
        *(f"{name}: {model}" for name, model in MODELS.items()),
        f"out of bounds: {len(out)}" + (f" ({'; '.join(out)})" if out else ""),
    ]
    run.publish(f"Comparison of two records: {run.asked.part}", notes, body)
    sys.exit(1 if out else 0)


if __name__ == "__main__":
    main()
