"""Scope: where a noise model holds, behind which filter, and how well."""

import math
from dataclasses import dataclass

from .arrays import FloatArray
from .errors import UsageError
from .plain import Value

Band = str | tuple[float, float]
"""Frequencies of a fit: "auto", "all", or two of them, Hz."""

EXPLAINED, APPROXIMATE, UNEXPLAINED = "explained", "approximate", "unexplained"

SETTLED = 10.0
"""Periods of a filter's cut-off after which it no longer lowers a deviation by more than a few per cent."""

GRADES = (EXPLAINED, APPROXIMATE, UNEXPLAINED)
"""How well a model describes a record, the best first."""


def worst(*grades: str) -> str:
    """The worst of several grades; empty ones, of methods that do not say, do not count."""
    return max(filter(None, grades), key=GRADES.index, default="")


def graded(grade: str, scope: "Scope | None" = None) -> str:
    """A grade in words: "explained", "explained within 4 %", "explained, with a reservation", "not explained"."""
    if grade == UNEXPLAINED:
        return "not explained"
    if scope is not None and scope.misfit:
        return f"explained within {100 * scope.within:.2g} %"
    return "explained, with a reservation" if grade == APPROXIMATE else grade


def demand_band(band: object) -> None:
    """Make sure that a band is one.

    Raises
    ------
    UsageError
        It is neither "auto" nor "all" nor two frequencies.
    """
    numbers = isinstance(band, (tuple, list)) and len(band) == 2 and all(isinstance(f, (int, float)) for f in band)
    if band not in ("auto", "all") and not numbers:
        raise UsageError(f"a band is 'auto', 'all' or two frequencies in Hz, not {band!r}")


STOPPED = 0.1
"""Level below which a mask is the stop band of a filter."""


@dataclass(frozen=True, repr=False)
class LowPass(Value):
    """A low-pass filter before the readings, found in a record.

    Attributes
    ----------
    row : str
        Its name in `FILTERS`.
    title : str
    cutoff, low, high : float
        Frequency at which the power is halved, Hz, and its 95 % limits.
    rate : float
        Sampling rate, Hz.
    """

    row: str
    title: str
    cutoff: float
    low: float
    high: float
    rate: float

    def words(self) -> str:
        """In words: ``2nd-order low-pass, -3 dB at 25.1 Hz (24.8 .. 25.4)``."""
        folded = ", above half the sampling rate" if self.cutoff > self.rate / 2 else ""
        return f"{self.title}, -3 dB at {self.cutoff:.3g} Hz ({self.low:.3g} .. {self.high:.3g}){folded}"

    def _summary(self) -> str:
        return self.words()


@dataclass(frozen=True, eq=False, repr=False)
class Scope(Value):
    """Where a model holds.

    Attributes
    ----------
    choice : {"auto", "all", "asked"}
        Whether the frequencies were found, were all there are, or were given.
    band : (low, high)
        Frequencies that the fit reads, Hz.
    masks : tuple of (low, high)
        Frequencies within the band that it leaves out, Hz.
    filter : LowPass or None
        A part of the model.
    misfit : float
        Misfit that is allowed for in the limits: rms over cells of the spectrum, as a share of the power; 0 if none is.
    within : float
        The largest misfit of a cell beyond chance, as a share of the power; 0 if the model explains the record.
    frequency, level : arrays, shape (bins,)
        Frequencies of the spectrum, Hz, and the power expected there over that of the terms: the gain of the filter,
        and where the fit does not read, what was observed.
    remarks : tuple of str
        What lies outside, in words.
    """

    choice: str
    band: tuple[float, float]
    masks: tuple[tuple[float, float], ...]
    filter: LowPass | None
    misfit: float
    within: float
    frequency: FloatArray
    level: FloatArray
    remarks: tuple[str, ...] = ()

    @property
    def whole(self) -> bool:
        """Whether all frequencies are read, without a filter."""
        return self.choice == "all" or (not self.masks and self.filter is None and not self.limited)

    @property
    def limited(self) -> bool:
        """Whether the band leaves out one end of the spectrum."""
        return self.choice == "asked" or self.band[0] > 0 or self.band[1] < float(self.frequency[-1])

    @property
    def unread(self) -> tuple[tuple[float, float], ...]:
        """Frequencies that the fit does not read, Hz, up to half the sampling rate."""
        low, high = self.band
        outside = [(0.0, low)] if low else []
        return (*outside, *self.masks, *([(high, math.inf)] if high < float(self.frequency[-1]) else []))

    @property
    def times(self) -> tuple[float, float]:
        """Averaging times at which a deviation is that of the terms, s: the filter has settled, the band holds them."""
        low, high = self.band
        shortest = 0.5 / high if self.limited else 0.0
        if self.filter is not None:
            shortest = max(shortest, SETTLED / self.filter.cutoff)
        return shortest, 0.25 / low if low else math.inf

    @property
    def grade(self) -> str:
        """Of the fit to the spectrum, where it reads."""
        return APPROXIMATE if self.misfit else EXPLAINED

    @property
    def sentences(self) -> tuple[str, ...]:
        """What was supposed beside the terms, in words; none if nothing was."""
        said = (
            [f"the readings are low-pass filtered: {self.filter.words()}; the model includes it"] if self.filter else []
        )
        if self.masks:
            out = [(f"{low:.3g} to {high:.3g} Hz", self._loud(low, high)) for low, high in self.masks]
            loud, stop = ([where for where, one in out if one is kind] for kind in (True, False))
            reasons = (
                (loud, "the power stands out there: vibration or a resonance"),
                (stop, "stop band of the filter"),
            )
            said += [f"left out of the fit: {', '.join(where)} ({why})" for where, why in reasons if where]
        if self.limited:
            low, high = self.band
            slowest = f"{0.25 / low:.3g} s" if low else "the whole record"
            said.append(
                f"the model holds from {low:.3g} to {high:.3g} Hz, that is from {0.5 / high:.2g} s to {slowest}"
            )
        return (*said, *self.remarks)

    def _loud(self, low: float, high: float) -> bool:
        """Whether a mask leaves out power that the model does not have."""
        inside = (self.frequency >= low) & (self.frequency <= high)
        return bool(self.level[inside].max(initial=0.0) > STOPPED)

    def _summary(self) -> str:
        low, high = self.band
        said = [f"{low:.3g} to {high:.3g} Hz"]
        said += [f"without {len(self.masks)} parts"] if self.masks else []
        return ", ".join([*said, self.filter.words()] if self.filter else said)
