"""Spectrum: power spectral density as a function of frequency."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from .aliases import public
from .arrays import FloatArray
from .encoding import plain
from .errors import UsageError, given
from .limits import demand_level, demand_stored_positive, demand_stored_rate, demand_stored_square
from .model import ModelLike, model_of
from .names import demand_name
from .plain import Value
from .units import convert

SIDES: dict[str, float] = {"one": 2.0, "two": 1.0}
"""Name of the convention: factor relative to the two-sided density. The frequencies are positive in both."""


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(Value):
    """Power spectral density of a channel.

    A one-sided density is twice the two-sided one at the same frequency. The coefficient N of IEEE 952 is the square
    root of the **two-sided** density of white noise; the square root of the one-sided density is too large by sqrt(2).

    Attributes
    ----------
    frequency, width : arrays, shape (k,)
        Frequency of each value and the width of its band, Hz: the
        sum of ``density * width`` of a one-sided spectrum is the mean square.
    density : array, shape (k,)
        Mean square per Hz, in ``unit^2/Hz``.
    dof : array, shape (k,)
        Equivalent degrees of freedom of each value, for a spectrum that is flat over the resolution.
    unit : str
        Unit of the signal.
    sides : {"one", "two"}
        Convention of `density`.
    method : str
        How it was estimated.
    resolution : float
        Equivalent noise bandwidth of the estimator, Hz: a sine of amplitude A has a one-sided density of about
        ``A^2 / (2 resolution)`` at its peak, where values are not binned.
    rate, name, history
        Sampling rate, name and history of the record.
    """

    _alike = ("frequency width density dof",)
    _checks: ClassVar = {"sides": lambda sides: demand_name("side", sides, SIDES), "rate": demand_stored_rate,
                         "density": demand_stored_square, "dof": demand_stored_positive}  # fmt: skip

    frequency: FloatArray
    width: FloatArray
    density: FloatArray
    dof: FloatArray
    unit: str
    sides: str
    method: str
    resolution: float
    rate: float
    name: str = ""
    history: tuple[str, ...] = ()

    @property
    def amplitude(self) -> FloatArray:
        """Amplitude spectral density (ASD): square root of the density, in ``unit/sqrt(Hz)``."""
        return np.sqrt(self.density)

    @property
    def density_unit(self) -> str:
        """Unit of `density`, for example (deg/h)^2/Hz."""
        return f"({self.unit})^2/Hz"

    @property
    def amplitude_unit(self) -> str:
        """Unit of `amplitude`, for example deg/h/sqrt(Hz)."""
        return f"{self.unit}/sqrt(Hz)"

    def interval(self, level: float = 0.95) -> tuple[FloatArray, FloatArray]:
        """Two-sided chi-square limits (low, high) of the density."""
        from scipy.special import gammaincinv

        demand_level(level)
        half = self.dof / 2
        low, high = (self.density * half / gammaincinv(half, p) for p in ((1 + level) / 2, (1 - level) / 2))
        return low, high

    def expected(self, model: ModelLike, frequency: FloatArray | None = None) -> FloatArray:
        """The density expected under a model, in the unit and convention of this spectrum.

        At `frequency`, Hz, or at those of the spectrum. It is the density of the sampled rate, aliases included,
        without the smoothing of a steep spectrum by the estimator.
        """
        model = model_of(model)
        factor = convert(1.0, model.signal.unit, self.unit) ** 2 * SIDES[self.sides]
        f = self.frequency if frequency is None else frequency
        return model.spectrum(f, 1 / self.rate) * factor

    @public
    def to(self, unit: str) -> "Spectrum":
        """The same spectrum in another unit of the signal."""
        factor = convert(1.0, self.unit, unit)
        return replace(self, density=self.density * factor**2, unit=unit)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[float]]]:
        """Headings and rows of a table."""
        headings = ["frequency [Hz]", f"{self.sides}-sided density [{self.density_unit}]", f"low {level:.4g}",
                    f"high {level:.4g}", f"amplitude [{self.amplitude_unit}]", "dof"]  # fmt: skip
        columns = [self.frequency, self.density, *self.interval(level), self.amplitude, self.dof]
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with the limits as numbers."""
        low, high = self.interval(level)
        return super().to_dict(level) | {"level": level, "low": plain(low), "high": plain(high)}

    def _summary(self) -> str:
        band = f"{self.frequency.min():.4g} to {self.frequency.max():.4g} Hz"
        return f"of {self.name!r}: {self.frequency.size} values, {band}, {self.sides}-sided, {self.density_unit}"


def side_factor(sides: str) -> float:
    """The row of `SIDES`; an unknown name is an error that lists the known ones."""
    if sides not in SIDES:
        raise UsageError(f"sides must be {' or '.join(map(repr, SIDES))}, not {given(sides)}")
    return SIDES[sides]
