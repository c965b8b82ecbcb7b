"""What is claimed of records in which one explanation can take the place of another.

Simulated records of known noise behind filters, resonances, rounding, gaps and steps, identified with the default
recipe. Every cell has seeds of its own: its number in the table of cells, and the number of the record.
"""

from table import begin, markdown

import math
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from multiprocessing import Pool

import numpy as np
from scipy.signal import butter, lfilter

import allanite as al
from allanite.core.validity import GRADES
from allanite.study.noise import noise_of
from allanite.study.results import Noise
from real_sensors import SETTLING, fast_noise, filtered

Values = np.ndarray
Change = Callable[[Values, np.random.Generator], Values]

STANDARD_GRAVITY = 9.80665
RESONANCES = ((0.464, 3.6e-3, 40), (0.562, 3.6e-3, 40), (1.69, 3e-3, 60), (9.88, 1.5e-3, 80), (10.4, 1.5e-3, 80),
              (19.4, 1.2e-3, 200))  # fmt: skip
"""Of a table in a laboratory: frequency, Hz, RMS, g, and quality."""


def resonance(n: int, rate: float, frequency: float, quality: float, rng: np.random.Generator) -> Values:
    """White noise through two poles, of standard deviation 1."""
    r, w = math.exp(-math.pi * frequency / quality / rate), 2 * math.pi * frequency / rate
    z = lfilter([1.0], [1.0, -2 * r * math.cos(w), r * r], rng.standard_normal(n + 20_000))[20_000:]
    return z / z.std()


def rounded(sigma: float) -> Change:
    """Rounded to steps of so many standard deviations of the fast noise."""

    def change(y: Values, rng: np.random.Generator) -> Values:
        step = sigma * fast_noise(y)
        return np.round(y / step) * step

    return change


def dropped(every: int) -> Change:
    """Every so many samples one is missing."""

    def change(y: Values, rng: np.random.Generator) -> Values:
        y = y.copy()
        y[SETTLING::every] = np.nan
        return y

    return change


def lost(share: float) -> Change:
    """A share of the samples, at random, is missing."""
    return lambda y, rng: np.where(rng.random(y.size) < share, np.nan, y)


def gap(y: Values, rng: np.random.Generator) -> Values:
    """40 % are missing in one piece."""
    y = y.copy()
    y[SETTLING + 12_000 : SETTLING + 25_000] = np.nan
    return y


def shaken(smoothed: bool, step: float, y: Values, rng: np.random.Generator) -> Values:
    """Resonances beside the noise of an accelerometer at 100 Hz, which may be averaged and rounded to a step, g."""
    y = np.convolve(y, [0.25, 0.5, 0.25], "same") if smoothed else y
    for frequency, rms, quality in RESONANCES:
        y = y + rms * STANDARD_GRAVITY * resonance(y.size, 100.0, frequency, quality, rng)
    return np.round(y / (step * STANDARD_GRAVITY)) * step * STANDARD_GRAVITY if step else y


def humming(frequency: float, quality: float, rms: float, y: Values, rng: np.random.Generator) -> Values:
    """A resonance, at a frequency in cycles per sample, of so many standard deviations of the fast noise."""
    return y + rms * fast_noise(y) * resonance(y.size, 1.0, frequency, quality, rng)


def stepped(count: int, size: float, y: Values, rng: np.random.Generator) -> Values:
    """Steps of the bias, of so many standard deviations of the fast noise."""
    at = rng.integers(SETTLING, y.size, count)
    return y + size * fast_noise(y) * np.cumsum(np.bincount(at, rng.choice([-1.0, 1.0], count), y.size))


def popping(y: Values, rng: np.random.Generator) -> Values:
    """Popcorn: the bias jumps by 0.3 standard deviations for 5 s, every 60 s on average, at 100 Hz."""
    y, at = y.copy(), 0.0
    while (at := at + rng.exponential(6000)) < y.size:
        end = at + rng.exponential(500)
        y[int(at) : int(end)] += 0.3 * fast_noise(y)
        at = end
    return y


@dataclass(frozen=True)
class Cell:
    """A noise model, samples, rate in Hz, and what happens to the record; `walk` if K would be no property of it."""

    model: str
    size: int
    rate: float = 100.0
    change: Change | None = None
    walk: bool = False


PAPER = "N 0.005 deg/sqrt(h), B {} deg/h, GM 1.2 deg/h {} s"
RAMP = ", R 0.5 deg/h/h"
SHAKEN = "N 0.255 m/s/sqrt(h), B 380 ug, K 2800 ug/sqrt(h)"
PLAIN = {
    "N": "N 0.6 deg/sqrt(h)",
    "N B": "N 0.6 deg/sqrt(h), B 5 deg/h",
    "N B K": "N 0.6 deg/sqrt(h), B 5 deg/h, K 30 deg/h/sqrt(h)",
}
BESIDE = "N 0.1 deg/sqrt(h), B 3 deg/h, GM 3 deg/h {} s"
BEHIND = "N 0.6 deg/sqrt(h), GM 72 deg/h {} s"

CELLS: dict[str, Cell] = {
    "N B GM, 100 Hz": Cell(PAPER.format(0.3, 2), 360_000),
    "N B GM R, 40 Hz": Cell(PAPER.format(0.3, 2) + RAMP, 144_000, 40.0),
    "N B GM R, 40 Hz, B 0.2": Cell(PAPER.format(0.2, 2) + RAMP, 144_000, 40.0),
    "N B GM R, 40 Hz, B 0.6": Cell(PAPER.format(0.6, 2) + RAMP, 144_000, 40.0),
    "N B GM R, 10 Hz, 20 s": Cell(PAPER.format(0.3, 20) + RAMP, 36_000, 10.0),
    "accelerometer, resonances": Cell(SHAKEN, 1_000_000, change=partial(shaken, False, 0.0)),
    "accelerometer, resonances, averaged": Cell(SHAKEN, 1_000_000, change=partial(shaken, True, 0.0)),
    "accelerometer, resonances, averaged, rounded": Cell(SHAKEN, 1_000_000, change=partial(shaken, True, 3.33e-3)),
    "450 samples, resonance at 0.466 fs": Cell("N 0.6 deg/sqrt(h)", 450, change=partial(humming, 0.466, 5, 1.0)),
    "resonance at 0.335 fs": Cell("N 0.6 deg/sqrt(h)", 30_000, 40.0, partial(humming, 0.335, 3, 0.3)),
    **{f"{name}, rounded to {sigma:g} sigma": Cell(model, 2**16, change=rounded(sigma))
       for sigma in (0.3, 1.0, 3.0) for name, model in PLAIN.items()},
    **{f"{name}, every {every}th missing": Cell(model, 2**16, change=dropped(every))
       for every in (3, 7) for name, model in PLAIN.items()},
    **{f"{name}, 5 % missing": Cell(model, 2**16, change=lost(0.05)) for name, model in PLAIN.items()},
    **{f"N B, mean of {count}": Cell(PLAIN["N B"], 2**16, change=filtered([1 / count] * count, [1.0]))
       for count in range(2, 10)},
    "two GM, 3 and 100 s": Cell("N 0.1 deg/sqrt(h), GM 3 deg/h 3 s, GM 3 deg/h 100 s", 2**15, 20.0),
    "loop of 0.5 Hz, damping 0.5": Cell("N 0.6 deg/sqrt(h), GM2 108 deg/h 0.5 Hz 0.5", 2**16),
    "loop of 0.3 Hz, damping 0.15": Cell("N 0.6 deg/sqrt(h), GM2 108 deg/h 0.3 Hz 0.15", 2**16),
    "N K, 40 % missing": Cell("N 0.1 deg/sqrt(h), K 12 deg/h/sqrt(h)", 2**15, 20.0, gap),
    "N B K, 40 % missing": Cell("N 0.1 deg/sqrt(h), B 3 deg/h, K 6 deg/h/sqrt(h)", 2**15, 20.0, gap),
    **{f"GM {time} s behind 8 Hz": Cell(BEHIND.format(time), 2**15, change=filtered(*butter(1, 8 / 50)))
       for time in (1, 10)},
    **{f"N B GM {time} s": Cell(BESIDE.format(time), 2**16, 20.0) for time in (60, 150, 800)},
    "1 step": Cell(PLAIN["N B"], 2**16, change=partial(stepped, 1, 0.2), walk=True),
    "3 steps": Cell(PLAIN["N B"], 2**16, change=partial(stepped, 3, 0.1), walk=True),
    "10 steps": Cell(PLAIN["N B"], 2**16, change=partial(stepped, 10, 0.05), walk=True),
    "popcorn": Cell(PLAIN["N B"], 2**16, change=popping, walk=True),
    **{name: Cell(model, 2**16) for name, model in PLAIN.items()},
    "N K": Cell("N 0.6 deg/sqrt(h), K 30 deg/h/sqrt(h)", 2**16),
    "N B K, 1000 samples": Cell("N 0.6 deg/sqrt(h), B 30 deg/h, K 1000 deg/h/sqrt(h)", 1000, 10.0),
    "phone": Cell("N 0.6 deg/sqrt(h), B 20 deg/h, K 60 deg/h/sqrt(h)", 40_000, 5.0),
}  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What was said: `terms` by symbol, the estimate over the truth, whether covered, half its interval over it."""

    grade: str
    named: bool
    filtered: bool
    false: bool
    quantized: bool
    terms: dict[str, tuple[float, bool, float]]


def answered(job: tuple[str, int]) -> Answer | None:
    """The answer on one record; None where it was refused."""
    name, i = job
    cell, rng = CELLS[name], np.random.default_rng((list(CELLS).index(name), i))
    model = al.Model(cell.model)
    quiet = al.simulate(model, cell.size + SETTLING, cell.rate, rng=rng)
    y = (cell.change(quiet.values, rng) if cell.change else quiet.values)[SETTLING:]
    truth: dict[str, list[float]] = {}
    for term in model:
        truth.setdefault(term.symbol, []).append(term.value)
    if "rounded to" in name:  # its error is white, and as much angle random walk as any
        added = (float(name.split()[-2]) * fast_noise(quiet.values) * quiet.rate_factor) ** 2 / 12 / cell.rate
        truth["N"] = [math.hypot(truth["N"][0], math.sqrt(added))]
    try:
        noise = noise_of(al.Record(y, rate=cell.rate, unit=quiet.unit, kind="rate"), al.Recipe())
    except al.DataError:
        return None
    return answer(noise, truth, cell)


def answer(noise: Noise, truth: dict[str, list[float]], cell: Cell) -> Answer:
    """What was said, against the truth; coefficients that are called not valid are left out."""
    fit = noise.fit
    if fit.scope is None:
        raise RuntimeError("the default method says where its model holds")
    terms = {}
    for e in fit:
        if e.symbol in truth and len(truth[e.symbol]) == 1 and noise.explained and e.limits is not None:
            value, (low, high) = truth[e.symbol][0], e.interval()
            estimate = e.value if e.value is not None else e.median if e.median is not None else math.nan
            terms[e.symbol] = estimate / value, low <= value <= high, (high - low) / 2 / value
    findings = noise.residuals.findings if noise.residuals else fit.findings
    named = any(finding.name in ("steps", "popcorn") for finding in findings) or not noise.explained
    claimed = {e.symbol for e in fit if e.claimed}
    named = named or not claimed & {"K"}
    return Answer(
        noise.validity, named, fit.scope.filter is not None, bool(claimed - set(truth)), "Q" in claimed - set(truth),
        terms,
    )  # fmt: skip


def row(name: str, answers: list[Answer | None]) -> tuple[str, ...]:
    """A row of the table."""
    found = [a for a in answers if a is not None]
    grades = Counter(a.grade for a in found)
    shares = [100 * grades[grade] / len(answers) for grade in GRADES]
    shares += [100 * sum(getattr(a, key) for a in found) / len(answers) for key in ("filtered", "quantized", "false")]
    named = f"{100 * np.mean([a.named for a in found]):.1f}" if CELLS[name].walk else ""
    terms = [_term([a.terms[s] for a in found if s in a.terms]) for s in TERMS]
    return name, *(f"{share:.1f}" for share in shares), named, *terms


TERMS = ("N", "B", "K", "R", "GM", "GM2")


def _term(said: list[tuple[float, bool, float]]) -> str:
    if not said:
        return ""
    value, inside, width = np.array(said, dtype=float).T
    return f"{100 * inside.mean():.1f} / {np.nanmedian(value):.3f} / {100 * np.median(width):.2g}"


def main() -> None:
    """Make the table."""
    run = begin(__doc__, records=300, processes=2, cells="")
    asked = run.asked
    wanted, rows = asked.cells.split(";") if asked.cells else list(CELLS), []
    with Pool(asked.processes) as pool:
        for name in wanted:
            records = asked.records if CELLS[name].size < 500_000 else max(1, asked.records // 5)
            rows.append(row(name, pool.map(answered, [(name, i) for i in range(records)], chunksize=2)))
            print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    notes = [
        "seeds: number of the cell, number of the record",
        f"{asked.records} records a cell, a fifth of that of 10^6 samples; `noise_of` with the default recipe",
        "false: a term that is not there is claimed; Q: this one; named: steps or popcorn are named, or K is not "
        "claimed",
        "N, B, ...: % covered by 95 % limits / median estimate over the truth / half the limits over it, %, where the "
        "record is explained and the coefficient valid; of two GM neither is counted",
    ]
    headings = (
        "cell", *(f"{g}, %" for g in GRADES), "filter, %", "false Q, %", "false term, %", "named, %", *TERMS,
    )  # fmt: skip
    run.publish("What is claimed where explanations compete", notes, markdown(headings, rows))


if __name__ == "__main__":
    main()
