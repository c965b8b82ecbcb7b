"""Scope: the frequencies for which a noise model holds, the filter in it, its misfit, and findings about a record."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.phrases.phrase import Phrase, join, say

from .arrays import BoolArray, FloatArray
from .plain import Value

MOTION = ("moving", "body moved")  # names of the findings of motion


@dataclass(frozen=True, repr=False)
class Finding(Value):
    """A property of a record that affects the results.

    Attributes
    ----------
    name : str
        A fixed keyword for programs: "gaps", "stuck", "lines" ...
    what : str
        What was found, with numbers.
    consequence, remedy : str
        Its effect on the results, and what the user can do.
    place : (start, end) or None
        Seconds after the recording's first sample; None for the whole record.
    fatal : bool
        Whether the record cannot support the job.
    """

    name: str
    what: str
    consequence: str = ""
    remedy: str = ""
    place: tuple[float, float] | None = None
    fatal: bool = False

    def __str__(self) -> str:
        return join("; ", filter(None, (self.what, self.consequence, self.remedy)))


@dataclass(frozen=True, repr=False)
class Quality(Value):
    """The findings about a record before anything is computed."""

    findings: tuple[Finding, ...] = ()

    @property
    def refusal(self) -> str:
        """Why the record cannot support the job; empty if it can."""
        return join(". ", (str(f) for f in self.findings if f.fatal))

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """The findings to report together with the results."""
        return tuple(f for f in self.findings if not f.fatal)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the findings."""
        return tuple(f.name for f in self.findings)

    @property
    def moved(self) -> bool:
        """Whether the sensor was not at rest."""
        return not set(MOTION).isdisjoint(self.names)

    def _summary(self) -> str:
        return ", ".join(self.names) or "no findings"


Band = str | tuple[float, float]  # frequencies of a fit: "auto", "all", or a pair (low, high), Hz

EXPLAINED, APPROXIMATE, UNEXPLAINED = "explained", "approximate", "unexplained"

WEIGHS = (0.2, 3.0)
"""Averaging times times a frequency between which a vibration of this frequency matters in a deviation."""

ROUGHLY = 0.3
"""Difference from the power of the terms, as a share of it, above which a part of the spectrum is called undescribed.
"""

SETTLED = 10.0
"""Multiple of the period of a filter's cut-off beyond which it lowers a deviation by a few per cent at most."""

GRADES = (EXPLAINED, APPROXIMATE, UNEXPLAINED)  # how well a model describes a record, from best to worst


def worst(*grades: str) -> str:
    """The worst of several grades; empty ones, of methods that have no test, are ignored."""
    return max(filter(None, grades), key=GRADES.index, default="")


def graded(grade: str, scope: "Scope | None" = None) -> Phrase:
    """A grade as text: "explained", "explained within 4 %", "explained up to 80 s", "not explained"."""
    if grade == UNEXPLAINED:
        return say("not explained")
    if scope is not None and scope.misfit:
        if scope.within > ROUGHLY:
            return say("explained but for a part of the spectrum")
        return say("explained within {share:.2g} %", share=100 * max(scope.within, scope.misfit))
    if grade == APPROXIMATE and scope is not None and scope.until is not None:
        return say("explained up to {until:.3g} s", until=scope.until)
    return say("explained, with a reservation") if grade == APPROXIMATE else say("explained")


STOPPED = 0.1  # gain below which a mask is the stop band of a filter


@dataclass(frozen=True, repr=False)
class LowPass(Value):
    """A low-pass filter of the sensor output, identified from a record."""

    row: str  # its name in `FILTERS`
    title: str
    # cutoff, low, high: frequency at which the power is halved, Hz, and its 95 % interval
    cutoff: float
    low: float
    high: float
    rate: float  # sampling rate, Hz

    def words(self) -> str:
        """The filter as text: ``2nd-order low-pass, -3 dB at 25.1 Hz (24.8 .. 25.4)``."""
        where = {"filter": self.title, "cutoff": self.cutoff, "low": self.low, "high": self.high}
        if self.cutoff > self.rate / 2:
            return say("{filter}, -3 dB at {cutoff:.3g} Hz ({low:.3g} .. {high:.3g}), above half the sampling rate",
                       **where)  # fmt: skip
        return say("{filter}, -3 dB at {cutoff:.3g} Hz ({low:.3g} .. {high:.3g})", **where)

    def _summary(self) -> str:
        return self.words()


@dataclass(frozen=True, eq=False, repr=False)
class Scope(Value):
    """The frequencies for which a model holds."""

    # whether the frequencies were chosen automatically, are all of the spectrum, or were given. One of "auto", "all",
    # "asked".
    choice: str
    band: tuple[float, float]  # frequencies used by the fit, Hz
    masks: tuple[tuple[float, float], ...]  # frequencies within the band that the fit excludes, Hz
    filter: LowPass | None  # low-pass filter that is part of the model
    # misfit that the intervals allow for: RMS over cells of the spectrum, relative to the power; 0 if none
    misfit: float
    # the largest significant misfit of a cell, relative to the power; 0 if the model explains the record
    within: float
    # frequency, level: shape (bins,); frequencies of the spectrum, Hz, and the expected power relative to that of the
    # terms: the gain of the filter, and the observed ratio at excluded frequencies
    frequency: FloatArray
    level: FloatArray
    remarks: tuple[str, ...] = ()  # descriptions of what was excluded
    # longest averaging time, s, at which the deviation of the record agrees with the valid terms; None if it does at
    # all
    until: float | None = None
    # frequencies, Hz, at which vibration has most of the power: the model includes it, but it hides the terms
    disturbed: tuple[tuple[float, float], ...] = ()

    @property
    def whole(self) -> bool:
        """Whether all frequencies are used, and show nothing but the terms."""
        plain = self.filter is None and bool((self.level == 1).all())
        return self.choice == "all" or (not self.masks and plain and not self.limited)

    @property
    def limited(self) -> bool:
        """Whether the band excludes one end of the spectrum."""
        return self.choice == "asked" or self.band[0] > 0 or self.band[1] < float(self.frequency[-1])

    @property
    def unread(self) -> tuple[tuple[float, float], ...]:
        """Frequencies that the fit does not use, Hz, up to half the sampling rate."""
        low, high = self.band
        outside = [(0.0, low)] if low else []
        return (*outside, *self.masks, *([(high, math.inf)] if high < float(self.frequency[-1]) else []))

    @property
    def times(self) -> tuple[float, float]:
        """Averaging times, s, at which the deviation is that of the terms: the filter has settled, the band holds."""
        low, high = self.band
        shortest = 0.5 / high if self.limited else 0.0
        if self.filter is not None:
            shortest = max(shortest, SETTLED / self.filter.cutoff)
        return shortest, min(0.25 / low if low else math.inf, math.inf if self.until is None else self.until)

    def holds(self, tau: FloatArray) -> BoolArray:
        """At which averaging times, s, the deviation is that of the terms: `times`, without those of the masks."""
        inside = (tau >= self.times[0]) & (tau <= self.times[1])
        for low, high in (*self.masks, *self.disturbed):
            inside &= ~((tau * high > WEIGHS[0]) & (tau * low < WEIGHS[1]))
        return np.asarray(inside)

    @property
    def grade(self) -> str:
        """The grade of the spectrum: approximate if the intervals allow for a misfit."""
        return APPROXIMATE if self.misfit else EXPLAINED

    @property
    def sentences(self) -> tuple[str, ...]:
        """The assumptions beyond the terms, as text; empty if there are none."""
        words = []
        if self.filter:
            words.append(say("the samples are low-pass filtered: {filter}; the model includes the filter",
                             filter=self.filter.words()))  # fmt: skip
        if self.masks:
            excluded: dict[bool, list[str]] = {True: [], False: []}
            for low, high in self.masks:
                inside = (self.frequency >= low) & (self.frequency <= high)
                excess = self.level[inside].max(initial=0.0) > STOPPED  # power that the model does not have
                excluded[bool(excess)].append(say("{low:.3g} to {high:.3g} Hz", low=low, high=high))
            reasons = say("stop band of the filter"), say("excess power there: vibration or a resonance")
            words += [say("excluded from the fit: {where} ({why})", where=join(", ", where), why=reasons[excess])
                      for excess, where in excluded.items() if where]  # fmt: skip
        if self.limited:
            low, high = self.band
            slowest = f"{0.25 / low:.3g} s" if low else say("the whole record")
            words.append(say("the model holds from {low:.3g} to {high:.3g} Hz, that is, from {fastest:.2g} s to "
                             "{slowest}", low=low, high=high, fastest=0.5 / high, slowest=slowest))  # fmt: skip
        if self.until is not None:
            words.append(say("beyond {until:.3g} s the deviation is not that of these terms: the slower drift is not "
                             "described", until=self.until))  # fmt: skip
        return (*words, *self.remarks)

    def _summary(self) -> str:
        low, high = self.band
        words = [f"{low:.3g} to {high:.3g} Hz"]
        words += [f"without {len(self.masks)} parts"] if self.masks else []
        return ", ".join([*words, self.filter.words()] if self.filter else words)
