"""Every signal, statistic and term: the numbers are those of a rate in SI, units and names are those of the signal."""

import numpy as np
import pytest
from tests.rows import paired, rows

import allanite as al
from allanite.core.kinds import meaning_of, title_of
from allanite.core.units import SIGNALS, unit_of

VALUES = np.random.default_rng(1).standard_normal(600).cumsum()
OTHERS = [signal for signal in SIGNALS if not signal.inertial]
GYRO = SIGNALS[0]


def record(signal, values=VALUES):
    return al.Record(values, 10.0, signal.unit, kind="value", name="x")


@rows("statistic, signal", paired(al.statistics.STATISTICS, OTHERS))
def test_a_curve_is_that_of_a_rate(signal, statistic):
    row, as_rate = al.statistics.STATISTICS[statistic], al.Record(VALUES, 10.0, "rad/s")
    curve = al.deviation(record(signal), statistic, noise=None)
    same = al.deviation(as_rate, statistic, noise=None)
    assert np.array_equal(curve.variance, same.variance)
    assert curve.unit == signal.si[row.power]


@rows("symbol, signal", paired(al.terms.TERMS, OTHERS))
def test_a_term_is_that_of_a_rate(signal, symbol):
    row = al.terms.TERMS[symbol]
    shape = tuple(p.typical for p in row.parameters)
    term = al.Term(symbol, 2.0, signal, shape)
    model = al.Model(str(al.Model((term,))))
    assert model.signal is signal
    assert model[symbol].value == pytest.approx(2.0, rel=1e-3)
    assert al.Model.from_dict(al.Model((term,)).to_dict()) == al.Model((term,))
    tau = np.array([0.1, 1.0, 10.0])
    same = al.Model((al.Term(symbol, 2.0, GYRO, shape),))
    assert np.array_equal(*(al.expected(one, "oadev", tau, rate=10.0, size=300) for one in (term, same)))
    made = al.simulate(term, 300, 10.0, rng=np.random.default_rng(1))
    assert made.signal is signal
    assert made.kind == signal.kind
    assert np.array_equal(made.values, al.simulate(same, 300, 10.0, rng=np.random.default_rng(1)).values)


@rows("signal", OTHERS, ids=lambda signal: signal.name)
def test_no_term_of_another_quantity_is_named(signal):
    titles = [title_of(symbol, signal) for symbol in al.terms.TERMS]
    assert "angle random walk" not in titles
    assert not any("rate" in title.split() for title in titles)
    assert not any("angle error" in meaning_of(symbol, signal) for symbol in al.terms.TERMS)


@rows("signal", OTHERS, ids=lambda signal: signal.name)
def test_the_density_is_that_of_the_samples(signal):
    whole = record(signal, np.random.default_rng(2).standard_normal(2000))
    spectrum = al.spectrum(whole)
    assert spectrum.unit == signal.unit
    assert np.mean(spectrum.density) * whole.rate / 2 == pytest.approx(np.var(whole.values), rel=0.05)
    assert all(unit_of(unit).dimension == unit_of(signal.si[0.5]).dimension for unit in signal.density)
