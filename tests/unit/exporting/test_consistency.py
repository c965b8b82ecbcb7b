"""Filters that use exported files: their errors over what they predict, by exact covariance."""

import math

import numpy as np
import pytest
from tests.reference.aided import drift, judge
from tests.rows import rows
from tests.unit.exporting.parsers import PARSERS

import aided
import allanite as al
from aided import AIDED, OUTAGES
from allanite.exporting.imported import noise_in

GYRO = al.N(0.3, "deg/sqrt(h)") + al.B(7.2, "deg/h")
BOTH = [GYRO, al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")]
RATE, AID = 100.0, math.radians(0.1)
UNAIDED = {"ros-imu", "robot-localization"}
"""Targets that do not estimate a bias: no white noise stands for one."""


@pytest.fixture(scope="module")
def truth():
    """The covariance of the gyro's mean rates, and the errors of the best filter."""
    N, B = GYRO["N"].value, GYRO["B"].value
    n = AIDED + OUTAGES[-1]
    flicker = drift(lambda t: -((B * t) ** 2) * np.log(np.where(t > 0, t, 1.0)) / np.pi, n)
    best = aided.truth(GYRO).errors(aided.filters([aided.best(GYRO)], AID), AID)[0]
    return flicker + N**2 * np.eye(n), best


def judged(name, cover, truth):
    """Predicted and actual standard deviations of the angle with the file of a target, as its filter reads it."""
    row = al.EXPORTS[name]
    text = al.export(BOTH, name, rate=RATE, cover=cover).text
    model = noise_in(text, row, RATE).gyro
    if any(t.symbol == "B" for t in model):
        found = aided.filters([aided.target(model)], AID)
        return found.sigma[0], aided.truth(GYRO).errors(found, AID)[0]
    dt = row.step or 1 / RATE
    white, decay, walk = PARSERS[name](text)["gyro"](dt)
    time = -dt / math.log(decay) if decay < 1 else math.inf
    return judge(math.sqrt(white / dt), math.sqrt(walk / dt), truth[0], time=time, aid=AID, outages=OUTAGES)


@pytest.mark.slow("seconds of analyses")
@rows("name", sorted(set(PARSERS) - UNAIDED))
def test_a_file_that_covers_is_neither_over_confident_nor_much_too_cautious(name, truth):
    predicted, actual = judged(name, (1, 1000), truth)
    ratio = actual / predicted
    assert ((ratio >= 0.7) & (ratio <= 1.1)).all(), ratio.round(2)
    assert (actual / truth[1])[:2].max() <= 1.1


def test_a_random_walk_at_its_limit_is_over_confident(truth):
    """As the files of 6 h without a cover."""
    predicted, actual = judge(GYRO["N"].value, al.K(14, "deg/h/sqrt(h)").value, truth[0], aid=AID, outages=OUTAGES)
    assert (actual / predicted).max() > 1.5


@rows("time", [math.inf, 200.0])
def test_filters_of_the_benchmark_are_those_of_the_referee(time, truth):
    N, K = GYRO["N"], al.K(40, "deg/h/sqrt(h)")
    decaying = al.Term("GM", K.value * math.sqrt(time / 2), K.signal, (time,))
    found = aided.filters([aided.target(al.Model((N, K if time == math.inf else decaying)))], AID)
    predicted, actual = judge(N.value, K.value, truth[0], time=time, aid=AID, outages=OUTAGES)
    assert found.sigma[0] == pytest.approx(predicted, rel=1e-9)
    assert aided.truth(GYRO).errors(found, AID)[0] == pytest.approx(actual, rel=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_simulated_errors_are_those_of_the_covariance():
    """Of 1 000 runs within four standard errors, for a drift, a stationary noise, and an accurate aid."""
    model = GYRO + al.GM(10, "deg/h", time_constant=100.0)
    rng, found = np.random.default_rng(11), aided.filters([aided.target(GYRO)], AID)
    rates, angles = aided.noise(model, 1000, rng)
    errors = angles + rates @ found.past[0].T + AID * rng.standard_normal(rates.shape) @ found.aid[0].T
    ratio = np.sqrt(np.mean(errors**2, axis=0)) / aided.truth(model).errors(found, AID)[0]
    assert abs(ratio - 1).max() < 4 / math.sqrt(2000)
