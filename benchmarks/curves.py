"""Limits of curves of every statistic against the truth: the noise identified from the same record, known, with gaps.

Records of a simulator of its own (judge.py) of 1 Hz. "identified": nothing is told of the noise, and the limits are
averaged over the models that the record leaves open; "known": those of the noise that made it; "with gaps": a tenth of
the samples is missing, in bursts and alone, the noise identified. Beside them allantools with the power law that it
finds at each averaging time. The truth is the expectation by the package's formulas; the mean of the variances over it
shows that records and formulas agree. The seed is the CRC-32 of `NOISE/SAMPLES`, and the number of the record.
"""

from table import Row, begin, covered, section, spread

import contextlib
import io
import math
import warnings
from collections.abc import Iterable, Iterator
from typing import Any
from zlib import crc32

import numpy as np

import allanite as al
import judge
from allanite.core.errors import DataError
from allanite.core.units import SIGNALS
from allanite.statistics import STATISTICS
from shapes import ARCSEC, Made, gappy

H = 1 / 3600
NOISES: dict[str, dict[str, float]] = {
    "N": {"N": 1 / 60},
    "N K": {"N": 1 / 60, "K": 1 / 3600},
    "N B": {"N": 1 / 60, "B": 10 * H},
    "N B K": {"N": 1 / 60, "B": 6 * H, "K": 0.5 / 3600},
    "Q N B": {"Q": 30 * ARCSEC, "N": 1 / 60, "B": 5 * H},
    "Q N B K R": {"Q": 30 * ARCSEC, "N": 1 / 60, "B": 5 * H, "K": 0.5 / 3600, "R": 60 * H**2},
    "Q K": {"Q": 30 * ARCSEC, "K": 4 / 60 / 3600},
}
"""Coefficients in deg and s."""

TO_A_FIFTH, TO_0_3, TO_HALF, TO_0_8 = (0.1, 0.2), (0.1, 0.2, 0.3), (0.1, 0.2, 0.4, 0.5), (0.1, 0.2, 0.4, 0.5, 0.8)
STATISTIC = {
    "oadev": TO_HALF, "ohdev": TO_A_FIFTH, "mdev": TO_A_FIFTH, "pdev": TO_HALF, "totdev": TO_0_8,
    "mtotdev": TO_0_3, "htotdev": TO_0_3, "theo1": TO_HALF, "theobr": TO_HALF, "theoh": TO_HALF,
}  # fmt: skip
"""Each with averaging times that it reaches, shares of the record."""

EXACT = ("totdev", "mtotdev", "htotdev", "theo1")  # statistics whose bias is divided out
GAPPED = ("oadev", "ohdev")  # statistics of which whole windows are left at these averaging times
PEERS = {"oadev": "oadev", "ohdev": "ohdev", "mdev": "mdev", "totdev": "totdev"}  # those of allantools with limits
WAYS = ("identified", "known", "with gaps", "allantools")
LEVEL = 0.95
PHASES = 30  # points of the angle from which allantools finds a power law, at least

Point = tuple[int, float, float]
"""Place of the truth (-1 below the limits, 0 within, 1 above), upper over lower limit, variance over expectation."""


def model_of(noise: str) -> al.Model:
    """The noise as the package has it."""
    return al.Model(tuple(al.Term(s, math.radians(size), SIGNALS[0]) for s, size in NOISES[noise].items()))


def factors_of(name: str, size: int) -> list[int]:
    """Averaging factors, even, at the shares of the record that a statistic reaches."""
    return [2 * int(share * size / STATISTICS[name].tau_factor / 2) for share in STATISTIC[name]]


def points_of(job: tuple[str, int, int]) -> dict[tuple[str, str, int], Point]:
    """Of one record, by way, statistic and averaging factor."""
    noise, size, number = job
    rng = np.random.default_rng((crc32(f"{noise}/{size}".encode()), number))
    y = judge.sensor(size, 1.0, rng, **NOISES[noise])
    whole, holed = (al.Record(v, 1.0, "deg/s", kind="rate") for v in (y, gappy(Made(y, rng))))
    model = model_of(noise)
    told: list[tuple[str, al.Record, Any]] = [
        ("identified", whole, al.identify(whole)), ("known", whole, model), ("with gaps", holed, al.identify(holed))
    ]  # fmt: skip
    points = {}
    for name in STATISTIC:
        m = factors_of(name, size)
        variance = al.expected(model, STATISTICS[name].target or name, [k * STATISTICS[name].tau_factor for k in m],
                               rate=1.0, size=size)  # fmt: skip
        truth = np.sqrt(variance)
        for way, record, known in told:
            for k, true in zip(m, truth, strict=True):
                if way != "with gaps" or name in GAPPED:
                    for p in limited(record, name, k, known, true):
                        points[way, name, k] = p
        if name in PEERS:
            peers = zip(m, truth, peer_limits(whole, name, m), strict=True)
            points |= {("allantools", name, k): point(true, *limits) for k, true, limits in peers if limits}
    return points


def limited(record: al.Record, name: str, k: int, noise: Any, truth: float) -> Iterator[Point]:
    """The point of a curve, none where angle noise of joints over gaps leaves nothing of a long time."""
    with contextlib.suppress(*([DataError] if np.isnan(record.values).any() else [])):
        curve = al.deviation(record, name, m=[k], noise=noise, bias="exact" if name in EXACT else None)
        (low,), (high,) = curve.interval(LEVEL)
        yield point(truth, float(low), float(high), float(curve.variance[0]))


def point(truth: float, low: float, high: float, variance: float = math.nan) -> Point:
    """Where the truth is."""
    return -1 if truth < low else int(truth > high), high / low if low else math.inf, variance / truth**2


def peer_limits(record: al.Record, name: str, m: list[int]) -> Iterator[tuple[float, float] | None]:
    """Limits of allantools by the power law that it finds at each averaging factor; None where it gives none."""
    import allantools
    from allantools import ci

    phase = np.concatenate(([0.0], np.cumsum(record.values - np.mean(record.values)))) * record.rate_factor
    degree, size = (3 if name == "ohdev" else 2), phase.size - 1
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        for k in m:
            try:
                value = getattr(allantools, PEERS[name])(phase, rate=1.0, data_type="phase", taus=[float(k)])[1][0]
                longest = min(k, size // (PHASES + 1))
                alpha = ci.autocorr_noise_id(phase, longest, data_type="phase", dmin=0, dmax=degree)[0]
                kind = {"overlapping": True, "modified": name == "mdev"}
                edf = (ci.edf_totdev(phase.size, k, alpha) if name == "totdev"
                       else ci.edf_greenhall(alpha=alpha, d=degree, m=k, N=phase.size, **kind))  # fmt: skip
                low, high = ci.confidence_interval(float(value), edf, LEVEL)
                yield float(low), float(high)
            except (UserWarning, NotImplementedError, AssertionError, IndexError):  # too few windows for it
                yield None


Points = dict[tuple[str, str, int], Point]


def cell_rows(noise: str, size: int, answers: list[Points]) -> Iterator[Row]:
    """A row for each statistic and averaging time of a noise and length."""
    for name in STATISTIC:
        for k in factors_of(name, size):
            of = {way: [a[way, name, k] for a in answers if (way, name, k) in a] for way in WAYS}
            shares = (covered(p[0] for p in of[way]) if of[way] else "" for way in WAYS)
            ratios = (f"{np.median([p[1] for p in of[way]]):.3g}" if of[way] else "" for way in WAYS)
            cells = (cell for pair in zip(shares, ratios, strict=True) for cell in pair)
            mean = f"{np.mean([p[2] for p in of['known']]):.3f}"
            yield (noise, str(size), name, f"{k * STATISTICS[name].tau_factor / size:.2f}", mean, *cells)


def statistic_rows(answers: Iterable[Points]) -> Iterator[Row]:
    """A row for each statistic, over all noises, lengths and averaging times, and one for all."""
    kept = list(answers)
    for label, names in [*((name, (name,)) for name in STATISTIC), ("all", tuple(STATISTIC))]:
        places = {way: [p[0] for a in kept for (w, name, _), p in a.items() if w == way and name in names]
                  for way in WAYS}  # fmt: skip
        yield (label, *(f"{100 * np.mean(np.array(places[way]) == 0):.1f}" if places[way] else "-" for way in WAYS))


def main() -> None:
    """Make the table."""
    run = begin(__doc__ or "", records=100, sizes=[1024, 16384], noises=list(NOISES))
    asked, answers, rows = run.asked, list[Points](), list[Row]()
    for cell, made in spread(points_of, ((a, b) for a in asked.noises for b in asked.sizes), asked.records):
        answers += made
        rows += cell_rows(*cell, made)
        print(*rows[-1], flush=True)
    body = section("Coverage", ("statistic", *(f"{way} %" for way in ("noise identified", "noise known", *WAYS[2:]))),
                   statistic_rows(answers), "% of limits at a level of 95 % that hold the truth.")  # fmt: skip
    heads = (cell for way in WAYS for cell in (way, f"{way}: ratio"))
    body += section("Cells", ("noise", "samples", "statistic", "tau / T", "mean", *heads), rows,
                    "% of limits that hold the truth (+ truth above, - below); ratio: median upper over lower limit; "
                    "mean: variance over the expected one.")  # fmt: skip
    run.publish("Limits of curves", [
        f"seeds: the CRC-32 of `NOISE/SAMPLES`, and the number of the record; {asked.records} records a cell",
        f"theobr and theoh with the model's bias, {', '.join(EXACT)} 'exact'",
    ], body)  # fmt: skip


if __name__ == "__main__":
    main()
