"""How well records are identified that are not clean, and whether what is wrong with others is named.

    python benchmarks/robustness.py [--records 400] [--pairs 100] [--faulty 50] [--write PATH]

Sizes: the share of clean records in which a check fails at 5 and at 1 %, and in which anything is said. Damage: the
same records with and without gaps or spikes; the mean difference of each coefficient, over its Cramer-Rao bound.
Faults: in how many records the right reason is named, and named first. Seeds 1, 2, 3, ...
"""

from table import begin, markdown

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing import Pool

import numpy as np

import allanite as al
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import likelihood
from allanite.prepare.outliers import marked, outliers
from allanite.study.noise import noise_of
from identification import RATE, SENSORS, bounds

CHECKS = ("cells", "correlation", "kurtosis", "halves", "eighths")
SIZES = (2**14, 2**16, 2**18)
LENGTH = 2**18
FAULTY = 2**16


def clean(sensor: str, n: int, seed: int) -> np.ndarray:
    return al.simulate(SENSORS[sensor], n, RATE, rng=np.random.default_rng(seed)).values


def fast(y: np.ndarray) -> float:
    return float(np.std(np.diff(y, 2))) / 6**0.5


# --- sizes ---------------------------------------------------------------------------------------------------------


def asked_of(job: tuple[str, int, int]) -> list[float]:
    """P of the cells and of every check, whether anything is said, and outliers found."""
    record = al.Record(clean(*job), RATE, "rad/s")
    fit = al.identify(record)
    left = al.residuals(record, fit)
    return [fit.goodness.p, *(check.p for check in left.checks), not left.explained, outliers(record).at.size]


def size_row(sensor: str, n: int, found: list[list[float]]) -> tuple[str, ...]:
    p = np.array(found)
    shares = [f"{100 * np.mean(p[:, i] < level):.1f}" for i in range(len(CHECKS)) for level in (0.05, 0.01)]
    return (sensor, str(n), *shares, f"{100 * p[:, -2].mean():.1f}", f"{p[:, -1].sum():.0f}")


SIZE_HEADINGS = (
    "sensor",
    "n",
    *(f"{name} {level} %" for name in CHECKS for level in (5, 1)),
    "not explained %",
    "outliers",
)


# --- damage --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Damage:
    """What happens to a record: `spoil` changes a copy of its rates; `kind` "angle" keeps the angle's count."""

    sensor: str
    name: str
    kind: str = "rate"


def gaps(y: np.ndarray, rng: np.random.Generator, count: int, length: int) -> None:
    for start in rng.integers(100, y.size - length - 100, count):
        y[start : start + length] = np.nan


def spikes(y: np.ndarray, rng: np.random.Generator, share: float, size: float) -> None:
    at = rng.permutation(y.size)[: round(share * y.size)]
    y[at] += size * fast(y) * rng.choice([-1.0, 1.0], at.size)


DAMAGES: dict[str, Callable[[np.ndarray, np.random.Generator], None]] = {
    "20 gaps of 6.5 s": lambda y, rng: gaps(y, rng, 20, 650),
    "20 gaps of 26 s": lambda y, rng: gaps(y, rng, 20, 2600),
    "2000 gaps of 5 samples": lambda y, rng: gaps(y, rng, 2000, 5),
    "1 gap of 800 s": lambda y, rng: gaps(y, rng, 1, 80_000),
    "1e-3 spikes of 20 sigma": lambda y, rng: spikes(y, rng, 1e-3, 20.0),
    "1e-2 spikes of 20 sigma": lambda y, rng: spikes(y, rng, 1e-2, 20.0),
}
DAMAGED = [
    *(Damage(sensor, name) for name in DAMAGES for sensor in SENSORS),
    Damage("RLG", "2000 gaps of 5 samples", "angle"),
]
DAMAGE_HEADINGS = (
    "damage",
    "sensor",
    "kind",
    "term",
    "bound %",
    "bias %",
    "difference %",
    "over bound",
    "rms over bound",
)


def over_truth(values: np.ndarray, damage: Damage) -> list[float]:
    """Coefficients over the truth, the terms that there are being known."""
    record = al.Record(values, RATE, {"rate": "rad/s", "angle": "rad"}[damage.kind], kind=damage.kind)
    terms = SENSORS[damage.sensor].terms
    noise = [t for t in terms if t.row.waveform is None]
    seen = spectrum(marked(record, outliers(record)), detrend=len(noise) < len(terms))
    found = likelihood(seen, [t.symbol for t in terms])
    theta, _ = found.minimise(np.ones(len(noise), dtype=bool))
    sizes = [*np.sqrt(theta), *([seen.slope + found.directions(theta)[0][-1]] if len(noise) < len(terms) else [])]
    return [float(x) * seen.unit_factor / (t.value * RATE**t.row.power) for x, t in zip(sizes, terms, strict=True)]


def both(job: tuple[Damage, int]) -> tuple[list[float], list[float]]:
    """Without and with the damage; an angle is counted on over what was lost."""
    damage, seed = job
    y = clean(damage.sensor, LENGTH, seed)
    spoilt = y.copy()
    DAMAGES[damage.name](spoilt, np.random.default_rng(10_000 + seed))
    if damage.kind == "angle":
        lost = np.isnan(spoilt)
        y = np.concatenate(([0.0], np.cumsum(y))) / RATE
        spoilt = y.copy()
        spoilt[:-1][lost] = np.nan
    return over_truth(y, damage), over_truth(spoilt, damage)


def damage_rows(damage: Damage, found: list[tuple[list[float], list[float]]]) -> list[tuple[str, ...]]:
    whole, spoilt = (np.array([pair[i] for pair in found]) for i in (0, 1))
    limits = bounds(SENSORS[damage.sensor], LENGTH)
    rows = []
    for i, term in enumerate(SENSORS[damage.sensor]):
        bound = limits[term.symbol]
        difference = float((spoilt[:, i] - whole[:, i]).mean())
        rms = math.sqrt(float(np.square(spoilt[:, i] - 1).mean()))
        numbers = [100 * bound, 100 * float(spoilt[:, i].mean() - 1), 100 * difference]
        cells = [f"{numbers[0]:.2f}", f"{numbers[1]:+.2f}", f"{numbers[2]:+.3f}", f"{difference / bound:+.2f}"]
        rows.append((damage.name, damage.sensor, damage.kind, term.symbol, *cells, f"{rms / bound:.2f}"))
    return rows


# --- faults --------------------------------------------------------------------------------------------------------


def louder(y: np.ndarray, _: np.random.Generator) -> None:
    half = y.size // 2
    y[half:] = y[half] + 2 * (y[half:] - y[half])


def line(y: np.ndarray, rng: np.random.Generator) -> None:
    y += 0.5 * fast(y) * np.sin(2 * np.pi * 13.0 * np.arange(y.size) / RATE + rng.uniform(0, 6))


def rolled(y: np.ndarray, _: np.random.Generator) -> None:
    from scipy.signal import butter, lfilter

    y[:] = lfilter(*butter(2, 0.4), y - y[0]) + y[0]


def tailed(y: np.ndarray, rng: np.random.Generator) -> None:
    y += 0.7 * fast(y) * rng.standard_t(3, y.size)


def steps(y: np.ndarray, sensor: str) -> al.Record:
    """Counts of an angle that turns at the earth's rate or so, its noise a small part of a step."""
    turning = y + np.radians(7 / 3600)
    step = np.radians(1.73 / 3600) if sensor == "RLG" else 8 * fast(y) / RATE
    counts = np.diff(np.floor(np.cumsum(turning) / RATE / step)).astype(np.int64)
    return al.Record(counts, RATE, "rad", kind="count", scale=step)


FAULTS: dict[str, tuple[Callable[[np.ndarray, np.random.Generator], None] | None, str]] = {
    "undithered quantizer": (None, "quantization errors are not white"),
    "line": (line, "removed first, at 13 Hz"),
    "filter roll-off": (rolled, "low-pass"),
    "half with double noise": (louder, "the noise level changes"),
    "heavy tails": (tailed, "heavy tails"),
}
FAULT_HEADINGS = ("fault", "sensor", "records", "named", "named first")


def named(job: tuple[str, str, int]) -> tuple[bool, bool]:
    """Whether the reason is named, and first."""
    fault, sensor, seed = job
    spoil, words = FAULTS[fault]
    y = clean(sensor, FAULTY, seed)
    if spoil is None:
        if sensor == "RLG":  # what is rounded is the noise without its own quantization
            model = replace(SENSORS["RLG"], terms=SENSORS["RLG"].terms[1:])
            y = al.simulate(model, FAULTY, RATE, rng=np.random.default_rng(seed)).values
        record = steps(y, sensor)
    else:
        spoil(y, np.random.default_rng(20_000 + seed))
        record = al.Record(y, RATE, "rad/s")
    noise = noise_of(record, al.Recipe())
    left = noise.residuals
    # a line that was taken out, and a filter, are no reasons against the model, and said as remarks
    first = left.reasons[0] if left and left.reasons else noise.verdict
    return words in noise.verdict, words in first


def main() -> None:
    run = begin(__doc__, records=400, pairs=100, faulty=50, processes=2)
    asked = run.asked
    with Pool(asked.processes) as pool:

        def each(job: Callable, *what: object, count: int) -> list:
            return pool.map(job, [(*what, seed) for seed in range(1, count + 1)], chunksize=5)

        sizes = [size_row(s, n, each(asked_of, s, n, count=asked.records)) for n in SIZES for s in SENSORS]
        print("sizes done", file=sys.stderr, flush=True)
        damages = [row for d in DAMAGED for row in damage_rows(d, each(both, d, count=asked.pairs))]
        print("damages done", file=sys.stderr, flush=True)
        faults = [fault_row(f, s, each(named, f, s, count=asked.faulty)) for f in FAULTS for s in SENSORS]
    notes = [
        f"seeds 1..{asked.records}, 1..{asked.pairs} and 1..{asked.faulty}; 100 Hz; damage at n = {LENGTH}, "
        f"faults at n = {FAULTY}",
    ]
    body = [
        "## Clean records in which a check fails, %",
        "",
        "Cells: goodness of fit by cells of frequency; standard error of a share of 5 %: "
        f"{100 * math.sqrt(0.05 * 0.95 / asked.records):.1f} %. Not explained: anything is said against the model. "
        "Outliers: readings marked in all of the records.",
        "",
        *markdown(SIZE_HEADINGS, sizes),
        "## Damage",
        "",
        "The terms that there are being known. Bias: of the damaged records' coefficients. Difference: from the same "
        "records whole. Bound: Cramer-Rao's.",
        "",
        *markdown(DAMAGE_HEADINGS, damages),
        "## Faults",
        "",
        *markdown(FAULT_HEADINGS, faults),
    ]
    run.publish("Records that are not clean", notes, body)


def fault_row(fault: str, sensor: str, found: list[tuple[bool, bool]]) -> tuple[str, ...]:
    return (fault, sensor, str(len(found)), *(str(sum(pair[i] for pair in found)) for i in (0, 1)))


if __name__ == "__main__":
    main()
