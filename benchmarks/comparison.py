"""How often a comparison calls equal devices different, and how often it finds a change, against prediction.

Pairs of records of one model come from the independent simulator and are compared as `compare` does. Where a device has
changed, the second record of a pair is louder by a factor.
"""

from table import SEEDS, begin, coefficients, section, seeded, spread

import numpy as np

import allanite as al
from allanite.comparison.change import holm
from allanite.comparison.common_likelihood import Joint, joint
from allanite.comparison.contrast import Contrast, homogeneity, partly_common
from allanite.comparison.ratio import RatioLaw, ratio_law
from judge import sensor

SAMPLES, RATE = 4096, 100.0
MODELS = {
    "N": al.Model("N 0.3 deg/sqrt(h)"),
    "NK": al.Model("N 0.3 deg/sqrt(h), K 200 deg/h/sqrt(h)"),
    "QNBK": al.Model("Q 2 arcsec, N 0.3 deg/sqrt(h), B 20 deg/h, K 500 deg/h/sqrt(h)"),
}
FACTORS = 4 ** np.arange(6)  # averaging factors
CHANGES = (0.0, 0.1, 0.2, 0.5)  # relative changes of the deviation
RATIOS = [("NK",), ("QNBK",)]
FEWEST = 1.5  # degrees of freedom below which nothing is promised


def pair_of(rng: np.random.Generator, model: str, change: float = 0.0) -> list[al.Record]:
    """Two records of a model, the second louder by a relative change."""
    made = [sensor(SAMPLES, RATE, rng, **coefficients(MODELS[model])) for _ in range(2)]
    return [al.Record(y, RATE, "rad/s", name=name) for y, name in ((made[0], "a"), (made[1] * (1 + change), "b"))]


def verdict(job: tuple[str, int]) -> dict[str, float]:
    """P of the verdict, and of each coefficient of the model."""
    model, number = job
    rng = seeded(number, "verdict", model)
    both = joint(pair_of(rng, model), "QNBKR")
    return {"verdict": homogeneity(both, rng).p} | {
        t.symbol: Contrast(both, both.symbols.index(t.symbol)).p for t in MODELS[model]
    }


def supposed(both: Joint) -> list[al.Model]:
    """The models under which `compare` takes the law of the ratio."""
    p = holm([Contrast(both, i).p for i in range(len(both.symbols))])
    apart = [symbol for symbol, adjusted in zip(both.symbols, p, strict=True) if adjusted <= 0.05]
    return [
        al.Model(tuple(both.term(s, v) for s, v in values.items() if v > 0)) for values in partly_common(both, apart)
    ]


def ratios(job: tuple[str, int]) -> list[np.ndarray]:
    """P of the ratio of variances at each averaging time, for each change."""
    model, number = job
    found = []
    for pair in (pair_of(seeded(number, "ratio", model), model, change) for change in CHANGES):
        before, after = (al.deviation(record, "oadev", m=FACTORS.tolist(), noise=None).variance for record in pair)
        law = ratio_law(pair, "oadev", [FACTORS, FACTORS], supposed(joint(pair, "QNBKR")))
        found.append(law.p(after / before))
    return found


def predicted(law: RatioLaw, change: float) -> np.ndarray:
    """Power of the two-sided test, percent: the law of the ratio (F where the degrees of freedom are many), scaled."""
    size = (1 + change) ** 2
    low, high = law.quantile(0.025), law.quantile(0.975)
    return 100 * (law.below(low / size) + 1 - law.below(high / size))


def ratio_rows(model: str, found: list[list[np.ndarray]]) -> list[tuple[str, ...]]:
    """A line for each averaging time of a model."""
    measured = 100 * np.mean(np.array(found) <= 0.05, axis=0)
    pair = pair_of(seeded(0, "ratio", model), model)
    law = ratio_law(pair, "oadev", [FACTORS, FACTORS], [MODELS[model]] * 2)
    powers, rows = [predicted(law, change) for change in CHANGES], []
    for j in np.flatnonzero(law.edf[0] >= FEWEST):
        cells = [f"{measured[i, j]:.1f} / {powers[i][j]:.1f}" for i, change in enumerate(CHANGES) if change]
        rows.append((model, f"{FACTORS[j] / RATE:g}", f"{law.edf[0][j]:.1f}", f"{measured[0, j]:.2f}", *cells))
    return rows


VERDICT = ("model", "test", "called different %")
RATIO = ("model", "tau, s", "edf", "size %", *(f"power at {100 * c:g} %, measured / predicted" for c in CHANGES if c))


def main() -> None:
    run = begin(__doc__, pairs=2000)
    pairs, models = run.asked.pairs, [(model,) for model in MODELS]
    equal = [
        (model, name, f"{100 * np.mean([p[name] <= 0.05 for p in found]):.2f}")
        for (model,), found in spread(verdict, models, pairs)
        for name in found[0]
    ]
    rows = [row for (model,), found in spread(ratios, RATIOS, pairs) for row in ratio_rows(model, found)]
    notes = [
        f"{SEEDS}; records of {SAMPLES} samples at {RATE:g} Hz, {pairs} pairs a cell; all five terms asked for; "
        f"level 5 %, standard error of a share of 5 %: {(475 / pairs) ** 0.5:.2f} %",
        *(f"{name}: {model}" for name, model in MODELS.items()),
    ]
    body = section(
        "Equal devices", VERDICT, equal,
        "verdict: the likelihood ratio with its law drawn, as printed; symbols: one coefficient by its "
        "profile, not adjusted.",
    )  # fmt: skip
    body += section(
        "Ratio of variances by averaging time", RATIO, rows,
        "Overlapped Allan variance, the law under what is supposed of each pair. Predicted: the law of the true model "
        "(an F with both degrees of freedom where these are many), scaled by the square of the change; "
        f"from {FEWEST} degrees of freedom on.",
    )  # fmt: skip
    run.publish("Comparison of two records", notes, body)


if __name__ == "__main__":
    main()
