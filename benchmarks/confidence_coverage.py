"""How often the confidence limits of every statistic hold the truth, under every noise; allantools' errors beside them.

Records of 256 samples are simulated with seeds 1, 2, 3, ...; the limits are those of the model that made them. Ends
with exit code 1 if a cell is out of bounds.
"""

from table import begin, markdown

import sys
import warnings

import numpy as np

import allanite as al
from allanite.core.units import SIGNALS

SAMPLES = 256
NOISES = {
    "Q": {"Q": 1.0}, "N": {"N": 1.0}, "B": {"B": 1.0}, "K": {"K": 1.0}, "NK": {"N": 1.0, "K": 0.05},
    "NB": {"N": 1.0, "B": 0.3}, "QK": {"Q": 3.0, "K": 0.03}, "QNBK": {"Q": 2.0, "N": 1.0, "B": 0.3, "K": 0.02},
    "NBKR": {"N": 1.0, "B": 0.2, "K": 0.02, "R": 0.002},
}  # fmt: skip
FACTORS = {
    "adev": (1, 8, 32, 64), "oadev": (1, 8, 32, 64, 100), "hdev": (1, 8, 32, 64), "ohdev": (1, 8, 32, 64),
    "mdev": (1, 8, 32, 64), "totdev": (1, 8, 32, 64, 128, 200), "mtotdev": (1, 8, 32, 64), "htotdev": (2, 8, 32, 64),
    "theo1": (10, 32, 100, 200), "pdev": (2, 8, 32, 64, 100),
}  # fmt: skip
PEERS = ("adev", "oadev", "hdev", "ohdev", "mdev", "totdev")
FEWEST = 1.5  # degrees of freedom below which nothing is promised

BOUNDS = {"68 %": (64, 73), "95 %": (92.5, 97.5), "below": (1, 4.5), "above": (1, 4.5)}
HEADINGS = ("noise", "statistic", "m", "edf", "mean / expected", *BOUNDS, "allantools 68 %")
CELLS = [(noise, name) for noise in NOISES for name in FACTORS]


def model_of(noise: str) -> al.Model:
    return al.Model(tuple(al.Term(symbol, value, SIGNALS[0]) for symbol, value in NOISES[noise].items()))


def records_of(noise: str, count: int) -> list[al.Record]:
    return [al.simulate(model_of(noise), SAMPLES, 1.0, rng=np.random.default_rng(s)) for s in range(1, count + 1)]


def made(cell: tuple[str, str], records: list[al.Record]) -> list[tuple[str, ...]]:
    """The lines of a noise and a statistic, one for each averaging factor."""
    noise, name = cell
    model, factors = model_of(noise), FACTORS[name]
    curve = al.deviation(records[0], name, m=factors, noise=model)
    low68, high68 = (limit**2 / curve.variance for limit in curve.interval(0.682689))
    low95, high95 = (limit**2 / curve.variance for limit in curve.interval(0.95))
    ratio = np.array([al.deviation(r, name, m=factors, noise=None).variance for r in records])
    ratio /= al.expected(model, name, curve.tau, rate=1.0, size=SAMPLES)
    peer = peers(name, factors, records, model) if name in PEERS else [""] * len(factors)
    lines = []
    for j in np.flatnonzero(curve.edf >= FEWEST):
        v = ratio[:, j]
        shares = ((v * low68[j] < 1) & (v * high68[j] > 1), None, v * low95[j] > 1, v * high95[j] < 1)
        within, _, below, above = (0 if s is None else 100 * float(np.mean(s)) for s in shares)
        numbers = [f"{x:.1f}" for x in (within, 100 - below - above, below, above)]
        lines.append((noise, name, str(factors[j]), f"{curve.edf[j]:.2f}", f"{v.mean():.3f}", *numbers, peer[j]))
    return lines


def peers(name: str, factors: tuple[int, ...], records: list[al.Record], model: al.Model) -> list[str]:
    """How often allantools' own one-sigma errors hold the expected deviation, percent."""
    import allantools

    true = np.sqrt(al.expected(model, name, [float(m) for m in factors], rate=1.0, size=SAMPLES))
    inside = np.zeros(len(factors))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for record in records:
            taus, deviation, error, _ = getattr(allantools, name)(record.values, 1.0, "freq", list(factors))
            for t, d, e in zip(taus, deviation, error, strict=True):
                inside[factors.index(round(t))] += abs(d - true[factors.index(round(t))]) <= e
    return [f"{100 * i / len(records):.1f}" for i in inside]


def within(line: tuple[str, ...]) -> bool:
    """Whether a line keeps the bounds, and its mean is the expectation within 3 standard errors and a rounding."""
    values = dict(zip(HEADINGS, line, strict=True))
    return all(low <= float(values[key]) <= high for key, (low, high) in BOUNDS.items())


def main() -> None:
    run, lines = begin(__doc__, records=1000), []
    for noise in NOISES:
        records = records_of(noise, run.asked.records)
        for name in FACTORS:
            lines += made((noise, name), records)
    missed = [line for line in lines if not within(line)]
    notes = [
        f"seeds 1..{run.asked.records}; {SAMPLES} samples; cells with {FEWEST} degrees of freedom or more",
        "below, above: how often the 95 % limits lie above and below the truth, each tail by itself; bounds "
        + ", ".join(f"{key} {low} to {high}" for key, (low, high) in BOUNDS.items()),
        f"out of bounds: {len(missed)} of {len(lines)} cells",
        "allantools 68 %: how often its own one-sigma errors hold the truth on the same records",
    ]
    run.publish("Coverage of the confidence limits", notes, markdown(HEADINGS, lines))
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
