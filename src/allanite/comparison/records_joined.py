"""Preparation of records for a joint likelihood: no outliers, no sinusoids, the same terms and frequencies in each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.record import Record
from allanite.core.validity import graded
from allanite.identification.methods import symbols_of
from allanite.phrases.phrase import say
from allanite.prepare.outliers import marked, outliers
from allanite.study.noise import noise_of, without_lines
from allanite.study.recipe import Recipe
from allanite.study.results import Noise
from allanite.terms import TERMS

from .common_likelihood import Joint, Shape, common_band, demand_one_kind, joint


@dataclass(frozen=True, eq=False)
class Joined:
    """The joint likelihood of records, the noise of each, and what was done to them.

    `records` are without their outliers.
    """

    joint: Joint
    noises: tuple[Noise, ...]
    notes: tuple[str, ...]
    records: tuple[Record, ...]

    @property
    def fits(self) -> tuple[Fit, ...]:
        """The fit of each record."""
        return tuple(noise.fit for noise in self.noises)

    @property
    def explained(self) -> tuple[bool, ...]:
        """Whether each fit explains its record."""
        return tuple(noise.explained for noise in self.noises)

    @property
    def grades(self) -> tuple[str, ...]:
        """How well each fit explains its record, as text."""
        return tuple(graded(noise.validity, noise.fit.scope) for noise in self.noises)

    @property
    def alerts(self) -> tuple[str, ...]:
        """What must stand beside the numbers: models that do not explain their records, and what was done."""
        doubts = (
            say(
                "record {number}: {doubt}; a difference in what the model omits may appear as a change of one of its "
                "terms",
                number=i,
                doubt=doubt,
            )
            for i, noise in enumerate(self.noises, 1)
            for doubt in noise.doubts
        )
        return (*doubts, *self.notes)


def join_records(records: Sequence[Record], recipe: Recipe) -> Joined:
    """The joint likelihood of records of one kind of sensor.

    Outliers are omitted, and sinusoids removed as the fits found them. Where one record has a term with a shape it is
    asked of all, and compared with one shape.
    """
    demand_one_kind(records)
    _demand_different(records)
    notes: list[str] = []
    if recipe.outliers is None:
        found = [outliers(record) for record in records]
        notes = [
            say("record {number}: {outliers}: excluded from the comparison", number=i, outliers=some.words(record))
            for i, (record, some) in enumerate(zip(records, found, strict=True), 1)
            if some.at.size
        ]
        records = [marked(record, some) for record, some in zip(records, found, strict=True)]
    noises, shown = _identify_alike(records, replace(recipe, outliers="keep"))
    fits = [noise.fit for noise in noises]
    shapes = _common_shapes(fits)
    quiet = [without_lines(record, fit) for record, fit in zip(records, fits, strict=True)]
    notes += [
        say(
            "record {number}: sinusoids were removed, at {frequencies} Hz",
            number=i,
            frequencies=", ".join(f"{line.frequency:.6g}" for line in fit.lines),
        )
        for i, fit in enumerate(fits, 1)
        if fit.lines
    ]
    both = joint(quiet, shown, asked_band(recipe), shapes=shapes, scopes=[fit.scope for fit in fits])
    notes += [
        say("{term} is compared with a common shape: {shape}", term=symbol, shape=both.term(symbol, 1.0).shape_words)
        for symbol in shapes
    ]
    return Joined(both, noises, tuple(notes), tuple(records))


def _common_shapes(fits: Sequence[Fit]) -> dict[str, Shape]:
    """The shape of each term that has one in any of the fits, the geometric mean of theirs."""
    noise = [e for fit in fits for e in fit if e.shape and TERMS[e.symbol].waveform is None]
    each = {symbol: [e.shape for e in noise if e.symbol == symbol] for symbol in dict.fromkeys(e.symbol for e in noise)}
    return {symbol: tuple(np.exp(np.log(shapes).mean(axis=0)).tolist()) for symbol, shapes in each.items()}


def _demand_different(records: Sequence[Record]) -> None:
    for j, record in enumerate(records):
        for i, other in enumerate(records[:j]):
            if len(other.values) == len(record.values) and np.array_equal(
                other.values, record.values, equal_nan=other.values.dtype.kind == "f"
            ):
                alike = say(
                    "records {first} and {second} have identical samples; there is nothing to compare",
                    first=i + 1,
                    second=j + 1,
                )
                raise DataError(alike)


def asked_band(recipe: Recipe) -> tuple[float, float] | None:
    """The band that was given, Hz."""
    return None if isinstance(recipe.band, str) else recipe.band


def _identify_alike(records: Sequence[Record], recipe: Recipe) -> tuple[tuple[Noise, ...], tuple[str, ...]]:
    """The noise of each record, of the same terms, in the common band where that omits a part of one."""
    low, high = common_band(records, asked_band(recipe))
    cut = any(r.rate / 2 > high * (1 + 1e-9) or 0.75 / r.duration <= low for r in records)
    band = (low * (1 - 1e-9), high * (1 + 1e-9)) if cut else None
    symbols = [s for s in symbols_of(recipe.terms) if TERMS[s].scatters]
    noises = tuple(noise_of(record, recipe, band=band) for record in records)
    shown = tuple(dict.fromkeys((*symbols, *(e.symbol for noise in noises for e in noise.fit))))
    if len(shown) > len(symbols):
        noises = tuple(noise_of(record, recipe, terms=",".join(shown), band=band) for record in records)
    return noises, shown
