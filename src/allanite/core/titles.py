"""Names and meanings of noise terms by the type of sensor."""

from collections.abc import Callable

from allanite.terms import TERMS

from .language import say
from .units import Signal

_TITLES: dict[str, Callable[[str], str]] = {
    "Q": lambda quantity: say("white noise of the integrated {quantity}", quantity=quantity),
    "N": lambda quantity: say("white noise of the {quantity}", quantity=quantity),
    "B": lambda quantity: say("flicker of the {quantity}", quantity=quantity),
    "K": lambda quantity: say("random walk of the {quantity}", quantity=quantity),
    "R": lambda quantity: say("ramp of the {quantity}", quantity=quantity),
    "F": lambda quantity: say("flicker of the integrated {quantity}", quantity=quantity),
    "GMA": lambda quantity: say("Gauss-Markov noise of the integrated {quantity}", quantity=quantity),
}
"""Names of terms of a quantity that is not the output of an inertial sensor: of an angle error, a voltage."""

_MEANINGS: dict[str, str] = {
    "Q": say("noise whose spectral density grows as the square of the frequency; its integral is white"),
    "N": say("white noise of the samples, among it their rounding; averaging reduces it with the square root of time"),
    "B": say("flicker (1/f) noise; the Allan deviation has a floor at 0.664 B"),
    "K": say("changes that accumulate; over a time t they have the standard deviation K sqrt(t)"),
    "R": say("a linear drift, with a sign"),
    "GM": say("exponentially correlated (first-order Gauss-Markov) noise with a time constant T"),
    "Sine": say("a sinusoid, with an amplitude and a frequency"),
    "F": say("flicker (1/f) noise of the integral"),
    "GMA": say("exponentially correlated (first-order Gauss-Markov) noise of the integral, with a time constant T"),
}


def title_of(symbol: str, signal: Signal) -> str:
    """The name of a term for its sensor: an accelerometer has a velocity random walk.

    Examples
    --------
    >>> from .units import signal_named
    >>> title_of("N", signal_named("accelerometer")), title_of("N", signal_named("angle"))
    ('velocity random walk', 'white noise of the angle')
    """
    row = TERMS[symbol]
    if signal.inertial or signal.name in row.titles or symbol not in _TITLES:
        return row.titles.get(signal.name, row.title)
    return _TITLES[symbol](signal.quantity)


def meaning_of(symbol: str, signal: Signal) -> str:
    """What a term of this sensor is, in one line.

    Examples
    --------
    >>> from .units import signal_named
    >>> meaning_of("R", signal_named("voltage"))
    'a linear drift, with a sign'
    """
    row = TERMS[symbol]
    return row.meaning if signal.inertial else _MEANINGS.get(symbol, row.meaning)
