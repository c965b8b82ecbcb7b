"""How often is the power law of the noise found: by the autocorrelation with plain rounding, and as the package does.

Pure noise is simulated with seeds 1, 2, 3, ...; every m-th point of the angle is what the methods see.
"""

from table import begin, markdown

from dataclasses import dataclass

import numpy as np

import allanite as al
from allanite.statistics import STATISTICS, integrated
from allanite.statistics.confidence.powerlaw import identify_power_law

NAMES = {2: "WPM", 1: "FPM", 0: "WFM", -1: "FFM", -2: "RWFM", -3: "FWFM", -4: "RRFM"}
SIMULATED = {2: al.Q(1.0, "rad"), 0: al.N(1.0, "rad/sqrt(s)"), -1: al.B(1.0, "rad/s"), -2: al.K(1.0, "rad/s^1.5")}
HEADINGS = ("row", "noise", "m", "points", "method", "found %", "plain rounding %")


@dataclass(frozen=True)
class Cell:
    """A statistic, a noise, an averaging factor, and how many points of the angle there are every m samples."""

    row: str
    alpha: int
    m: int
    points: int


CELLS = [
    *(Cell("oadev", alpha, 1, n) for alpha in (2, 0, -1, -2) for n in (4097, 513, 129, 65, 33, 25, 17, 13)),
    *(Cell("oadev", 1, 8, n) for n in (4097, 513, 129, 65)),
    *(Cell("ohdev", alpha, 8, n) for alpha in (0, -1, -2, -3, -4) for n in (257, 129, 65, 33, 17)),
]


def record_of(cell: Cell, seed: int) -> al.Record:
    """Noise of the angle and of the rate as the package simulates it; steeper noise is its sum."""
    rng = np.random.default_rng(seed)
    n = cell.m * (cell.points - 1)
    if cell.alpha == 1:
        return al.Record(np.diff(flicker(n + 1, rng)), 1.0, "rad/s", kind="rate")
    if cell.alpha > -3:
        return al.simulate(SIMULATED[cell.alpha], n, 1.0, rng=rng)
    ramp = al.simulate(SIMULATED[cell.alpha + 2], n, 1.0, rng=rng)
    return al.Record(np.cumsum(ramp.values), 1.0, "rad/s", kind="rate")


def flicker(n: int, rng: np.random.Generator) -> np.ndarray:
    """Series with spectrum 1/f up to half the sampling rate, cut from one four times as long."""
    spectrum = np.fft.rfft(rng.standard_normal(4 * n))
    spectrum[1:] /= np.sqrt(np.arange(1, spectrum.size))
    spectrum[0] = 0
    return np.fft.irfft(spectrum, 4 * n)[:n]


def plainly_rounded(x: np.ndarray, most: int) -> int:
    """The rule as published: alpha = 2 - round(2 delta) - 2d, whatever d, and no law that cannot be."""
    t = np.linspace(-1, 1, x.size)
    z = x - np.polyval(np.polyfit(t, x, 2), t)
    for d in range(most + 1):
        z = z - z.mean()
        r1 = z[:-1] @ z[1:] / (z @ z)
        delta = r1 / (1 + r1)
        if delta < 0.25 or d == most:
            break
        z = np.diff(z)
    return max(2 - 2 * most, min(2, 2 - round(2 * delta) - 2 * d))


def made(cell: Cell, records: int, first: int = 1) -> tuple[str, ...]:
    """A line of the table."""
    row = STATISTICS[cell.row]
    found, rounded = [], []
    for seed in range(first, first + records):
        angle = integrated(record_of(cell, seed), row.order)
        found += identify_power_law(angle, row, np.array([float(cell.m)]))
        rounded.append(plainly_rounded(angle.pieces[0].x[:: cell.m], row.order))
    hits = (np.mean([law.alpha == cell.alpha for law in found]), np.mean(np.array(rounded) == cell.alpha))
    methods = "/".join(sorted({law.method for law in found}))
    shares = (f"{100 * hit:.1f}" for hit in hits)
    return (cell.row, NAMES[cell.alpha], str(cell.m), str(cell.points), methods, *shares)


def main() -> None:
    run = begin(__doc__, records=200, first=1)
    records, first = run.asked.records, run.asked.first
    rows = [made(cell, records, first) for cell in CELLS]
    notes = [
        f"seeds {first}..{first + records - 1}; Monte-Carlo standard error at 50 %: {50 / records**0.5:.1f} %",
        'found: the law is named exactly, as `noise="auto"` does; plain rounding: the autocorrelation with the '
        "published rule. method: lag1, b1 (fewer than 30 points) and rn (noise of the angle at m > 3).",
        "WPM, FPM: white and flicker noise of the angle; WFM, FFM, RWFM: of the rate; FWFM, RRFM: flicker and random "
        "walk of the ramp, simulated as sums of FFM and RWFM.",
    ]
    run.publish("Power law of the noise, found from one record", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    main()
