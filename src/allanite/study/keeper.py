"""One channel after its inspection; of one that is read in parts, the sums of curves, identification and spectrum."""

from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.choices import ChoiceRow, choices_of
from allanite.core.curve import Curve, DerivedLaw
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.plain import Header
from allanite.core.ranges import demand_pieces
from allanite.core.record import Record
from allanite.core.validity import Quality
from allanite.identification.checks.contradiction import MeasuredCurve
from allanite.identification.search.identify import Pending
from allanite.phrases.phrase import join, say, spelled
from allanite.statistics.spectra.estimators import Periodograms, Raw
from allanite.stream.accumulator import Accumulator, streamable
from allanite.stream.coefficients import grid, search_in

from .recipe import Recipe

Taus = str | tuple[float, ...]

WHOLE = "a record that is read in parts has"  # how messages about what needs the whole record begin

NEAR = 1e-3  # relative difference of averaging times that are the same; the sampling rate is known only at the end

STRIDES = say("the variances are exact: up to 15 samples from all windows, at m = q 2^k, q = 8 .. 15, from those that "
              "start every 2^k samples, which costs at most 1 % of the accuracy")  # fmt: skip
"""The note about the curves."""


def needing_all(settings: Any) -> Iterator[tuple[ChoiceRow, Any]]:
    """The choices with their values that do not work where only sums of a record are kept."""
    for name, row in choices_of(type(settings)).items():
        value = getattr(settings, name)
        if row.parts is not None and value is not None and value not in row.parts:
            yield row, value


class Keeper:
    """What is kept of the steps of a channel: sums of curves, of the identification, and of a spectrum."""

    def __init__(self, head: Record, statistics: Sequence[str] = (), spectrum: Periodograms | None = None) -> None:
        for name in statistics:
            if name not in streamable():
                raise UsageError(f"{WHOLE} no {name!r}: choose one of {', '.join(streamable())}, or allow more memory "
                                 f"with {spelled('--memory', 'memory=')}")  # fmt: skip
        kind = "increment" if head.integrated else head.kind
        self.head, self.spectrum, self.wanted = head, spectrum, len(dict.fromkeys(statistics))
        self.streams = [
            Accumulator(head.rate, head.unit, kind, scale=head.scale, name=head.name, statistic=name)
            for name in (dict.fromkeys((*statistics, "oadev")) if statistics else ())  # by which the fit is judged
        ]
        self.clean: Accumulator | None = None

    @property
    def _all(self) -> list[Accumulator]:
        return [*self.streams, *([self.clean] if self.clean else [])]

    def push(self, steps: FloatArray, at: IntArray) -> None:
        """Add steps that follow the last ones, of which those `at` some places are left out of the identification."""
        if at.size and self.streams and self.clean is None:
            self.clean = deepcopy(self.streams[0])
        for stream in self.streams:
            stream.push(steps)
        if self.clean is not None:
            marked = steps.copy()
            marked[at] = np.nan
            self.clean.push(marked)
        if self.spectrum is not None:
            self.spectrum.push(steps)

    def skip(self, samples: int) -> None:
        """Go on after missing samples."""
        for stream in self._all:
            stream.skip(samples)
        if self.spectrum is not None:
            self.spectrum.end()

    def at_rate(self, rate: float) -> None:
        """Take the sampling rate that is known at the end."""
        self.head = replace(self.head, rate=rate)
        for stream in self._all:
            stream.like = replace(stream.like, rate=rate)

    def search(self, recipe: Recipe) -> Pending:
        """The search for the noise, without the outliers that were left out."""
        masks = demand_pieces(recipe.mask, "Hz") if recipe.mask else ()
        return search_in(self.clean or self.streams[0], recipe.terms, band=recipe.band, masks=masks)

    def measured(self, fit: Fit) -> MeasuredCurve:
        """The Allan deviation, by which a fit is judged."""
        curve = next(stream for stream in self.streams if stream.row.name == "oadev").curve(fit)
        return MeasuredCurve(chosen(curve, "octave"), lambda m: chosen(curve, "log", tuple(m.tolist())))

    def curves(self, noise: Fit | None, taus: Taus, m: tuple[int, ...] | None = None) -> tuple[Curve, ...]:
        """The curve of each statistic, with intervals under a noise."""
        return tuple(chosen(stream.curve(noise), taus, m) for stream in self.streams[: self.wanted])

    def raw(self) -> Raw:
        """The densities."""
        assert self.spectrum is not None  # noqa: S101 - asked for only if it was wanted
        return self.spectrum.raw(self.head.rate, self.head.rate_factor)


@dataclass(frozen=True, eq=False)
class Inspected:
    """One channel after its inspection: records that are processed together, or the keeper of one read in parts."""

    name: str
    headed: tuple[Record | Header, ...]
    qualities: tuple[Quality, ...]
    keeper: Keeper | None = None
    finish: Callable[[], Fit] | None = None
    beside: frozenset[str] = frozenset()  # signals of the channels that several processes share

    @property
    def records(self) -> tuple[Record, ...]:
        """The records, which are in memory."""
        return tuple(each for each in self.headed if isinstance(each, Record))

    @property
    def record(self) -> Record:
        """The first record."""
        return self.records[0]

    @property
    def first(self) -> Record | Header:
        """The first record, or its header."""
        return self.headed[0]

    @property
    def quality(self) -> Quality:
        """The findings about the first record."""
        return self.qualities[0]

    @property
    def alerts(self) -> tuple[str, ...]:
        """The findings to report with the results, with the number of the record if there are several."""
        return tuple(join("", (which, str(finding))) for which, q in self.numbered for finding in q.warnings)

    @property
    def numbered(self) -> list[tuple[str, Quality]]:
        """The findings about each record, and their prefix: the number of the record if there are several."""
        many = len(self.headed) > 1
        return [(say("record {number}: ", number=i) if many else "", q) for i, q in enumerate(self.qualities, 1)]


def chosen(curve: Curve, taus: Taus, m: tuple[int, ...] | None = None) -> Curve:
    """The points of a curve that are asked for."""
    if m is None and isinstance(taus, str):
        some = np.ones(curve.m.size, bool) if taus == "log" else (curve.m & (curve.m - 1)) == 0
        at = np.flatnonzero(some)
    else:
        factors = m if m is not None else tuple(round(tau * curve.rate) for tau in map(float, taus))
        for factor in factors:
            if factor not in curve.m:
                raise UsageError(_not_there(factor, curve.m, ""))
        at = np.flatnonzero(np.isin(curve.m, factors))
    parts = {name: getattr(curve, name)[at] for name in ("m", "tau", "variance", "count", "factor")}
    return replace(curve, **parts, law=None if curve.law is None else DerivedLaw((curve.law,), itemgetter(at)))


def demand_sums(settings: Any) -> None:
    """Refuse the choices of a recipe, or of a job, that need the whole record."""
    more = spelled("--memory", "memory=")
    for choice, value in needing_all(settings):
        option, usual = spelled(choice.options[0], choice.name), [each for each in choice.parts or () if each]
        if usual:
            raise UsageError(f"{WHOLE} no {option} {value!r}: only {usual[0]!r}, or allow more memory with {more}")
        raise UsageError(f"{WHOLE} no {option}: omit it, or allow more memory with {more}")


def demand_grid(taus: Taus, m: tuple[int, ...] | None, rate: float) -> None:
    """Refuse, before the file is read, averaging times that a record read in parts does not have."""
    if m is None and isinstance(taus, str):
        if taus not in ("log", "octave"):
            wanted = spelled("--taus", "taus=")
            raise UsageError(f"{WHOLE} the averaging times of {wanted} log or octave, or some of these, not {taus!r}")
        return
    q, level = grid()
    known = np.unique(q << level)
    for factor in m or ():
        if factor not in known:
            raise UsageError(_not_there(factor, known, ""))
    for tau in () if m is not None else map(float, taus):
        factor = round(tau * rate)
        if factor not in known or abs(factor / rate - tau) > NEAR * tau:
            raise UsageError(_not_there(tau, known / rate, " s"))


def _not_there(one: float, known: IntArray | FloatArray, unit: str) -> str:
    near = known[np.argsort(np.abs(known - one))[:2]]
    return (
        f"{WHOLE} no averaging {'time' if unit else 'factor'} {one:g}{unit}; its averaging factors are 1 to 15 and 8 "
        f"to 15 times a power of 2, the nearest {' and '.join(f'{value:.9g}{unit}' for value in np.sort(near))}"
    )
