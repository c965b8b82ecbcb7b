"""Records of the quantity itself: an angle error, a voltage, a temperature."""

import re

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.core.kinds import kinds_of
from allanite.core.units import SIGNALS

NUMBERS = np.random.default_rng(1).integers(-50, 50, 1000)

UNITS = {"angle": ("rad", "deg", "arcmin", "arcsec", "mrad", "rev"), "voltage": ("V", "mV"),
         "temperature": ("K", "mK", "degC"), "pressure": ("Pa", "hPa", "kPa", "mbar", "bar"),
         "displacement": ("m", "mm", "um"), "velocity": ("m/s",), "current": ("A", "mA"), "time": ("s", "ns", "h"),
         "frequency": ("Hz",), "dimensionless": ("1",), "gyro": ("deg/s",), "accelerometer": ("ug",)}  # fmt: skip


@rows(("signal", "unit"), [(name, unit) for name, units in UNITS.items() for unit in units])
def test_a_value_may_have_any_unit_of_a_signal(signal, unit):
    record = al.Record(NUMBERS, 10.0, unit, kind="value")
    assert record.signal.name == signal
    assert record.size == NUMBERS.size
    assert not record.integrated
    assert np.allclose(record.rate_values, NUMBERS * record.factor, rtol=1e-15)


@rows("unit", ["arcsec", "m/s", "s"])
def test_the_refusal_offers_every_meaning_and_each_works(unit):
    with pytest.raises(al.UsageError) as refused:
        al.Record(NUMBERS, 10.0, unit, name="az")
    said = str(refused.value)
    choices = re.findall(r"((?:kind|unit)=[^:]*): ", said)
    assert [re.sub(r".*kind='(\w+)'.*", r"\1", c) for c in choices[:-1]] == list(kinds_of(unit))
    assert {"increment", "angle", "value"} < set(kinds_of(unit))
    for choice in choices:
        given = {"unit": unit} | dict(eval(f"dict({choice.replace('...', '1.0')})"))  # noqa: S307 - what the message says, word for word
        assert al.Record(NUMBERS, 10.0, **given).duration > 0


def test_integers_with_a_scale_are_a_value_and_units_of_no_signal_are_none():
    refused(al.UsageError, "'V/s' does not fit kind 'value'", lambda: al.Record(NUMBERS, 10.0, "V/s", kind="value"))
    record = al.Record(NUMBERS, 10.0, "mV", kind="value", scale=0.25)
    assert record.values.dtype.kind == "i"
    assert record.rate_values[0] == pytest.approx(NUMBERS[0] * 0.25e-3, rel=1e-15)


def test_the_units_of_an_angle_are_those_of_its_data_sheet():
    angle = next(signal for signal in SIGNALS if signal.name == "angle")
    assert [angle.sheet[p] for p in (1, 0.5, 0, -0.5, -1)] == [
        "arcsec*s", "arcsec*sqrt(s)", "arcsec", "arcsec/sqrt(s)", "arcsec/s"
    ]  # fmt: skip
    model = al.Model("Q 1 arcsec*s, N 1 arcsec*sqrt(s), B 1 arcsec, K 1 arcsec/sqrt(s), R 1 arcsec/s")
    assert model.signal is angle
    assert al.Model(str(model)) == model
    refused(al.UnitError, "different signals", lambda: al.N(0.01, "deg/sqrt(h)") + al.R(0.1, "arcsec/s"))
