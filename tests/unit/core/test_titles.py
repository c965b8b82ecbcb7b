"""Names of noise terms by the type of sensor."""

from tests.rows import rows

from allanite.core.kinds import title_of
from allanite.core.units import SIGNALS, signal_named
from allanite.phrases.phrase import Phrase
from allanite.terms import TERMS


@rows("symbol, signal, title", [
    ("N", "gyro", "angle random walk"), ("N", "accelerometer", "velocity random walk"),
    ("K", "accelerometer", "acceleration random walk"), ("R", "dimensionless", "signal ramp"),
    ("N", "voltage", "white noise of the voltage"), ("B", "flux density", "flicker of the flux density"),
    ("B", "angle", "flicker of the angle"), ("B", "accelerometer", "bias instability"),
    ("N", "angle", "white noise of the angle"), ("K", "angle", "random walk of the angle"),
    ("R", "temperature", "ramp of the temperature"),
])  # fmt: skip
def test_a_term_is_called_after_what_the_sensor_measures(symbol, signal, title):
    assert title_of(symbol, signal_named(signal)) == title


def test_every_title_can_be_translated():
    assert all(isinstance(title_of(symbol, signal), Phrase) for symbol in TERMS for signal in SIGNALS)
