"""Degrees of freedom and coverage of TheoBR and TheoH against simulation, from which `theo.KEPT` comes.

Records of 512 samples with seeds FIRST, FIRST + 1, ...: single noise with the ratio kf of the record, mixtures with the
ratio of the model. (`KEPT` was taken from seeds 1 to 600; other seeds test it.)
"""

from table import begin, markdown

import numpy as np

import allanite as al
from allanite.core.units import SIGNALS

SAMPLES = 512
CASES = (
    ({"N": 1.0}, None), ({"B": 1.0}, None), ({"K": 1.0}, None), ({"N": 1.0, "K": 0.05}, "model"),
    ({"N": 1.0, "B": 0.3}, "model"), ({"Q": 2.0, "N": 1.0, "B": 0.3, "K": 0.02}, "model"),
)  # fmt: skip
FACTORS = {"theobr": (32, 100, 200, 400), "theoh": (8, 64, 200, 400)}
FEWEST = 1.5
HEADINGS = (
    "noise", "bias", "statistic", "m", "edf", "edf / simulated", "mean / expected", "68 %", "95 %", "below", "above",
)  # fmt: skip


def made(case: tuple[dict[str, float], str | None], seeds: range) -> list[tuple[str, ...]]:
    """The lines of a case."""
    coefficients, bias = case
    model = al.Model(tuple(al.Term(symbol, value, SIGNALS[0]) for symbol, value in coefficients.items()))
    records = [al.simulate(model, SAMPLES, 1.0, rng=np.random.default_rng(seed)) for seed in seeds]
    lines = []
    for name, factors in FACTORS.items():
        curves = [al.deviation(record, name, m=factors, noise=model, bias=bias) for record in records]
        curve, ratio = curves[0], np.array([c.variance for c in curves])
        ratio /= al.expected(model, "oadev", curve.tau)
        low68, high68 = (limit**2 / curve.variance for limit in curve.interval(0.682689))
        low95, high95 = (limit**2 / curve.variance for limit in curve.interval(0.95))
        for j in np.flatnonzero(curve.edf >= FEWEST):
            v = ratio[:, j]
            simulated = 2 * v.mean() ** 2 / v.var(ddof=1)
            below, above = (100 * float(np.mean(s)) for s in (v * low95[j] > 1, v * high95[j] < 1))
            within = 100 * float(np.mean((v * low68[j] < 1) & (v * high68[j] > 1)))
            shares = [f"{x:.1f}" for x in (within, 100 - below - above, below, above)]
            head = ("".join(coefficients), str(bias), name, str(factors[j]), f"{curve.edf[j]:.2f}")
            lines.append((*head, f"{curve.edf[j] / simulated:.2f}", f"{v.mean():.3f}", *shares))
    return lines


def main() -> None:
    run = begin(__doc__, records=600, first=1)
    seeds = range(run.asked.first, run.asked.first + run.asked.records)
    lines = [line for case in CASES for line in made(case, seeds)]
    notes = [
        f"seeds {seeds[0]}..{seeds[-1]}; {SAMPLES} samples; the simulated degrees of freedom are known to "
        f"{100 * (2 / len(seeds)) ** 0.5:.0f} % where they are many, worse where they are few"
    ]
    run.publish("TheoBR and TheoH against simulation", notes, markdown(HEADINGS, lines))


if __name__ == "__main__":
    main()
