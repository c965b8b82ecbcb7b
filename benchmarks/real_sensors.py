"""The first answer on a real sensor: public recordings, and simulated sensors behind filters, lines, humps and faults.

    python benchmarks/real_sensors.py simulated [--records 300] [--exponent 16] [--write PATH]
    ALLANITE_RECORDINGS=folder python benchmarks/real_sensors.py recorded [--write PATH]

The recordings are not part of the project; INDEX.md of the folder says where each comes from. Every cell has seeds of
its own: the number of its sensor, of its fault, and of the record.
"""

from table import begin, markdown, spread

import itertools
import math
import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import butter, iirpeak, lfilter

import allanite as al
from allanite.core.units import convert
from allanite.core.validity import GRADES
from allanite.study.noise import noise_of
from allanite.study.results import Channel, Noise
from identification import RATE, SENSORS

TERMS = ("N", "B", "K")
SETTLING = 4096  # samples before the record, in which filters forget their start

Fault = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def filtered(b: list[float], a: list[float]) -> Fault:
    """A digital filter."""
    return lambda y, rng: lfilter(b, a, y)


def fast_noise(y: np.ndarray) -> float:
    """Standard deviation of what changes from sample to sample."""
    return float(np.std(np.diff(y)) / math.sqrt(2))


def two_lines(y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Sinusoids at 7.3 and 31.7 Hz of 0.3 and 0.5 standard deviations of the fast noise."""
    t, phase = np.arange(y.size) / RATE, rng.uniform(0, 2 * math.pi, 2)
    lines = 0.3 * np.sin(2 * math.pi * 7.3 * t + phase[0]) + 0.5 * np.sin(2 * math.pi * 31.7 * t + phase[1])
    return y + fast_noise(y) * lines


def hump(y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A resonance at 20 Hz of quality 10, nine times as high as the fast noise."""
    return y + 3 * fast_noise(y) * lfilter(*iirpeak(20, 10, RATE), rng.standard_normal(y.size))


def rounded(y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Rounded to steps of one standard deviation of the fast noise."""
    step = fast_noise(y)
    return np.round(y / step) * step


def louder(y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """20 % larger from half time on."""
    return y * np.where(np.arange(y.size) < (y.size + SETTLING) // 2, 1.0, 1.2)


POLE = math.exp(-2 * math.pi / 12)
FAULTS: dict[str, Fault] = {
    "clean": lambda y, rng: y, "1st-order filter, fs/12": filtered([1 - POLE], [1, -POLE]),
    "2nd-order filter, fs/6": filtered(*butter(2, 1 / 3)), "boxcar of 4": filtered([0.25] * 4, [1.0]),
    "two lines": two_lines, "hump": hump, "coarse rounding": rounded, "20 % louder from half time": louder,
}  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What was said of one record; each term's estimate over the truth, whether covered, its relative error."""

    grade: str
    filtered: bool
    limited: bool
    terms: dict[str, tuple[float, bool, float]]
    false: bool


def simulated(job: tuple[str, str, int, int]) -> Answer:
    """The answer on one simulated record."""
    sensor, fault, n, i = job
    seed = (list(SENSORS).index(sensor), list(FAULTS).index(fault), n, i)
    rng = np.random.default_rng(seed)
    model = SENSORS[sensor]
    quiet = al.simulate(model, n + SETTLING, RATE, rng=rng)
    y = FAULTS[fault](quiet.values, rng)[SETTLING:]
    noise = noise_of(al.Record(y, rate=RATE, unit=quiet.unit, kind="rate"), al.Recipe())
    truth = {t.symbol: t.value for t in model}
    if fault == "coarse rounding":  # its error is white, and as much angle random walk as any
        added = (fast_noise(quiet.values) * quiet.rate_factor) ** 2 / 12 / RATE
        truth["N"] = math.hypot(truth["N"], math.sqrt(added))
    return answer(noise, truth)


def answer(noise: Noise, truth: dict[str, float]) -> Answer:
    """What was said, against the truth."""
    scope, terms = noise.fit.scope, {}
    if scope is None:
        raise RuntimeError("the default method says where its model holds")
    for symbol in set(TERMS) & set(truth):
        e = noise.fit[symbol]
        low, high = e.interval()
        value = math.nan if e.value is None else e.value / truth[symbol]
        error = math.nan if e.standard_error is None else e.standard_error / truth[symbol]
        terms[symbol] = value, low <= truth[symbol] <= high, error
    false = any(e.claimed and e.symbol not in truth for e in noise.fit)
    return Answer(noise.validity, scope.filter is not None, scope.limited or bool(scope.masks), terms, false)


def _row(answers: list[Answer]) -> list[str]:
    grades = Counter(a.grade for a in answers)
    shares = [f"{100 * grades[g] / len(answers):.1f}" for g in GRADES]
    read = [100 * np.mean([getattr(a, name) for a in answers]) for name in ("filtered", "limited", "false")]
    explained = [a for a in answers if a.grade == "explained"]
    return [*shares, *(f"{share:.1f}" for share in read), *(_term([a.terms.get(s) for a in explained]) for s in TERMS)]


def _term(said: list[tuple[float, bool, float] | None]) -> str:
    """Coverage, share of those that are wrong, and the rms error of those that were identified, %."""
    known = [one for one in said if one is not None]
    if not known:
        return ""
    off = [abs(value - 1) > max(0.03, 3 * error) for value, _, error in known]
    values = np.array([value for value, _, _ in known if not math.isnan(value)])
    rms = f"{100 * math.sqrt(np.mean((values - 1) ** 2)):.2g}" if values.size else "-"
    return f"{100 * np.mean([inside for _, inside, _ in known]):.1f} / {100 * np.mean(off):.1f} / {rms}"


RECORDINGS: tuple[tuple[str, dict[str, object]], ...] = (
    ("adis_16405_imu1.rda", {"unit": "deg/s", "channels": ("1", "2", "3")}),
    ("adis_16405_imu1.rda", {"unit": "g", "channels": ("4", "5", "6")}),
    ("adis_16405_imu2.rda", {"unit": "deg/s", "channels": ("1", "2", "3")}),
    ("adis_16405_imu2.rda", {"unit": "g", "channels": ("4", "5", "6")}),
    ("mpu6050_static10min/mpu6050_gyroscope.mat", {"rate": 100.0, "unit": "deg/s"}),
    ("mpu6050_static10min/mpu6050_accelerometer.mat", {"rate": 100.0, "unit": "g"}),
    ("phone_gyro4.txt", {"unit": "rad/s"}),
    ("aegiverse_fog_0917.txt", {"unit": "deg/h"}),
    ("psins_lasergyro.imu", {}),
)
"""Public recordings, with what their files do not say."""


def recorded(folder: Path) -> list[tuple[str, ...]]:
    """A row for each channel of the recordings."""
    rows = []
    for name, choices in RECORDINGS:
        for channel in al.analyze(folder / name, al.Recipe(**choices)).channels:  # type: ignore[arg-type]
            rows.append((name, channel.record.name, *_channel(channel)))
            print(*rows[-1], flush=True)
    return rows


def _channel(channel: Channel) -> list[str]:
    """Grade, scope, N over the deviation at 1 s, and 0.664 B over the least upper limit of the curve."""
    noise = channel.noise
    if noise is None:
        return ["refused", channel.refusal, "", ""]
    curve = al.deviation(channel.record, "oadev", taus="octave", noise=noise.fit.model)
    m = max(1, round(curve.rate))
    second = al.deviation(channel.record, "oadev", m=[m])
    N, B = noise.fit["N"], noise.fit["B"]
    factor = convert(1.0, curve.unit, N.signal.si[0])
    ratio = N.value / math.sqrt(m / curve.rate) / (float(second.deviation[0]) * factor) if N.claimed else math.nan
    floor = 0.664 * B.value / (float(curve.upper(0.95).min()) * factor) if B.claimed else math.nan
    scope = noise.fit.scope
    said = "; ".join(scope.sentences) if scope else ""
    return [noise.validity, said, f"{ratio:.3f}", f"{floor:.2f}"]


def main() -> None:
    """Make the table."""
    run = begin(__doc__, what=("simulated", "recorded"), records=300, exponent=16, processes=2)
    asked = run.asked
    if asked.what == "recorded":
        rows = recorded(Path(os.environ["ALLANITE_RECORDINGS"]))
        grades = Counter(row[2] for row in rows)
        notes = ["no random numbers", ", ".join(f"{grade}: {grades[grade]}" for grade in (*GRADES, "refused"))]
        headings = ("file", "channel", "grade", "read", "N over deviation at 1 s", "0.664 B over least upper limit")
        run.publish("The first answer on real recordings", notes, markdown(headings, rows))
        return
    rows, cells = [], itertools.product(SENSORS, FAULTS, [2**asked.exponent])
    for (sensor, fault, _), answers in spread(simulated, cells, asked.records, asked.processes):
        rows.append((sensor, fault, *_row(answers)))
        print(*rows[-1], flush=True)
    notes = [
        "seeds: number of the sensor, number of the fault, samples, number of the record",
        f"{asked.records} records of 2^{asked.exponent} samples at 100 Hz a cell, `noise_of` with the default recipe",
        "N, B, K: of the records called explained: % covered by 95 % limits / % off by 3 % and 3 standard errors / rms "
        "error of those identified, %",
    ]
    shares = (*(f"{g}, %" for g in GRADES), "filter claimed, %", "band or mask, %", "false term, %")
    headings = ("sensor", "behind", *shares, *TERMS)
    run.publish("The first answer on simulated sensors behind real faults", notes, markdown(headings, rows))


if __name__ == "__main__":
    main()
