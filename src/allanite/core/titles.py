"""Names and meanings of noise terms by the type of sensor."""

from allanite.phrases.phrase import say
from allanite.terms import TERMS

from .units import Signal


def title_of(symbol: str, signal: Signal) -> str:
    """The name of a term for its sensor: an accelerometer has a velocity random walk.

    Examples
    --------
    >>> from .units import signal_named
    >>> title_of("N", signal_named("accelerometer")), title_of("N", signal_named("angle"))
    ('velocity random walk', 'white noise of the angle')
    """
    row = TERMS[symbol]
    if signal.inertial or signal.name in row.titles or not row.quantity_title:
        return row.titles.get(signal.name, row.title)
    return say(row.quantity_title, quantity=signal.quantity)


def meaning_of(symbol: str, signal: Signal) -> str:
    """What a term of this sensor is, in one line.

    Examples
    --------
    >>> from .units import signal_named
    >>> meaning_of("R", signal_named("voltage"))
    'a linear drift, with a sign'
    """
    row = TERMS[symbol]
    return row.meaning if signal.inertial else row.quantity_meaning or row.meaning
