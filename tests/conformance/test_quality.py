"""Faults planted in simulated records are named; clean records are let through."""

from functools import lru_cache, partial

import numpy as np
import pytest
from tests import examples
from tests.rows import paired, rows

import allanite as al
from allanite.prepare import inspect

RATE, SIZE = 100.0, 2**17
TIME = np.arange(SIZE) / RATE
SENSORS = {
    "MEMS": al.sensor("mems"), "RLG": al.sensor("rlg"),
    "FOG": al.Model("Q 0.4 arcsec, N 3 deg/h*sqrt(s), B 1 deg/h, K 0.09 deg/h/sqrt(s)"),
    "ramp": al.Model("N 3 deg/h*sqrt(s), R 0.02 deg/h/s"),
    "walk": al.Model("N 3 deg/h*sqrt(s), K 1 deg/h/sqrt(s)"),
}  # fmt: skip


@lru_cache(maxsize=10)
def simulated(sensor, seed):
    return al.simulate(SENSORS[sensor], SIZE, RATE, rng=np.random.default_rng(seed)).values


def inspected(sensor, seed, fault=lambda y, rng: None):
    """A record, in which a fault is planted, inspected."""
    y = simulated(sensor, seed).copy()
    fault(y, np.random.default_rng(seed))
    return inspect(al.Record(y, RATE, "rad/s"))


def sigma(y):
    return float(np.std(np.diff(y, 2))) / 6**0.5


def gaps(y, rng):
    y[rng.integers(100, SIZE - 100, 5)] = np.nan


def stuck(y, rng):
    start = rng.integers(100, SIZE - 1000)
    y[start : start + 300] = y[start]


def clip(y, rng):
    np.clip(y, y.mean() - 2.2 * y.std(), y.mean() + 2.2 * y.std(), out=y)


def spikes(y, rng):
    y[rng.integers(100, SIZE - 100, 4)] += 30 * sigma(y)


def line(y, rng):
    y += 0.5 * sigma(y) * np.sin(2 * np.pi * 13.0 * TIME + rng.uniform(0, 6))


def motion(y, rng):
    last = SIZE // 20
    y[-last:] += 300 * sigma(y) * np.sin(2 * np.pi * 0.7 * TIME[:last])


def level(y, rng):
    half = SIZE // 2
    y[half:] = y[half] + 2 * (y[half:] - y[half])


def rounded(y, rng, size=1.2, shift=0.0):
    step = size * sigma(y)
    y[:] = np.rint(y / step + shift) * step


def held(y, rng):
    y[:] = y[np.minimum(np.arange(SIZE) * 9 // 10 + rng.integers(0, 10), SIZE - 1)]


def interpolated(y, rng):
    at = np.arange(SIZE) * rng.uniform(0.85, 0.97) + rng.uniform()
    y[:] = np.interp(at, np.arange(SIZE), y)


FAULTS = {
    "resampled": held, "resampled, linear": interpolated, "gaps": gaps, "stuck": stuck, "clipped": clip,
    "outliers": spikes, "lines": line, "moving": motion, "level": level, "quantized": rounded,
    "no dither": partial(rounded, size=8, shift=3.4),
}  # fmt: skip


@pytest.mark.ensemble
@rows("sensor, name", paired(["MEMS", "FOG", "RLG"], list(FAULTS)))
def test_a_fault_is_named(sensor, name):
    """In at least 9 of 10 records."""
    records = range(1, 1 + examples(10))
    named = [name.split(",")[0] in inspected(sensor, seed, FAULTS[name]).names for seed in records]
    assert sum(named) >= 0.9 * len(records)


@pytest.mark.ensemble
@pytest.mark.slow("many records without a fault")
@rows("sensor", list(SENSORS))
def test_clean_records_are_let_through(sensor):
    """At most 2 % of findings are false: 0 or 1 in 60 records."""
    found = [inspected(sensor, seed).names for seed in range(1, 1 + examples(60))]
    assert sum(bool(names) for names in found) <= 1, [names for names in found if names]


def test_every_finding_says_what_to_do():
    for name, fault in FAULTS.items():
        findings = {f.name: f for f in inspected("FOG", 1, fault).findings}
        finding = findings[name.split(",")[0]]
        assert all((finding.what, finding.consequence, finding.remedy)), name
        if name in ("gaps", "stuck", "clipped", "outliers", "moving", "level"):
            start, end = finding.place
            assert 0 <= start <= end <= SIZE / RATE
