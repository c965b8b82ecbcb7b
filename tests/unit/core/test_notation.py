"""Models as text."""

from tests.rows import refused, rows

import allanite as al


@rows("text, model", [
    ("N 0.003 deg/sqrt(h)", al.Model((al.N(0.003, "deg/sqrt(h)"),))),
    ("Q=0.2arcsec, R = -1e-3 deg/h/s", al.Q(0.2, "arcsec") + al.R(-1e-3, "deg/h/s")),
    ("GM 1 deg/h 2 min, GM 1 deg/h 3", al.GM(1, "deg/h", time_constant=120) + al.GM(1, "deg/h", time_constant=3)),
    ("Sine 3 deg/h 0.5Hz", al.Model((al.Sine(3.0, "deg/h", frequency=0.5),))),
])  # fmt: skip
def test_what_people_write(text, model):
    assert al.Model(text) == model


def test_what_is_printed_is_understood():
    model = al.N(1.0, "deg/sqrt(h)") + al.Sine(1.0, "deg/h", frequency=2.0, phase=0.5)
    model += al.GM(1.0, "deg/h", time_constant=3.0) + al.R(-0.5, "deg/h^2")
    assert al.Model(str(model)) == model


@rows("text, words", [
    ("", "there is no term in ''"),
    ("X 3 deg/h", rf"unknown term 'X' in 'X 3 deg/h'; known terms: {', '.join(al.terms.TERMS)}; a model has the form"),
    ("N 3", "N must be followed by a number and a unit"), ("N three deg", "expected a number instead of 'three'"),
    ("N 1 deg/h", "is not a unit of N"), ("GM 0.1 deg/h", "GM has time_constant in s"),
    ("N 1 deg/sqrt(h) 3 s", "is not a noise term"), ("GM 0.1 deg/h 3 deg", "cannot be converted"),
    ("N 1 deg/sqrt(h), N 2 deg/sqrt(h)", "may occur once"),
])  # fmt: skip
def test_what_is_refused(text, words):
    refused(al.UsageError, words, lambda: al.Model(text))


def test_typical_sensors():
    for name in al.planning.SENSORS:
        assert al.sensor(name.upper()).signal.name == "gyro"
    refused(al.UsageError, "known sensors: mems, fog, rlg", lambda: al.sensor("hrg"))
