"""Files that cover: above the noise everywhere on the span, honest without aid, and never wider than need be."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.commands import run
from tests.rows import paired, rows

import allanite as al
from allanite.exporting.cover import SETTLED
from allanite.exporting.stated_noise import Outages

GYRO = al.Model("N 0.3 deg/sqrt(h), B 7.2 deg/h")
ACCELEROMETER = al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")
NOISES = {
    "flicker": GYRO,
    "Gauss-Markov": al.Model("N 0.3 deg/sqrt(h), GM 10 deg/h 200 s"),
    "flicker and a walk": GYRO + al.Model("K 20 deg/h/sqrt(h)"),
    "flicker and Gauss-Markov": al.Model("N 0.3 deg/sqrt(h), B 5 deg/h, GM 10 deg/h 100 s"),
    "a ramp": al.Model("N 0.3 deg/sqrt(h), B 2 deg/h, R 20 deg/h^2"),
    "quantization": al.Model("Q 2 arcsec, N 0.03 deg/sqrt(h), B 0.7 deg/h"),
}
DRIFTING = sorted(name for name, row in al.exporting.EXPORTS.items() if row.drifts)


def covered(target, noise, span=(1, 1000), **more):
    return al.export([noise, ACCELEROMETER], target, rate=100.0, cover=span, **more).stated[0]


@rows("target, noise", paired(DRIFTING, list(NOISES.values())))
def test_a_file_lies_above_the_noise_and_predicts_no_less_than_it_errs(target, noise):
    """As read back from the file, whatever its units and its rate."""
    found = covered(target, noise)
    tau = np.geomspace(1, 1000, 200)
    own = al.expected(found.model, "oadev", tau) / al.expected(noise, "oadev", tau)
    assert own.min() > 0.995
    assert found.lowest[0] == pytest.approx(math.sqrt(own.min()), abs=2e-3)
    assert (found.actual / found.predicted).max() < 1.01


def test_flicker_is_covered_by_the_closed_form():
    """K = sqrt(3) (0.664 B)^2 / (2 sqrt(N'^2 - N^2)), which touches the curve where both terms are equal."""
    N, B = (GYRO[symbol].value for symbol in "NB")
    model = covered("kalibr", GYRO).model
    wide, walk = (model[symbol].value for symbol in "NK")
    closed = math.sqrt(3) * (2 * math.log(2) / math.pi) * B**2 / (2 * math.sqrt(wide**2 - N**2))
    assert walk == pytest.approx(closed, rel=2e-3)


def test_what_has_its_fields_is_left_as_it_is():
    noise = al.Model("N 0.3 deg/sqrt(h), K 3 deg/h/sqrt(h)")
    found = covered("kalibr", noise)
    assert (str(found.model), found.actual) == (str(noise), pytest.approx(found.best, rel=1e-6))


def test_of_all_that_cover_it_costs_least():
    """No other N' with the smallest K that covers predicts errors nearer to those of the best filter after 10 s."""
    found = covered("kalibr", GYRO)
    late = found.times >= SETTLED
    outages = Outages(tuple(found.times))
    least = (found.predicted / found.best)[late].max()
    for factor in np.geomspace(1.02, 6, 30):
        wide = factor * GYRO["N"].value
        walk = math.sqrt(max(3 * (al.expected(GYRO, "oadev", found.tau) - wide**2 / found.tau) / found.tau))
        other = outages.of(al.Model((al.Term("N", wide, GYRO.signal), al.Term("K", walk, GYRO.signal))))
        predicted = np.sqrt(other.errors(outages.weights(other)))
        assert (predicted / found.best)[late].max() > 0.99 * least


def test_a_shorter_span_costs_less():
    wide = [covered("kalibr", GYRO, (1, high)).model["N"].value for high in (30, 100, 300, 1000)]
    assert wide == sorted(wide)
    assert wide[0] < 0.65 * wide[-1]


@settings(max_examples=25, deadline=None)
@given(st.floats(0.05, 2), st.floats(0.1, 30), st.floats(0.1, 60), st.floats(0.5, 30), st.floats(1.5, 3))
def test_any_noise_is_covered_on_any_span(N, B, K, low, decades):
    noise = al.Model(f"N {N} deg/sqrt(h), B {B} deg/h, K {K} deg/h/sqrt(h)")
    found = covered("vins-mono", noise, (low, low * 10**decades))
    assert found.lowest[0] > 0.999
    assert (found.actual / found.predicted).max() < 1.001


@pytest.fixture(scope="module")
def study():
    noise = al.simulate(GYRO, 200_000, rate=10.0, rng=np.random.default_rng(3), name="gx")
    return al.analyze(noise)


def test_the_upper_limits_of_a_record_are_covered(study):
    (found,) = (one for one in al.export([study, ACCELEROMETER], "kalibr", cover=True).stated if one.channels)
    (channel,) = study
    high = channel.curve.interval(0.95)[1]
    near = (channel.curve.tau > 1) & (channel.curve.tau < 2000)
    upper = np.interp(np.log(channel.curve.tau[near]), np.log(found.tau), found.upper)
    assert found.span == pytest.approx((1, 2000))
    assert (found.upper >= found.identified).all()
    assert (upper < 1.02 * high[near]).all()
    assert found.lowest[0] == pytest.approx(1, abs=1e-3)


@rows(
    ("target", "cover", "covers"),
    [("kalibr", None, True), ("kalibr", False, False), ("px4", None, True), ("gazebo", None, False),
     ("gazebo", True, True), ("matlab", None, False), ("pegasus", None, False)],
)  # fmt: skip
def test_a_filter_is_given_a_cover_where_it_has_no_field_and_a_simulator_what_was_found(study, target, cover, covers):
    made = al.export([study, ACCELEROMETER], target, cover=cover)
    found = next(one for one in made.stated if one.channels)
    assert found.covers is covers
    if covers:
        assert "gx: covers the noise from 1 to 2000 s" in made.text
        return
    assert ("gx: the Allan deviation of this file is 0." in made.text) is (target != "matlab")  # it has flicker
    costs = [alert for alert in made.alerts if "a filter errs" in alert]
    assert len(costs) == (target == "kalibr")  # the others simulate
    assert all(re.search(r"errs up to 2\.\d times what it predicts with this file$", cost) for cost in costs)
    assert all(cost in made.text for cost in costs)


def test_the_bias_instability_of_a_data_sheet_is_covered_by_convert():
    """No formula makes a random walk of it; a cover does."""
    found = run("convert", "0.3 deg/sqrt(h)", "7.2 deg/h", "N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)", "--to", "openvins",
                "--rate", "100", "--cover", "1,300", "--json", "-")  # fmt: skip
    values = {entry["name"]: entry for entry in json.loads(found.stdout)["entries"]}
    assert values["gyroscope_random_walk"]["remark"] == "covers B 7.2 deg/h from 1 to 300 s"
    assert values["gyroscope_random_walk"]["identified"] == []
    assert values["gyroscope_noise_density"]["identified"] == [pytest.approx(8.7266e-5, rel=1e-4)]
    assert values["accelerometer_random_walk"]["values"] == [pytest.approx(3.268883e-06)], "as it was given"


@rows(
    ("words", "span"),
    [(["--cover", "--to", "kalibr"], (1, 1000)), (["--to", "kalibr", "--cover"], (1, 1000)),
     (["--cover", "5,50", "--to", "kalibr"], (5, 50)), (["--to", "kalibr", "--cover=10 s,1 h"], (10, 3600)),
     (["--to", "kalibr", "--cover", "0.3 deg/sqrt(h)"], (1, 1000))],
)  # fmt: skip
def test_the_span_may_be_omitted(words, span):
    values = ["7.2 deg/h", *([] if "0.3 deg/sqrt(h)" in words else ["0.3 deg/sqrt(h)"]), "N 60 ug/sqrt(Hz), B 9 ug"]
    found = run("convert", *values, *words, "--rate", "100", "--json", "-", code=0)
    assert json.loads(found.stdout)["stated"][0]["span"] == pytest.approx(span)


@rows(
    ("target", "cover", "wrong"),
    [("kalibr", "5,1", "the shorter averaging time first"), ("kalibr", (0, 3), "two averaging times"),
     ("kalibr", "always", "two averaging times"), ("statespace", True, "takes the whole model"),
     ("ros-imu", (1, 10), "only white noise")],
)  # fmt: skip
def test_other_spans_and_targets_are_refused(target, cover, wrong):
    with pytest.raises(al.UsageError, match=wrong):
        al.export([GYRO, ACCELEROMETER], target, rate=10.0, cover=cover)


def test_the_error_without_aid_is_that_of_a_filter_in_time():
    """A Kalman filter with the angle known every second, run to its steady state, and the truth as its states."""
    model, truth = al.Model("N 0.6 deg/sqrt(h), K 30 deg/h/sqrt(h)"), al.Model("N 0.3 deg/sqrt(h), GM 10 deg/h 200 s")
    times = np.array([10.0, 60.0, 300.0])
    outages = Outages(tuple(times))
    own, true = outages.of(model), outages.of(truth)
    weights = outages.weights(own)
    N, K = (model[symbol].value for symbol in "NK")
    # the bias of a steady filter: an exponential mean of the past rates, with the time constant N / K
    predicted = N**2 * times + N * K * times**2 + K**2 * times**3 / 3
    assert own.errors(weights) == pytest.approx(predicted, rel=2e-3)
    white, markov = truth["N"].value, truth["GM"]
    rate, decay = K / N, 1 / markov.shape[0]
    ahead = (1 - np.exp(-decay * times)) / decay
    mean = rate / (rate + decay)  # correlation of the exponential mean with the rate at the end of the past
    angle = 2 * (times - ahead) / decay  # variance of the angle over that of the rate
    actual = white**2 * (times + times**2 * rate / 2) + markov.value**2 * (
        angle - 2 * times * ahead * mean + times**2 * mean
    )
    assert true.errors(weights) == pytest.approx(actual, rel=2e-3)
