"""Values as data sheets give them, as the fields of a target; and what a target's fields are."""

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from allanite.core.errors import AllaniteError, DataError, UnitError, UsageError
from allanite.core.files import reason
from allanite.core.model import Model, Term
from allanite.core.notation import split_quantities
from allanite.core.plain import Value, from_dict
from allanite.core.units import signal_with, unit_of
from allanite.planning.datasheets import claimed
from allanite.study.analysis import analyze
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .axes import Source
from .exports import EXPORTS, row_of_file

COEFFICIENTS = "NKBQR"
"""The terms that a value with a unit may be, by the dimension of its unit."""


def models_of(texts: Iterable[str]) -> list[Model]:
    """The noise that texts describe, by sensor: models, names of data sheets, or single values whose unit says all.

    Examples
    --------
    >>> [str(model) for model in models_of(["0.66 deg/sqrt(h)", "K 3 deg/h/sqrt(h)", "100 ug/sqrt(Hz)"])]
    ['N = 0.66 deg/sqrt(h), K = 3 deg/h/sqrt(h)', 'N = 0.05884 m/s/sqrt(h)']
    >>> [str(model) for model in models_of(["adis16470 accelerometer"])]
    ['N = 0.037 m/s/sqrt(h), B = 19.57 ug']
    """
    found: dict[str, Model] = {}
    for model in (model for text in texts for model in _described(text)):
        sensor = model.signal.name
        found[sensor] = found[sensor] + model if sensor in found else model
    return list(found.values())


def _described(text: str) -> tuple[Model, ...]:
    if text.split(maxsplit=1)[:1] and text.split(maxsplit=1)[0] in TERMS:
        return (Model(text),)
    return claimed(text) if text[:1].isalpha() else (_single(text),)


def _single(text: str) -> Model:
    quantities = split_quantities(text.split())
    if len(quantities) != 1 or not quantities[0][1]:
        raise UsageError(f"a value has the form '0.66 deg/sqrt(h)', a model 'N 0.66 deg/sqrt(h), K ...', not {text!r}")
    (value, unit), factor = quantities[0], unit_of(quantities[0][1])
    for symbol in COEFFICIENTS:
        signal = signal_with(factor.dimension, TERMS[symbol].power)
        if signal is not None and signal.inertial:
            return Model((Term(symbol, value * factor.factor, signal),))
    raise UnitError(
        f"{unit!r} is not a unit of a noise coefficient of a gyro or accelerometer; for example deg/sqrt(h), "
        "deg/s/sqrt(Hz), deg/h, deg/h/sqrt(h), ug/sqrt(Hz), ug"
    )


def load(
    files: Sequence[str], recipe: Recipe, models: Sequence[str], progress: Callable[[str, float], None] | None = None
) -> list[Source]:
    """What is to be exported: recordings are analyzed, results in JSON are read, models are taken as they are."""
    found: list[Source] = []
    for file in files:
        if not file.endswith(".json"):
            found.append(analyze(file, recipe, progress=progress))
            continue
        try:
            data = json.loads(Path(file).read_text("utf-8"))
        except OSError as error:
            raise DataError(f"{file}: {reason(error)}; check the name and the folder") from None
        except (ValueError, RecursionError):
            raise DataError(f"{file} is damaged: it is not JSON; write the result again") from None
        try:
            found.append(from_dict(data))
        except AllaniteError as error:
            raise DataError(f"{file} is no complete result of allanite ({error}); write it again") from None
    return [*found, *models_of(models)]


@dataclass(frozen=True, repr=False)
class Explanation(Value):
    """The fields of a target with their formulas, or all targets if `target` is empty."""

    _also: ClassVar = ("targets",)

    target: str = ""

    def __post_init__(self) -> None:
        if self.target:
            object.__setattr__(self, "target", row_of_file(self.target).name)

    @property
    def targets(self) -> list[dict[str, Any]]:
        """Title, fields, notes and source of each."""
        rows = [row_of_file(self.target)] if self.target else list(EXPORTS.values())
        return [
            {
                "name": row.name,
                "title": row.title,
                "fields": [
                    {"name": f.full, "sensor": f.sensor, "unit": f.unit, "formula": f.formula} for f in row.fields
                ],
                "notes": list(row.notes),
                "source": row.source,
            }
            for row in rows
        ]
