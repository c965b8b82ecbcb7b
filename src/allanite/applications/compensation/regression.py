"""Regression: the part of a sensor's error that depends on other channels, as a correction."""

import json
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from allanite.extending import (  # isort: skip
    AllaniteError, Correction, Covariance, DataError, FloatArray, Model, Record, Recording, Signal, UsageError,
    demand_name, join, public, say, write)  # fmt: skip

from .design import BEYOND_DOUBT, TRENDING
from .mixture import Gain, Mixture, about_line
from .regressor import Columns, Effect, Regressor

WITHIN = 1.959964  # standard errors of 95 % limits
CHI_SQUARE = WITHIN**2  # twice a log-likelihood ratio that one coefficient reaches by chance in one record of twenty


@dataclass(frozen=True, eq=False, repr=False)
class Regression(Columns, Correction):
    """Coefficients of regressors, their uncertainties, and the variance reduction; see `compensate`.

    The correction (`apply`) keeps the bias at the regressors' means in the record, and a linear drift that was
    estimated jointly.

    Attributes
    ----------
    signal : Signal
        Signal of the record that was fitted.
    name : str
        Its name.
    regressors : tuple of Regressor
    mixture : Mixture
        Distribution of the coefficients, SI per unit of the regressor.
    chosen : tuple of bool
        Columns that cross-validation chose, of `candidates` optional ones.
    inflation, condition
        Variance inflation factors, and scaled condition number of the whitened columns.
    noise : Model
        Noise that is left, identified along with the coefficients: squared coefficients averaged as they were.
    effective : float
        Effective samples: degrees of freedom of the noise, as a whole or where the regressors vary.
    inside : Gain
        Gain on the record that was fitted.
    held : Gain or None
        Gain on its blocks, each compensated with a fit to the rest of the record.
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
        labels = join("; ", [r.label for r in self.regressors if not r.is_trend])
        return say("regression on {regressors}", regressors=labels)

    @property
    def significant(self) -> bool:
        """Whether at least one effect is significant, beside the others and the noise."""
        return any(self.effect(i).significant for i in self.taken)

    @property
    def harmless(self) -> bool:
        """Whether cross-validation, if there is one, does not find that the correction increases the variance."""
        return self.held is None or not self.held.explained < 0

    @property
    def useful(self) -> bool:
        """Whether an effect is significant, and the correction harmless."""
        return self.significant and self.harmless

    @property
    def shared(self) -> float:
        """Share of a linear drift, as far as the noise lets it be seen, that the regressors explain; 0 without one."""
        return max((float(1 - 1 / self.inflation[i]) for i in self.trend), default=0.0)

    @property
    def ambiguous(self) -> bool:
        """Whether the regressors and a linear drift share most of their variance and fit about as well.

        The record shows something then, but by twice the log-likelihood hardly the one rather than the other.
        """
        if self.shared < TRENDING:
            return False

        def evidence(columns: list[int]) -> float:
            """What twice the log-likelihood would lose without some of the columns."""
            b, V = self.mixture.values[columns], self.mixture.covariance[np.ix_(columns, columns)]
            return float(b @ np.linalg.solve(V, b))

        both, regressors, drift = (evidence(of) for of in (self.taken + self.trend, self.taken, self.trend))
        return both > CHI_SQUARE > abs(regressors - drift) and min(regressors, drift) < BEYOND_DOUBT**2

    def __iter__(self) -> Iterator[Effect]:
        return (self.effect(i) for i in range(len(self.regressors)))

    def __getitem__(self, label: str) -> Effect:
        labels = [regressor.label for regressor in self.regressors]
        demand_name("regressor", label, labels)
        return self.effect(labels.index(label))

    def effect(self, which: int, level: float = 0.95) -> Effect:
        """The coefficient of a column, with limits at `level`."""
        p, regressor = self.mixture.p(which), self.regressors[which]
        return Effect(regressor, float(self.mixture.values[which]), float(self.mixture.errors[which]),
                      f"{self.signal.unit} per {regressor.column_unit}",
                      min(1.0, p * self.candidates) if self.chosen[which] else p,
                      self.mixture.quantile((1 - level) / 2, which), self.mixture.quantile((1 + level) / 2, which),
                      float(self.inflation[which]), self.chosen[which], level)  # fmt: skip

    def rate_error(self, record: Record, along: Recording | None = None) -> FloatArray:
        """Error of the rate in each interval, SI, shape (record.size,); NaN where a regressor has no value."""
        if record.signal is not self.signal:
            raise UsageError(f"this regression belongs to a {self.signal.name} ({self.signal.unit}), "
                             f"but {record.name!r} was measured by another type of sensor, {record.signal.name} "
                             f"({record.signal.unit})")  # fmt: skip
        return np.asarray(sum(self.mixture.values[i] * self.regressors[i].column(record, along) for i in self.taken))

    def error(self, record: Record, along: Recording | None = None) -> FloatArray:
        """Error of each sample, SI, shape of its values; see `Correction`."""
        rate = self.rate_error(record, along)
        if not record.integrated:
            return rate
        if record.kind != "angle":
            return rate / record.rate
        if np.isnan(rate).any():
            raise DataError(say("{samples} samples of the regressors are missing, and therefore every later angle; "
                                "correct the rates or increments instead",
                                samples=int(np.isnan(rate).sum())))  # fmt: skip
        return np.concatenate(([0.0], np.cumsum(rate / record.rate)))

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, with the `effects` at `level` for the reader."""
        effects = [self.effect(i, level).to_dict(level) for i in range(len(self.regressors))]
        return super().to_dict(level) | {"effects": effects, "significant": self.significant}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        """The regression written by `to_dict`."""
        try:
            result = super()._stored(data)
        except AllaniteError as error:
            raise DataError(f"not a saved regression, or it was changed: {error}") from None
        if {len(result.regressors), len(result.chosen), result.inflation.size} != {result.mixture.centres.shape[1]}:
            raise DataError("the numbers of coefficients and regressors of this regression differ: it was changed")
        return result

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
        regressions = load(path)
        if len(regressions) > 1:
            raise DataError(f"{os.fspath(path)!r} contains {len(regressions)} regressions; use compensation.load")
        return regressions[0]


@public
def gain_on(regression: Regression, record: Record, along: Recording | None) -> Gain:
    r"""Mean squares of another record, before and after, and what was to be expected of it; see `Gain`.

    With S = X'X of the regressors there (about means or straight lines), b the coefficients, V their covariance and C
    that of the noise, the sum of squares falls by 2 y'Xb - b'Sb. Its expectation b'Sb - 2 tr(VS) is without bias, and
    it scatters about that with the variance 4 (b'SVSb + tr(VSVS) + (Xb)'C(Xb)).

    Raises
    ------
    DataError
        The record and its regressors have no samples in common.
    """
    taken = regression.taken
    X = np.column_stack([regression.regressors[i].column(record, along) for i in taken])
    y = record.rate_values
    fine = np.isfinite(y) & np.isfinite(X).all(axis=1)
    count = int(fine.sum())
    if count < 2 + len(regression.trend):
        raise DataError(say("{name!r} and its regressors have no samples in common", name=record.name))
    drift = np.column_stack([np.ones(y.size),
                             *(regression.regressors[i].column(record, None) for i in regression.trend)])  # fmt: skip
    X, y = (about_line(np.where(fine, of.T, 0.0).T, np.where(fine, drift.T, 0.0).T) for of in (X, y))
    b, V = regression.mixture.values[taken], regression.mixture.covariance[np.ix_(taken, taken)]
    S, v = X.T @ X, X @ b
    before, after = float(y @ y), float((y - v) @ (y - v))
    expected = float(b @ S @ b - 2 * np.trace(V @ S))
    noise = Covariance(regression.noise.terms, y.size, record.rate).variance(v)
    spread = WITHIN * math.sqrt(4 * (float(b @ S @ V @ S @ b) + float(np.trace(V @ S @ V @ S)) + noise))
    return Gain(*(total / count for total in (before, after, expected, expected - spread, expected + spread)))


@public
def save(regressions: tuple[Regression, ...], path: str | os.PathLike[str], *, force: bool = False) -> None:
    """Write regressions as one JSON file; errors as those of `Regression.save`."""
    write(path, to_json(regressions).encode(), force=force)


def to_json(regressions: tuple[Regression, ...]) -> str:
    """Regressions as plain data in strictly valid JSON."""
    data = {"allanite": 1, "type": "Regressions", "regressions": [r.to_dict() for r in regressions]}
    return json.dumps(data, allow_nan=False, ensure_ascii=False, indent=1) + "\n"


@public
def load(path: str | os.PathLike[str]) -> tuple[Regression, ...]:
    """The regressions in a file; errors as those of `Regression.load`."""
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError, RecursionError):
        raise DataError(f"{os.fspath(path)!r} cannot be read as a saved regression; save it again") from None
    listed = data.get("regressions") if isinstance(data, dict) else None
    if not isinstance(listed, list) or not listed or not all(isinstance(item, dict) for item in listed):
        raise DataError(f"{os.fspath(path)!r} contains no saved regression")
    try:
        return tuple(Regression.from_dict(item) for item in listed)
    except UsageError as error:
        raise DataError(f"not a saved regression: {error}") from None
