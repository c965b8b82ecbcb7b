"""From a value or the file of a target to coefficients, and the fields of a target."""

import json
import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from allanite.core.aliases import public
from allanite.core.errors import AllaniteError, DataError, UnitError, UsageError
from allanite.core.files import PathLike, reason
from allanite.core.model import Model, Term
from allanite.core.plain import Value, from_dict
from allanite.core.syntax import split_quantities
from allanite.core.units import signal_named, signal_with, unit_of
from allanite.phrases.phrase import spelled
from allanite.planning.datasheets import claimed
from allanite.study.analysis import analyze
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .choice import Source
from .exports import EXPORTS, row_of_file, target_named
from .target import ACCELEROMETER, GYRO, LONG, Target, TargetField

COEFFICIENTS = "NKBQR"  # the terms that a value with a unit may be, by the dimension of its unit


def models_of(texts: Iterable[str]) -> list[Model]:
    """The noise that texts describe, by sensor: models, names of data sheets, or single values whose unit says all."""
    models: dict[str, Model] = {}
    for model in (model for text in texts for model in _described(text)):
        sensor = model.signal.name
        models[sensor] = models[sensor] + model if sensor in models else model
    return list(models.values())


def _described(text: str) -> tuple[Model, ...]:
    if text.split(maxsplit=1)[:1] and text.split(maxsplit=1)[0] in TERMS:
        return (Model(text),)
    return claimed(text) if text[:1].isalpha() else (_single(text),)


def _single(text: str) -> Model:
    quantities = split_quantities(text.split())
    if len(quantities) == 1 and not quantities[0][1]:
        raise UsageError(f"{text!r} has no unit: put both into one pair of quotes, as in '0.66 deg/sqrt(h)'")
    if len(quantities) != 1 or not quantities[0][1]:
        raise UsageError(f"a value has the form '0.66 deg/sqrt(h)', a model 'N 0.66 deg/sqrt(h), K ...', not {text!r}")
    (value, unit), factor = quantities[0], unit_of(quantities[0][1])
    for symbol in COEFFICIENTS:
        signal = signal_with(factor.dimension, TERMS[symbol].power)
        if signal is not None and signal.inertial:
            return Model((Term(symbol, value * factor.factor, signal),))
    raise UnitError(f"{unit!r} is not a unit of a noise coefficient of a gyro or accelerometer; for example "
                    "deg/sqrt(h), deg/s/sqrt(Hz), deg/h, deg/h/sqrt(h), ug/sqrt(Hz), ug")  # fmt: skip


def load(
    files: Sequence[str], recipe: Recipe, models: Sequence[str], progress: Callable[[str, float], None] | None = None
) -> list[Source]:
    """What is to be exported: recordings are analyzed, results in JSON are read, models are taken as they are."""
    sources: list[Source] = []
    for file in files:
        if not file.endswith(".json"):
            sources.append(analyze(file, recipe, progress=progress))
            continue
        try:
            data = json.loads(Path(file).read_text("utf-8"))
        except OSError as error:
            raise DataError(f"{file}: {reason(error)}; check the name and the folder") from None
        except (ValueError, RecursionError):
            raise DataError(f"{file} is damaged: it is not JSON; write the result again") from None
        try:
            sources.append(from_dict(data))
        except AllaniteError as error:
            raise DataError(f"{file} is no complete result of allanite ({error}); write it again") from None
    return [*sources, *models_of(models)]


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
        return [{"name": row.name, "title": row.title,
                 "fields": [{"name": f.full, "sensor": f.sensor, "unit": f.unit, "formula": f.formula,
                             **dict(zip(("kind", "mistaken_for", "wrong_by"), f.nature, strict=True))}
                            for f in row.fields],
                 "notes": list(row.notes), "source": row.source}
                for row in ([row_of_file(self.target)] if self.target else list(EXPORTS.values()))]  # fmt: skip


_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_VALUES = rf"[\"']?[\s:=,>(]*(?:np\.array\()?\s*(?:\[\s*({_NUMBER}(?:[\s,;]+{_NUMBER})*)\s*\]|({_NUMBER}))"
_SENSORS = (GYRO, ACCELEROMETER)
_RATES = ("update_rate", "IMU.Frequency")


@dataclass(frozen=True, repr=False)
class Imported(Value):
    """Noise models from the file of a target; of a field with a value for each axis, the largest.

    Attributes
    ----------
    target : str
    gyro, accelerometer : Model or None
    rate : float or None
        Rate that the formulas used, Hz.
    times : dict of str to float
        Correlation time of the bias by sensor, s, where the file states one; it is not part of the models.
    """

    target: str
    gyro: Model | None
    accelerometer: Model | None
    rate: float | None
    times: dict[str, float] = field(default_factory=dict)

    @property
    def models(self) -> tuple[Model, ...]:
        """The models that there are."""
        return tuple(model for model in (self.gyro, self.accelerometer) if model is not None)

    @property
    def simulated(self) -> tuple[Model, ...]:
        """The models as a simulator has them: the bias is a Gauss-Markov process where a correlation time is stated.

        A random walk K whose bias is correlated over T has the standard deviation K sqrt(T/2).
        """
        return tuple(_correlated(model, self.times.get(model.signal.name, math.inf)) for model in self.models)

    def _summary(self) -> str:
        return f"from {self.target}: {'; '.join(map(str, self.models))}"


@public
def read_noise(path: PathLike, target: str, *, rate: float | None = None) -> Imported:
    """Read the noise coefficients from the file of a target.

    Parameters
    ----------
    path : path
    target : str
        A name in `EXPORTS`, of a target with fields.
    rate : float, optional
        Rate in Hz, for fields of discrete time, unless the target has its own.

    Returns
    -------
    Imported

    Raises
    ------
    UsageError
        The target is unknown or holds no coefficients, or the rate is needed.
    DataError
        The file cannot be read, or has none of the fields.
    """
    row = target_named(target)
    if not row.fields:
        raise UsageError(f"{row.name} cannot be read back: it has no fields with coefficients")
    try:
        text = Path(path).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{str(path)!r} cannot be read: {reason(error)}") from None
    return noise_in(text, row, rate, str(path))


def noise_in(text: str, target: Target, rate: float | None, name: str = "the text") -> Imported:
    """The noise in the text of a file."""
    plain = re.sub(target.comments, "", text)
    stated = next((each[0] for key in _RATES if target.rated and (each := numbers(plain, key))), None)
    rate = target.rate(stated or rate, None)
    values = {field: numbers(section_of(plain, field, target), field.name) for field in target.fields}
    if not any(values.values()):
        wanted = ", ".join(field.name for field in target.fields)
        raise DataError(f"{name!r} has none of the fields of {target.name}: {wanted}")
    if rate is None and any(each and field.rate for field, each in values.items()):
        raise UsageError(f"the fields of {target.name} are of discrete time: give the sampling rate, "
                         + spelled("--rate HZ", "rate=..."))  # fmt: skip
    # the correlation time of a sensor, or the one that both have in common, s
    own = {f.sensor: max(each) * unit_of(f.unit).factor for f, each in values.items() if each and not f.term}
    times = {sensor: own.get(sensor, next(iter(own.values()))) for sensor in _SENSORS} if own else {}
    models = [_model(sensor, values, rate or 1.0, times.get(sensor, LONG)) for sensor in _SENSORS]
    return Imported(target.name, models[0], models[1], rate, times)


def _correlated(model: Model, time: float) -> Model:
    """A model whose random walk is a Gauss-Markov process of this correlation time, unless that is very long."""
    if not 0 < time < LONG:
        return model
    return Model(tuple(Term("GM", t.value * math.sqrt(time / 2), t.signal, (time,)) if t.symbol == "K" else t
                       for t in model))  # fmt: skip


def _model(sensor: str, values: dict[TargetField, list[float]], rate: float, time: float) -> Model | None:
    largest = {f: max(each) for f, each in values.items() if each and f.sensor == sensor and f.term}
    signal = signal_named(sensor)
    terms = [Term(f.term, f.coefficient(size, rate, time), signal) for f, size in largest.items() if size > 0]
    return Model(tuple(terms)) if terms else None


def section_of(text: str, field: TargetField, target: Target) -> str:
    """The part of a file that holds a field."""
    if not field.section:
        return text
    part = text.partition(field.section)[2]
    for other in {f.section for f in target.fields} - {field.section}:
        part = part.partition(other)[0]
    return part


def numbers(text: str, name: str) -> list[float]:
    """The numbers of a field: one, or a list; empty if the field is not there."""
    match = re.search(rf"(?<![\w]){re.escape(name)}(?![\w.]){_VALUES}", text)
    return [] if match is None else [float(number) for number in re.findall(_NUMBER, match[1] or match[2])]
