"""Whether a channel is found to follow another one, and only then."""

import numpy as np
import pytest
from tests import examples
from tests.rows import paired, rows

import allanite as al
from allanite.prepare.drift import follows

N = 20_000


def walk(rng, size=1.0):
    return np.cumsum(rng.standard_normal(N)) * size


TEMPERATURES = {
    "random walk": walk,
    "rounded": lambda rng: np.rint(walk(rng, 0.1)),
    "day": lambda rng: np.sin(np.arange(N) / N * rng.uniform(2, 18) + rng.uniform(0, 6)),
    "warm-up": lambda rng: np.exp(-np.arange(N) / N * rng.uniform(1, 20)) + 0.001 * rng.standard_normal(N),
}
NOISES = {
    "N": lambda rng: rng.standard_normal(N), "NK": lambda rng: rng.standard_normal(N) + walk(rng, 0.01), "K": walk,
    "NR": lambda rng: rng.standard_normal(N) + 5 * np.arange(N) / N,
}  # fmt: skip


def pair(y, x):
    return al.Record(y, 10.0, "deg/h", name="gx"), al.Record(x, 10.0, "degC", name="temp")


@pytest.mark.ensemble
@rows("noise, kind", paired(list(NOISES), list(TEMPERATURES)))
def test_independent_drifts_are_not_taken_for_one(noise, kind):
    """At most 1 % of false alarms: 0 to 3 of 100, none of 20."""
    count = examples(100)
    each = map(np.random.default_rng, range(count))
    assert sum(follows(*pair(NOISES[noise](rng), TEMPERATURES[kind](rng))).clear for rng in each) <= count // 30


@pytest.mark.ensemble
@rows("kind", TEMPERATURES)
def test_what_follows_is_found(kind):
    found, records = 0, examples(20)
    for seed in range(records):
        rng = np.random.default_rng(seed)
        x = TEMPERATURES[kind](rng)
        found += follows(*pair(rng.standard_normal(N) + walk(rng, 0.001) - x / x.std(), x)).clear
    assert found >= 0.9 * records - 1


def test_lost_readings_are_left_out():
    rng = np.random.default_rng(1)
    x = walk(rng)
    y = x + rng.standard_normal(N)
    y[::7] = y[3000:3400] = np.nan
    assert follows(*pair(y, x)).clear
    y[2000:9000] = np.nan
    assert follows(*pair(y, x)) is None


@rows("y, x", [
    (NOISES["NK"](np.random.default_rng(1)), np.zeros(N)), (NOISES["NK"](np.random.default_rng(1)), np.arange(N) * 0.1),
    (np.arange(500.0) % 7, np.arange(500.0) % 11),
], ids=["constant", "line", "short"])  # fmt: skip
def test_a_column_without_a_course_of_its_own_and_a_short_record_are_not_asked(y, x):
    assert follows(*pair(y, x)) is None
