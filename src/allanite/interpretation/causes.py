"""Meaning: what the coefficients of a record say, and what may cause them in a device."""

from dataclasses import dataclass
from functools import reduce

from allanite.core.fit import Fit
from allanite.core.plain import Value
from allanite.core.readings import Readings
from allanite.phrases.phrase import say

from .device import Cause
from .devices import device as named
from .sentences import sentences


@dataclass(frozen=True, repr=False)
class Meaning(Value):
    """What the coefficients of a record say.

    Attributes
    ----------
    name : str
        Of the channel.
    sentences : tuple of str
        Where white noise and drift dominate, the minimum beside the fitted flicker, systematic and random drift, time
        constants, the grade of a gyroscope. None where the model does not explain the record.
    device : str
        Name in `DEVICES`; empty where none was named.
    symbols : tuple of str
        Terms that were found and are in the device's table.
    note : str
        What must be known to read the table, or why it does not apply.
    """

    name: str
    sentences: tuple[str, ...]
    device: str = ""
    symbols: tuple[str, ...] = ()
    note: str = ""

    @property
    def causes(self) -> dict[str, Cause]:
        """The rows of the device's table for the terms that were found."""
        table = named(self.device).terms if self.device else {}
        return {symbol: table[symbol] for symbol in self.symbols}

    def _summary(self) -> str:
        return f"of {self.name!r}: {len(self.sentences)} sentences{', ' if self.device else ''}{self.device}"


def meaning(
    fit: Fit, readings: Readings | None = None, *, rate: float, length: float, device: str | None = None
) -> Meaning:
    """What the coefficients of a fit say, and what may cause them.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite import N, identify, simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 6000, 10.0, rng=np.random.default_rng(1))
    >>> found = meaning(identify(record), rate=10.0, length=600.0, device="mems")
    >>> found.causes["N"].sources[0]
    'thermo-mechanical noise, much faster than the sampling'
    """
    said = sentences(fit, readings, rate=rate, length=length)
    if device is None:
        return Meaning(fit.name, said)
    row = named(device)
    if fit.signal.name not in row.signals:
        note = say(
            "the table of {device} is about {signals} signals, not about this {sensor}",
            device=row.title,
            signals=reduce(lambda first, second: say("{first} or {second}", first=first, second=second), row.signals),
            sensor=fit.signal.name,
        )
        return Meaning(fit.name, said, device, (), note)
    there = tuple(e.symbol for e in fit if e.claimed and e.symbol in row.terms) if fit.valid is not None else ()
    return Meaning(fit.name, said, device, there, row.note)
