"""Regression: the part of a sensor's error that follows other channels, as a correction."""

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from allanite.core.correction import Correction
from allanite.core.errors import DataError, UsageError
from allanite.core.model import Model
from allanite.core.record import Record, Recording
from allanite.core.units import Signal, signal_named

from .gain import Gain
from .mixture import Mixture
from .regressor import Regressor
from .restricted import FloatArray

SIGNIFICANT = 0.05
"""Probability below which an effect is not put down to chance."""


@dataclass(frozen=True)
class Effect:
    """One coefficient: rate per unit of its regressor, SI.

    Attributes
    ----------
    regressor : Regressor
    value, standard_error : float
    p : float
        Probability of a coefficient as far from zero if there is no dependence; for a column that was chosen among
        several, times their number.
    low, high : float
        95 % limits.
    inflation : float
        Variance inflation factor: how much the other regressors widen its variance.
    chosen : bool
        Whether cross-validation chose the column; otherwise it was asked for.
    """

    regressor: Regressor
    value: float
    standard_error: float
    p: float
    low: float
    high: float
    inflation: float
    chosen: bool

    @property
    def label(self) -> str:
        """Name of the column."""
        return self.regressor.label

    @property
    def t(self) -> float:
        """Value over its standard error."""
        return self.value / self.standard_error

    @property
    def significant(self) -> bool:
        """Whether it is not put down to chance."""
        return self.p < SIGNIFICANT


@dataclass(frozen=True, eq=False)
class Regression(Correction):
    """Coefficients of regressors, how sure they are, and what they gained; see `compensate`.

    Taking it off (`apply`) leaves the bias at the regressors' means in the record, and a steady drift that was
    estimated along.

    Attributes
    ----------
    signal : Signal
        Of the record that was fitted.
    name : str
        Its name.
    regressors : tuple of Regressor
    mixture : Mixture
        Of the coefficients, SI per unit of the regressor.
    chosen : tuple of bool
        Columns that cross-validation chose, of `candidates` optional ones.
    inflation, condition
        Variance inflation factors, and scaled condition number of the whitened columns.
    noise : Model
        Noise that is left, identified along with the coefficients: squared coefficients averaged as they were.
    effective : float
        Effective samples: degrees of freedom of the variance of the noise.
    inside : Gain
        Of the record that was fitted.
    held : Gain or None
        Of its blocks, each compensated by what the rest of the record says.
    notes : tuple of str
    """

    signal: Signal
    name: str
    regressors: tuple[Regressor, ...]
    mixture: Mixture
    chosen: tuple[bool, ...]
    candidates: int
    inflation: FloatArray
    condition: float
    noise: Model
    effective: float
    inside: Gain
    held: Gain | None = None
    notes: tuple[str, ...] = ()

    @property
    def what(self) -> str:
        """For the history."""
        return f"regression on {'; '.join(r.label for r in self.regressors if not r.is_trend)}"

    @property
    def taken(self) -> list[int]:
        """Columns that are taken off: all but a trend."""
        return [i for i, regressor in enumerate(self.regressors) if not regressor.is_trend]

    @property
    def significant(self) -> bool:
        """Whether the drop of the variance is more than chance makes, and an effect is."""
        found = any(self.effect(i).significant for i in self.taken)
        return found and self.inside.reduction > self.inside.expected

    def __iter__(self) -> Iterator[Effect]:
        return (self.effect(i) for i in range(len(self.regressors)))

    def __getitem__(self, label: str) -> Effect:
        for i, regressor in enumerate(self.regressors):
            if regressor.label == label:
                return self.effect(i)
        raise UsageError(f"no regressor {label!r}; there are {', '.join(r.label for r in self.regressors)}")

    def effect(self, which: int, level: float = 0.95) -> Effect:
        """The coefficient of a column, with limits at `level`."""
        p = self.mixture.p(which)
        return Effect(
            self.regressors[which],
            float(self.mixture.values[which]),
            float(self.mixture.errors[which]),
            min(1.0, p * self.candidates) if self.chosen[which] else p,
            self.mixture.quantile((1 - level) / 2, which),
            self.mixture.quantile((1 + level) / 2, which),
            float(self.inflation[which]),
            self.chosen[which],
        )

    def rate_error(self, record: Record, along: Recording | None = None) -> FloatArray:
        """Error of the rate in each interval, SI, shape (record.size,); NaN where a regressor has no value."""
        if record.signal is not self.signal:
            raise UsageError(
                f"this regression is of a {self.signal.name} ({self.signal.unit}), but {record.name!r} is of a "
                f"{record.signal.name} ({record.signal.unit})"
            )
        columns = (self.mixture.values[i] * self.regressors[i].column(record, along) for i in self.taken)
        return np.asarray(sum(columns))

    def error(self, record: Record, along: Recording | None = None) -> FloatArray:
        """Error of each reading, SI, shape of its values; see `Correction`."""
        rate = self.rate_error(record, along)
        if record.kind == "rate":
            return rate
        if record.kind != "angle":
            return rate / record.rate
        if np.isnan(rate).any():
            raise DataError(
                f"{int(np.isnan(rate).sum())} readings of the regressors are lost, and with them every angle behind "
                "them; correct the rates or increments instead"
            )
        return np.concatenate(([0.0], np.cumsum(rate / record.rate)))

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, from which `from_dict` makes the regression again."""
        return {
            "allanite": 1,
            "type": "Regression",
            "signal": self.signal.name,
            "name": self.name,
            "effects": [self._effect_data(i, level) for i in range(len(self.regressors))],
            "level": level,
            "candidates": self.candidates,
            "condition": self.condition,
            "effective_samples": self.effective,
            "mixture": self.mixture.to_dict(),
            "noise": self.noise.to_dict(),
            "inside": self.inside.to_dict(),
            "held": None if self.held is None else self.held.to_dict(),
            "significant": self.significant,
            "notes": list(self.notes),
        }

    def _effect_data(self, which: int, level: float) -> dict[str, Any]:
        e = self.effect(which, level)
        return {
            "label": e.label,
            "regressor": e.regressor.to_dict(),
            "value": e.value,
            "standard_error": e.standard_error,
            "t": e.t,
            "p": e.p,
            "low": e.low,
            "high": e.high,
            "unit": f"{self.signal.unit} per {e.regressor.column_unit}",
            "inflation": e.inflation,
            "chosen": e.chosen,
            "taken_off": not e.regressor.is_trend,
        }

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Regression":
        """The regression that `to_dict` has written.

        Raises
        ------
        DataError
            It is none, or was changed so that it makes no sense.
        """
        try:
            if data["type"] != "Regression":
                raise ValueError(data["type"])
            effects = data["effects"]
            found = cls(
                signal=signal_named(str(data["signal"])),
                name=str(data["name"]),
                regressors=tuple(Regressor.from_dict(e["regressor"]) for e in effects),
                mixture=Mixture.from_dict(data["mixture"]),
                chosen=tuple(bool(e["chosen"]) for e in effects),
                candidates=int(data["candidates"]),
                inflation=np.array([float(e["inflation"]) for e in effects]),
                condition=float(data["condition"]),
                noise=Model.from_dict(data["noise"]),
                effective=float(data["effective_samples"]),
                inside=Gain.from_dict(data["inside"]),
                held=None if data["held"] is None else Gain.from_dict(data["held"]),
                notes=tuple(str(note) for note in data["notes"]),
            )
        except (KeyError, TypeError, ValueError, StopIteration, IndexError) as error:
            raise DataError(
                f"this is no regression that was saved, or it was changed ({type(error).__name__}: {error})"
            ) from None
        if found.mixture.centres.shape[1] != len(found.regressors):
            raise DataError("this regression has not as many coefficients as regressors: it was changed")
        return found

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write it as JSON, which `load` reads.

        Raises
        ------
        UsageError
            The file exists and `force` is not set, or its folder cannot be written.
        """
        save((self,), path, force=force)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Regression":
        """The one regression in a file that was saved.

        Raises
        ------
        DataError
            The file cannot be read, or holds something else, or several regressions.
        """
        found = load(path)
        if len(found) > 1:
            raise DataError(f"{os.fspath(path)!r} holds {len(found)} regressions; take compensation.load")
        return found[0]


def save(regressions: tuple[Regression, ...], path: str | os.PathLike[str], *, force: bool = False) -> None:
    """Write regressions as one JSON file; errors as those of `Regression.save`."""
    from allanite.core.files import write

    write(path, to_json(regressions).encode(), force=force)


def to_json(regressions: tuple[Regression, ...]) -> str:
    """Regressions as plain data in strictly valid JSON."""
    data = {"allanite": 1, "type": "Regressions", "regressions": [r.to_dict() for r in regressions]}
    return json.dumps(data, allow_nan=False, ensure_ascii=False, indent=1) + "\n"


def load(path: str | os.PathLike[str]) -> tuple[Regression, ...]:
    """The regressions in a file; errors as those of `Regression.load`."""
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError, RecursionError) as error:
        raise DataError(f"{os.fspath(path)!r} cannot be read as a saved regression: {error}") from None
    listed = data.get("regressions") if isinstance(data, dict) else None
    if not isinstance(listed, list) or not listed or not all(isinstance(item, dict) for item in listed):
        raise DataError(f"{os.fspath(path)!r} holds no saved regression")
    return tuple(Regression.from_dict(item) for item in listed)
