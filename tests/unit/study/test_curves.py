"""The curve of a record under its own noise: what its limits suppose, and when that is found out."""

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.study import curves
from allanite.study.survey import Deviations, TheorySettings, expected_curves

GYRO = al.Model("N = 0.1 deg/sqrt(h), K = 0.5 deg/h/sqrt(h)")


def simulated(size=4096):
    return al.simulate(GYRO, size, 1.0, rng=np.random.default_rng(3), name="z")


def test_limits_are_those_of_the_identified_noise():
    record = simulated()
    fit = al.identify(record)
    curve, same = al.deviation(record), al.deviation(record, noise=fit)
    np.testing.assert_array_equal(curve.interval(0.9), same.interval(0.9))
    assert curve.supposed == same.supposed
    symbols = ", ".join(s for s in al.terms.TERMS if s in {term.symbol for term in fit.averaged.terms})
    averaged = f"intervals averaged over {len(fit.averaged)} models of {symbols}"
    assert curve.supposed == f"{averaged} identified from the record"


def test_the_noise_is_identified_when_limits_are_asked_for_and_once(monkeypatch):
    calls = []
    monkeypatch.setattr(curves, "identify", lambda record: calls.append(record) or al.identify(record))
    curve = al.deviation(simulated(), "oadev").to("deg/h")
    assert (curve.deviation.size > 0, len(calls)) == (True, 0)
    assert np.all(curve.interval()[1] > curve.interval(0.68)[1])
    assert (curve.supposed != "", len(calls)) == (True, 1)
    al.deviation(simulated(), "theo1", m=[1000], bias="exact").interval()
    assert len(calls) == 2


def test_limits_of_a_hybrid_are_those_of_its_bias_under_the_noise_and_its_value_is_the_definition():
    record = simulated()
    plain, moved = (al.deviation(record, "theobr", m=[100, 2000], bias=bias) for bias in (None, "model"))
    np.testing.assert_array_equal(plain.variance, al.deviation(record, "theobr", m=[100, 2000], noise=None).variance)
    assert np.abs(plain.variance / moved.variance - 1).max() > 1e-3
    np.testing.assert_allclose(plain.interval(), moved.interval(), rtol=1e-6)


STEPS = np.repeat(np.random.default_rng(1).standard_normal(200), 8)


@rows("values, unit, why", [
    (STEPS[:100:2], "deg/h", "too few"), (np.ones(500), "deg/h", "never changes"),
    (STEPS, "deg/h", "repeat the previous one"), (simulated().values, "1", "frequency stability"),
])  # fmt: skip
def test_what_cannot_be_identified_has_limits_of_a_power_law_and_says_why(values, unit, why):
    record = al.Record(values, rate=1.0, unit=unit, kind="rate")
    curve, automatic = al.deviation(record), al.deviation(record, noise="auto")
    np.testing.assert_array_equal(curve.interval(), automatic.interval())
    assert curve.supposed.startswith(automatic.supposed + ": the noise was not identified")
    assert why in curve.supposed


@rows(("noise", "words"), [
    (al.N(0.1, "deg/sqrt(h)"), "intervals under the given model N = 0.1 deg/sqrt(h)"),
    ("auto", "intervals for the power law identified at each averaging time"),
    (None, ""),
])  # fmt: skip
def test_a_curve_says_what_its_limits_suppose(noise, words):
    assert al.deviation(simulated(), noise=noise).supposed == words


@pytest.mark.slow("takes more than half a second")
def test_a_fit_that_explains_nothing_is_named_as_such():
    record = simulated()
    wandering = record.with_values(record.values + 1e-3 * np.sin(np.arange(4096) ** 1.4 / 40), "shaken")
    fit = al.identify(wandering, terms="N")
    assert fit.validity == "unexplained"
    assert al.deviation(wandering, noise=fit).supposed.endswith(", which does not explain the record")


def test_an_unknown_noise_is_refused():
    words = "'identified', 'auto' or None, not 'known'"
    refused(al.UsageError, words, lambda: al.deviation(simulated(), noise="known"))


@rows("length, rate, end", [
    ({"duration": 600.0}, None, "until=600"), ({"samples": 500}, 10.0, "until=50"),
    ({"samples": 500}, None, "until=TIME"),
])  # fmt: skip
def test_the_length_of_a_model_is_not_that_of_a_recording(length, rate, end):
    choices = TheorySettings(**length), Deviations(("oadev",)), al.Recipe(rate=rate)
    refused(al.UsageError, end, lambda: expected_curves(simulated(), *choices))
