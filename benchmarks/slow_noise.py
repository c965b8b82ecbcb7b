"""Whether what is slow and no noise is named: warm-up, a power law that is not flicker's, popcorn noise.

Slow: records of noise with such a thing. Clean: records of noise alone, where nothing may be named. The share of the
records in which each is named, in which K and R are claimed, and in which the 95 % intervals of N, B and K hold the
truth of the noise. Cured: of the records in which it was named with options to type, the share in which it is no longer
named in that window; with a power law the share in which N beside it holds within 1.96 standard errors.
"""

from table import begin, section, spread

import math
import re
import sys
from collections.abc import Callable

import numpy as np

import allanite as al
from allanite.core.validity import Finding
from identification import RATE, SENSORS

NAMES = ("warm-up", "flicker exponent", "popcorn")
LENGTH = 2**16
MEMS = SENSORS["MEMS"]
MODELS = {
    **SENSORS,
    "N": al.Model((MEMS["N"],)),
    "N B": al.Model((MEMS["N"], MEMS["B"])),
    "N K": al.Model((MEMS["N"], MEMS["K"])),
    "N, 10 K": al.Model((MEMS["N"], al.K(3e-3, "deg/s/sqrt(s)"))),
    "N B, 3 K": al.Model((MEMS["N"], MEMS["B"], al.K(1e-3, "deg/s/sqrt(s)"))),
    "N B R": al.Model((MEMS["N"], MEMS["B"], al.R(1e-4, "deg/s/s"))),
    "N GM 5 s": al.N(3, "deg/h*sqrt(s)") + al.GM(5, "deg/h", time_constant=5.0),
    "N GM 60 s": al.N(3, "deg/h*sqrt(s)") + al.GM(5, "deg/h", time_constant=60.0),
}
Noise = np.ndarray
Random = np.random.Generator


def nothing(y: Noise, model: al.Model, rng: Random) -> None:
    """Leave it as it is."""


def warm_up(y: Noise, model: al.Model, rng: Random) -> None:
    """A bias that settles by 10 to 30 B with a time constant of an eighth to a third of the record."""
    tau = y.size * math.exp(rng.uniform(math.log(1 / 8), math.log(1 / 3)))
    y += rng.choice([-1, 1]) * rng.uniform(10, 30) * model["B"].value * np.exp(-np.arange(y.size) / tau)


def power_law(a: float, corner: float) -> Callable[[Noise, al.Model, Random], None]:
    """Noise of density f^-a that equals N at the corner, Hz."""

    def add(y: Noise, model: al.Model, rng: Random) -> None:
        from scipy.fft import irfft
        from scipy.special import zeta

        m = 8 * y.size
        f = np.arange(1, m // 2 + 1) / m
        density = np.sin(np.pi * f) ** 2 / np.pi**2 * (zeta(2 + a, f) + zeta(2 + a, 1 - f))  # of means over samples
        size = model["N"].value * math.sqrt(RATE) * (corner / RATE) ** (a / 2)
        c = rng.standard_normal((f.size, 2)).view(np.complex128)[:, 0] * np.sqrt(density * m / 2)
        y += size * irfft(np.concatenate(([0], c)), m)[: y.size]

    return add


def popcorn(length: float, interval: float, size: float) -> Callable[[Noise, al.Model, Random], None]:
    """Bursts by so many B, of exponential lengths and intervals, s."""

    def add(y: Noise, model: al.Model, rng: Random) -> None:
        t = rng.exponential(interval)
        while t * RATE < y.size:
            end = t + rng.exponential(length)
            y[int(t * RATE) : int(end * RATE)] += size * model["B"].value
            t = end + rng.exponential(interval)

    return add


SLOW = {
    "warm-up": warm_up, "f^-0.8, corner 1 Hz": power_law(0.8, 1.0), "f^-1.2, corner 1 Hz": power_law(1.2, 1.0),
    "bursts of 3 s every 100 s by 9 B": popcorn(3.0, 100.0, 9.0),
    "bursts of 5 s every 200 s by 11 B": popcorn(5.0, 200.0, 11.0), "clean": nothing,
}  # fmt: skip
CELLS = [
    *(("clean", sensor, LENGTH) for sensor in ("MEMS", "FOG", "RLG", "N K", "N GM 5 s")),
    ("clean", "MEMS", 2**14),
    *((what, "N", LENGTH) for what in SLOW if what.startswith("f^")),
    *((what, "MEMS", LENGTH) for what in SLOW if what.startswith("bursts")),
    *(("warm-up", sensor, LENGTH) for sensor in ("MEMS", "FOG", "N B")),
]
HEADINGS = (
    "record", "noise", "n", *(f"{name} %" for name in NAMES), "any %", "K claimed %", "R claimed %",
    "N held %", "B held %", "K held %", "cured %", "median B over truth",
)  # fmt: skip


def asked_of(job: tuple[int, int]) -> list[float]:
    """Whether each is named, K and R are claimed, intervals hold; and B over the truth."""
    cell, seed = job
    what, sensor, n = CELLS[cell]
    model = MODELS[sensor]
    rng = np.random.default_rng([cell, seed])
    y = al.simulate(model, n, RATE, rng=rng).values.copy()
    SLOW[what](y, model, rng)
    record = al.Record(y, RATE, "rad/s")
    fit = al.identify(record)
    findings = {finding.name: finding for finding in al.residuals(record, fit).findings}
    truth = {term.symbol: term.value for term in model}
    held = [holds(fit[symbol], truth.get(symbol)) for symbol in "NBK"]
    size = (fit["B"].value or 0.0) / truth["B"] if "B" in truth else math.nan
    named = [name in findings for name in NAMES]
    help_ = [cured(record, findings[name], model["N"].value) for name in NAMES if name in findings][:1] or [math.nan]
    return [*named, any(named), fit["K"].claimed, fit["R"].claimed, *held, *help_, size]


def cured(record: al.Record, finding: Finding, N: float) -> float:
    """Whether what a finding advises helps; NaN where it names no window and no N."""
    beside = re.search(r"N is (\S+) ± (\S+) (\S+)", finding.consequence)
    if beside:
        value, error = (float(beside[i]) * al.N(1, beside[3]).value for i in (1, 2))
        return float(abs(value - N) < 1.96 * error)
    options = dict(re.findall(r"--(from|until) ([0-9.]*[0-9])", finding.remedy))
    if not options:
        return math.nan
    first, last = (round(float(options.get(key, end)) * RATE) for key, end in (("from", 0), ("until", 1e9)))
    part = al.Record(record.values[first:last], RATE, "rad/s")
    return float(finding.name not in {other.name for other in al.residuals(part, al.identify(part)).findings})


def holds(estimate: al.Estimate, truth: float | None) -> float:
    """Whether the interval holds the truth; NaN where there is no such term."""
    if truth is None:
        return math.nan
    low, high = estimate.interval(0.95)
    return float(low <= truth <= high)


def row(cell: int, found: list[list[float]]) -> tuple[str, ...]:
    what, sensor, n = CELLS[cell]
    values = np.array(found, dtype=float)
    known = [part[~np.isnan(part)] for part in values[:, :-1].T]
    shares = [f"{100 * part.mean():.1f}" if part.size else "" for part in known]
    size = float(np.median(values[:, -1]))
    return (what, sensor, str(n), *shares, "" if math.isnan(size) else f"{size:.2f}")


def main() -> None:
    run = begin(__doc__, records=200, processes=2)
    rows, numbers = [], ((number,) for number in range(len(CELLS)))
    for (number,), answers in spread(asked_of, numbers, run.asked.records, run.asked.processes, first=1):
        rows.append(row(number, answers))
        print(*CELLS[number], rows[-1][3:], file=sys.stderr, flush=True)
    slow = [r for r in rows if r[0] != "clean"]
    error = 100 * math.sqrt(0.01 * 0.99 / run.asked.records)
    notes = [
        f"seeds: number of the row and 1..{run.asked.records}; 100 Hz; standard error of a share of 1 %: {error:.1f} %"
    ]
    about = (
        "Warm-up: 10 to 30 B, time constant from an eighth to a third of the record. The power laws equal N at the "
        "corner. The last column says what bursts do to B."
    )
    clean = section("Clean", HEADINGS, [r for r in rows if r[0] == "clean"])
    run.publish("What is slow and no noise", notes, section("Slow", HEADINGS, slow, about) + clean)


if __name__ == "__main__":
    main()
