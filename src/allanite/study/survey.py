"""One kind of value from every channel of a recording: curves, spectra or surfaces."""

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from allanite.core.curve import Curve
from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.record import Record, Recording
from allanite.core.spectrum import Spectrum
from allanite.core.surface import Surface
from allanite.prepare import inspect

from .analysis import Recipe, provenance_of, recording_of
from .analysis import fitted as fit_of

Value = Curve | Spectrum | Surface

Measure = Callable[[Record, Fit | None], Iterable[Value]]
"""What is done with a channel; the fit is None where none was asked for, or none could be made."""


@dataclass(frozen=True, eq=False)
class Survey:
    """What was measured of each channel.

    Attributes
    ----------
    values : tuple of Curve, Spectrum or Surface
        In the order of the channels; each carries the name of its channel.
    fits : dict
        The fit of a channel, by its name, where one was asked for and could be made.
    alerts, refusals : dict
        By name of the channel: what must be known beside its values; why it has none.
    recipe, notes, provenance
        As of a `Study`.
    """

    values: tuple[Value, ...]
    fits: dict[str, Fit]
    alerts: dict[str, tuple[str, ...]]
    refusals: dict[str, str]
    recipe: Recipe
    notes: tuple[str, ...]
    provenance: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        level = self.recipe.level
        return {
            "allanite": 1,
            "type": "Survey",
            "values": [value.to_dict(level) for value in self.values],
            "fits": {name: fit.to_dict(level) for name, fit in self.fits.items()},
            "alerts": {name: list(alerts) for name, alerts in self.alerts.items()},
            "refusals": self.refusals,
            "recipe": self.recipe.to_dict(),
            "notes": list(self.notes),
            "provenance": self.provenance,
        }


def survey(
    source: Recording | Record | str | os.PathLike[str],
    measure: Measure,
    recipe: Recipe | None = None,
    *,
    fitted: bool = False,
    progress: Callable[[str, float], None] | None = None,
) -> Survey:
    """Measure every channel of a recording.

    Parameters
    ----------
    source : Recording, Record or path
    measure : (Record, Fit or None) -> iterable of values
    recipe : Recipe, optional
        How the file is read and, with `fitted`, how the noise is identified.
    fitted : bool
        Identify the noise of each channel first. A channel that does not support it is measured without.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Raises
    ------
    DataError
        The file cannot be read, or no channel supports the measurement.
    UsageError
        An option is wrong, or one that is needed is missing.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite.statistics import deviation
    >>> record = Record(np.arange(300) % 2, rate=10.0, unit="deg/h", name="z")
    >>> found = survey(record, lambda record, fit: [deviation(record, name) for name in ("adev", "oadev")])
    >>> [(value.name, value.statistic) for value in found.values]
    [('z', 'adev'), ('z', 'oadev')]
    """
    recipe = recipe or Recipe()
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    recording = recording_of(source, recipe)
    values: list[Value] = []
    fits: dict[str, Fit] = {}
    alerts: dict[str, tuple[str, ...]] = {}
    refusals: dict[str, str] = {}
    for i, record in enumerate(recording):
        tell(f"measuring {record.name}", (i + 0.3) / (len(recording) + 0.3))
        alerts[record.name] = tuple(str(finding) for finding in inspect(record).warnings)
        if fitted:
            try:
                fits[record.name] = fit_of(record, recipe)
            except DataError as error:
                alerts[record.name] += (
                    f"the noise is not identified, and there are no limits or lines of it: {error}",
                )
        try:
            values += measure(record, fits.get(record.name))
        except DataError as error:
            refusals[record.name] = str(error)
    if not values:
        raise DataError("; ".join(f"{name or 'the record'}: {why}" for name, why in refusals.items()))
    tell("done", 1.0)
    return Survey(tuple(values), fits, alerts, refusals, recipe, recording.notes, provenance_of(recording))
