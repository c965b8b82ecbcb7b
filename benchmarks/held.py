"""Loggers faster than their sensor: whether held samples are named, and N is that of the sensor.

A sensor of white noise, rounded to a step, is read by a logger whose clock is `times` as fast and jitters. The second
table is of records in which nothing is held: clean, filtered, bursty, with vibration, slow noise, rounded to a step.
"""

from table import Row, begin, markdown, section, shared, spread

import itertools
import os

import numpy as np
from scipy.signal import butter, lfilter

import allanite as al

TIMES = [1.25, 1.5, 2.0, 2.5, 3.0, 6.3, 10.0, 20.0]
CLOCKS = {"steady": 0.0, "jitters by 5 %": 0.05, "jitters by 20 %": 0.2}  # of the interval of the logger
STEPS = {"fine": 1e-3, "coarse": 0.7}  # of rounding, over the standard deviation of a sample
SAMPLES, RATE = 8000, 200.0  # of the sensor, and of the logger in Hz
NEAR, FALSE = 0.03, ("held", "resampled")
KINDS = ("white", "low-pass", "bursts", "vibration", "slow", "random walk")


def logged(times: float, clock: str, step: str, number: int) -> np.ndarray:
    """What the logger writes of a sensor of white noise of 1."""
    rng = np.random.default_rng((TIMES.index(times), list(CLOCKS).index(clock), list(STEPS).index(step), number))
    size, width = int(SAMPLES * times), STEPS[step]
    samples = np.rint(rng.standard_normal(SAMPLES + 10) / width) * width
    asked = np.arange(size) + CLOCKS[clock] * rng.standard_normal(size)
    return samples[np.clip(((asked + rng.uniform(0, times)) / times).astype(int), 0, SAMPLES + 9)]


def answer(job: tuple[float, str, str, int]) -> tuple[bool, bool]:
    """Whether held samples are named, and whether N is near the truth."""
    times, clock, step, number = job
    study = al.analyze(logged(times, clock, step, number), rate=RATE, unit="deg/s", terms="NK")
    named = any(finding.name == "held" for finding in study.findings)
    truth = np.radians(np.sqrt(1 + STEPS[step] ** 2 / 12) / np.sqrt(RATE / times))
    fit = study[0].fit
    return named, fit is not None and abs((fit["N"].value or 0.0) / truth - 1) < NEAR


def other(kind: str, number: int) -> np.ndarray:
    """A record in which nothing is held."""
    rng = np.random.default_rng((1000, KINDS.index(kind), number))
    size = int(rng.choice([6000, 20_000, 60_000]))
    y, t = rng.standard_normal(size), np.arange(size)
    if kind == "low-pass":
        y = lfilter(*butter(int(rng.choice([1, 2, 4])), rng.uniform(0.02, 0.9)), y)
    if kind == "bursts":
        for start in np.cumsum(rng.uniform(50, 300, size // 50)).astype(int):
            y[start : start + int(rng.integers(5, 40))] *= rng.uniform(2, 20)
    if kind == "vibration":
        y += rng.uniform(0.3, 8) * np.sin(2 * np.pi * rng.uniform(0.001, 0.5) * t)
    if kind == "slow":
        y = 0.05 * y + rng.uniform(0.3, 5) * np.sin(2 * np.pi * rng.uniform(5e-4, 0.1) * t)
    if kind == "random walk":
        y = 0.1 * y + 0.01 * np.cumsum(rng.standard_normal(size))
    step = y.std() * 10 ** rng.uniform(-4, 0.7)
    return np.rint(y / step) * step


def false(job: tuple[str, int]) -> bool:
    """Whether a record in which nothing is held is called held or interpolated."""
    from allanite.core.record import Recording
    from allanite.prepare.held import as_sensed
    from allanite.prepare.quality import inspect

    recording = as_sensed(Recording((al.Record(other(*job), 100.0, "deg/s"),)))
    names = {finding.name for finding in recording.findings} | set(inspect(recording[0]).names)
    return not names.isdisjoint(FALSE)


def main() -> None:
    """Make the tables."""
    run = begin(__doc__, records=20, others=50, processes=os.cpu_count() or 1)
    rows: list[Row] = []
    for (times, clock, step), answers in spread(
        answer, itertools.product(TIMES, CLOCKS, STEPS), run.asked.records, run.asked.processes
    ):
        rows.append((f"{times:g}", clock, step, *(shared(hits) for hits in zip(*answers, strict=True))))
        print(*rows[-1], flush=True)
    alarms = list(spread(false, ((kind,) for kind in KINDS), run.asked.others, run.asked.processes))
    run.publish(
        "Held samples",
        (
            "seeds: numbers of the factor, clock and step, or of the kind, and of the record",
            f"{SAMPLES} samples of the sensor, logged at {RATE:g} Hz; N within {NEAR:.0%} of that of the sensor",
        ),
        (
            *markdown(("times as fast", "clock", "step", "named, %", "N right, %"), rows),
            *section("False alarms", ("kind", "records", "called held or interpolated"),
                     [(kind, str(len(hits)), str(sum(hits))) for (kind,), hits in alarms]),
        ),
    )  # fmt: skip


if __name__ == "__main__":
    main()
