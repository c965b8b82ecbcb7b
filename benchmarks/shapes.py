"""The records that the package is judged by: sensors, what happens between sensor and file, and what is true then."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import allanite as al
import judge
from judge import Rng, Values

RATE, SETTLING = 100.0, 512
"""Rate, Hz, and samples in which filters and resonances forget their start."""

BIAS = 0.5  # deg/s; largest bias of a sensor, which is not near the middle of a step of rounding
ARCSEC = 1 / 3600
TERMS = ("Q", "N", "B", "K", "R", "GM")

SENSORS: dict[str, dict[str, Any]] = {
    "N": {"N": 0.005},
    "Q N": {"Q": 0.5 * ARCSEC, "N": 0.18 * ARCSEC},
    "N K": {"N": 0.005, "K": 1e-3},
    "N K, strong": {"N": 0.005, "K": 1e-2},
    "N B": {"N": 3e-4, "B": 2e-4},
    "N R": {"N": 0.005, "R": 2e-4},
    "N B K (MEMS)": {"N": 0.005, "B": 0.002, "K": 3e-4},
    "Q N B (laser gyro)": {"Q": 0.5 * ARCSEC, "N": 0.18 * ARCSEC, "B": 0.05 * ARCSEC},
    "Q N B K R (fibre gyro)":
        {"Q": 0.4 * ARCSEC, "N": 3 * ARCSEC, "B": ARCSEC, "K": 0.09 * ARCSEC, "R": 0.002 * ARCSEC},
    "N GM 0.5 s": {"N": 0.005, "GM": [(0.02, 0.5)]},
    "N GM 20 s": {"N": 0.005, "GM": [(0.004, 20.0)]},
    "N GM 1 s GM 50 s": {"N": 0.005, "GM": [(0.01, 1.0), (0.004, 50.0)]},
}  # fmt: skip
"""Coefficients in deg and s: one term, two and more, from a phone's gyro to a laser gyro; the record is in deg/s."""

REASONS = {
    "N GM 0.5 s": ("B", "in a short record it is near flicker"),
    "N GM 20 s": ("BK", "few of its time constants in a record: near flicker, and a random walk above"),
    "N GM 1 s GM 50 s": ("BK", "near flicker over two decades, and a random walk above"),
    "RC low-pass, fs/12": ("BQN", "behind it angle noise is nearly white"),
    "each sample three times": ("Q", "a time constant of few samples is as white and angle noise behind an RC filter"),
    **dict.fromkeys(("slow wave", "step", "warm-up", "popcorn"), ("BKR", "smaller than can be told from slow noise")),
}  # fmt: skip
"""Why terms are wrong, or claimed though they are not there, by sensor and by disturbance."""

Truth = dict[str, float | None]
"""Coefficients of a record, deg and s; None for one that nobody can tell in it, and that may be claimed or not."""


@dataclass(frozen=True)
class Made:
    """Samples of a sensor, and the generator that goes on."""

    y: Values
    rng: Rng

    @property
    def fast(self) -> float:
        """Standard deviation of the noise from sample to sample."""
        return float(np.std(np.diff(self.y)) / math.sqrt(2))

    @property
    def slow(self) -> float:
        """Standard deviation of the noise of means over an eighth of the record."""
        return float(np.std(np.diff(self.y.reshape(8, -1).mean(axis=1))) / math.sqrt(2))

    @property
    def t(self) -> Values:
        """Place in the record, 0 to 1."""
        return (np.arange(self.y.size) + 0.5) / self.y.size


def passed(low_pass: judge.Filter) -> Callable[[Made], Values]:
    """What comes through a filter."""
    return lambda made: judge.behind(made.y, low_pass)


def rung(made: Made) -> Values:
    """With a vibration that rings at 0.17 of the rate, thirty times as strong there as the noise."""
    return made.y + made.fast * judge.resonance(made.y.size, 0.17, 30.0, 30.0, made.rng)


def hummed(*lines: tuple[float, float]) -> Callable[[Made], Values]:
    """With sinusoids: cycles a sample, and amplitudes over the fast noise."""

    def add(made: Made) -> Values:
        at = 2 * np.pi * np.arange(made.y.size)
        turn = made.rng.uniform(0, 2 * np.pi, len(lines))
        return made.y + made.fast * sum(a * np.sin(f * at + phase) for (f, a), phase in zip(lines, turn, strict=True))

    return add


def swayed(made: Made) -> Values:
    """With a slow wave of three periods, as of an air conditioner."""
    return made.y + 2 * made.slow * np.sin(2 * np.pi * (3 * made.t + made.rng.random()))


def stepped(made: Made) -> Values:
    """With a step of the bias."""
    return made.y + 6 * made.slow * (made.t > made.rng.uniform(0.2, 0.8))


def warmed(made: Made) -> Values:
    """With a warm-up."""
    return made.y + 8 * made.slow * np.exp(-12 * made.t)


def rounded(steps: float) -> Callable[[Made], Values]:
    """Rounded to steps, in units of the fast noise."""
    return lambda made: np.round(made.y / (steps * made.fast)) * (steps * made.fast)


def gappy(made: Made) -> Values:
    """With a tenth of the samples missing, in twenty bursts and a few alone."""
    y, n = np.array(made.y), made.y.size
    for start in made.rng.integers(0, n, 20):
        y[start : start + n // 220] = np.nan
    y[made.rng.random(n) < 0.01] = np.nan
    return y


def popped(made: Made) -> Values:
    """With popcorn noise, which stays for a twentieth of the record on average."""
    return made.y + 3 * made.slow * judge.telegraph(made.y.size, made.y.size / 20, made.rng)


@dataclass(frozen=True)
class Disturbance:
    """What happens between the sensor and the file."""

    act: Callable[[Made], Values] = lambda made: made.y
    names: frozenset[str] = frozenset()  # what may be told of it
    settling: int = 0  # samples that are dropped behind it
    repeated: int = 1  # how often each sample of the sensor is logged
    tailed: bool = False  # whether the white noise has heavy tails
    step: float = 0.0  # of the rounding, which is white noise, over the fast noise
    either: frozenset[str] = frozenset()  # terms that describe it, and may be claimed or not


def _row(act: Callable[[Made], Values] = lambda made: made.y, names: str = "", **more: Any) -> Disturbance:
    return Disturbance(act, frozenset(names.split(", ")), **more)


DISTURBANCES: dict[str, Disturbance] = {
    "none": _row(),
    "RC low-pass, fs/12": _row(passed(judge.rc(1 / 12)), settling=SETTLING),
    "Butterworth, fs/6": _row(passed(judge.butterworth(1 / 6)), settling=SETTLING),
    "mean of 4": _row(passed(judge.average(4)), settling=SETTLING),
    "resonance": _row(rung, "vibration, lines", settling=SETTLING),
    "line": _row(hummed((0.23, 0.5)), "lines, vibration"),
    "hum": _row(hummed((0.1, 0.5), (0.2, 0.3), (0.3, 0.2)), "lines, vibration"),
    "slow wave": _row(swayed, "lines, wave"),
    "step": _row(stepped, "steps, level"),
    "warm-up": _row(warmed, "warm-up"),
    "rounded to 0.5 sigma": _row(rounded(0.5), "quantized", step=0.5),
    "rounded to 1.5 sigma": _row(rounded(1.5), "quantized, no dither", step=1.5),
    "each sample three times": _row(names="held", repeated=3),
    "gaps": _row(gappy),
    "heavy tails": _row(names="heavy tails", tailed=True),
    "popcorn": _row(popped, "popcorn, steps, level", either=frozenset(["GM"])),
}


def record_of(sensor: str, disturbance: str, n: int, rng: Rng) -> tuple[al.Record, Truth]:
    """A record, and its coefficients."""
    noise, row = SENSORS[sensor], DISTURBANCES[disturbance]
    rate = RATE / row.repeated
    size = -(-n // row.repeated) + row.settling
    size += -size % 8  # `slow` is that of eighths
    made = Made(rng.uniform(-BIAS, BIAS) + judge.sensor(size, rate, rng, tailed=row.tailed, **noise), rng)
    y = np.repeat(row.act(made)[row.settling :], row.repeated)[:n]
    truth: Truth = dict.fromkeys(TERMS, 0.0) | {k: v for k, v in noise.items() if k != "GM"}
    truth["N"] = math.hypot(noise["N"], row.step * made.fast / math.sqrt(12 * rate))
    for sigma, T in noise.get("GM", ()):
        truth["GM"] = sigma if len(noise["GM"]) == 1 else None
        if n / RATE < 10 * T:  # over a shorter time it is a random walk, or nearly
            truth["K"] = truth["GM"] = None
    truth |= dict.fromkeys(row.either)
    return al.Record(y, RATE, "deg/s", kind="rate"), truth
