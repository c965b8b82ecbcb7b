"""Names of noise terms by the type of sensor."""

from allanite.terms import TERMS

from .units import Signal


def title_of(symbol: str, signal: Signal) -> str:
    """The name of a term for its sensor: an accelerometer has a velocity random walk.

    Examples
    --------
    >>> from .units import signal_named
    >>> title_of("N", signal_named("accelerometer")), title_of("K", signal_named("voltage"))
    ('velocity random walk', 'voltage random walk')
    """
    row = TERMS[symbol]
    return row.titles.get(signal.name, row.title)
