"""Rounding, as converters and angle readouts do it, with and without dither."""

import math
from dataclasses import dataclass, replace

import numpy as np

from allanite.core.aliases import public
from allanite.core.errors import UnitError, UsageError
from allanite.core.record import Record
from allanite.core.units import signal_with, unit_of
from allanite.statistics.row import FloatArray

EXACT = 2.0**52
"""Steps beyond which a double cannot tell one from the next."""


@dataclass(frozen=True)
class Dither:
    """What is added before rounding.

    Attributes
    ----------
    amplitude : float
        In steps of the quantizer: the half width of a uniform random dither, or the amplitude of a sinusoid.
    frequency : float, optional
        Frequency of the sinusoid, Hz; None for random dither.
    stripped : bool
        Taken off again after rounding, as it is known to the readout.
    """

    amplitude: float = 0.5
    frequency: float | None = None
    stripped: bool = True

    def __post_init__(self) -> None:
        if not self.amplitude > 0 or not (self.frequency is None or self.frequency > 0):
            raise UsageError(f"a dither needs an amplitude and a frequency above 0, unlike {self}")

    def at(self, n: int, rate: float, rng: "np.random.Generator | None") -> FloatArray:
        """The dither at n instants, in steps; the phase of a sinusoid is random if there is a generator."""
        if self.frequency is not None:
            phase = 0.0 if rng is None else rng.uniform(0, 2 * math.pi)
            return np.asarray(self.amplitude * np.sin(2 * math.pi * self.frequency / rate * np.arange(n) + phase))
        if rng is None:
            raise UsageError("random dither is drawn from a generator: pass rng=numpy.random.default_rng(1)")
        return rng.uniform(-self.amplitude, self.amplitude, n)

    def __str__(self) -> str:
        how = "random dither" if self.frequency is None else f"dither of {self.frequency:g} Hz"
        return f"{how}, amplitude {self.amplitude:g} steps, {'stripped' if self.stripped else 'not stripped'}"


@public
def quantize_rate(
    record: Record,
    lsb: float,
    unit: str,
    *,
    dither: Dither | None = None,
    rng: "np.random.Generator | None" = None,
) -> Record:
    """Round the rate to steps, as the converter of a rate output does.

    Where the noise exceeds about half a step the error is white: it adds to N by ``lsb sqrt(tau0 / 12)``, and is not Q.

    Parameters
    ----------
    record : Record
        Record of kind "rate".
    lsb : float
        The step, in `unit`.
    unit : str
        Unit of a rate.
    dither : Dither, optional
    rng : numpy.random.Generator
        For random dither.

    Examples
    --------
    >>> quantize_rate(Record([0.26, -0.13, 0.4], rate=10.0, unit="deg/s"), 0.25, "deg/s").values.tolist()
    [0.25, -0.25, 0.5]
    """
    if record.integrated:
        raise UsageError(f"only a rate can be rounded by its converter; for {record.kind}s round the angle")
    found = unit_of(unit)
    if signal_with(found.dimension, values=True) is not record.signal:
        raise UnitError(f"{unit!r} is not a unit of {record.signal.unit} samples")
    step = _step(lsb, unit) * found.factor / record.factor
    values = _rounded(np.asarray(record.values / step), record.rate, dither, rng)
    return record.with_values(values * step, _words("rate", lsb, unit, dither), start=record.start)


@public
def quantize_angle(
    record: Record,
    lsb: float,
    unit: str,
    *,
    dither: Dither | None = None,
    rng: "np.random.Generator | None" = None,
) -> Record:
    """Round the angle to steps, as a pulse counter or an integrating readout does.

    Where the angle is dithered, or its own noise over an interval exceeds about half a step, this is quantization noise
    with ``Q = lsb / sqrt(12)``. A steady angle without dither makes a pattern of lines instead, which its mean rate
    gives their places: add that by `constant` first.

    Parameters
    ----------
    record : Record
        Record of kind "rate" or "increment".
    lsb : float
        The step, in `unit`.
    unit : str
        Unit of an angle (of a velocity for accelerometers).
    dither : Dither, optional
        Added to the angle.
    rng : numpy.random.Generator
        For random dither.

    Returns
    -------
    Record
        Record of kind "count", each of size `lsb`; of kind "increment" if a dither was subtracted.

    Examples
    --------
    >>> slow = Record([0.4, 0.4, 0.4, 0.4, 0.4], rate=1.0, unit="arcsec", kind="increment")
    >>> counts = quantize_angle(slow, 1.0, "arcsec")
    >>> counts.values.tolist(), counts.kind, counts.scale
    ([0, 1, 0, 1, 0], 'count', 1.0)
    """
    if record.kind in ("angle", "count"):
        raise UsageError(f"the angle of rates and increments can be rounded, not of kind {record.kind!r}")
    found = unit_of(unit)
    if signal_with(found.dimension, 1, values=True) is not record.signal:
        raise UnitError(f"{unit!r} is not a unit of the integral of {record.signal.unit}: for a gyro use arcsec")
    angle = record.angle / (_step(lsb, unit) * found.factor)
    steps = _rounded(angle, record.rate, dither, rng)
    history = (*record.history, _words("angle", lsb, unit, dither))
    if dither is not None and dither.stripped:
        return replace(record, values=np.diff(steps) * lsb, unit=unit, kind="increment", scale=None, history=history)
    counts = np.diff(steps).astype(np.int64)
    return replace(record, values=counts, unit=unit, kind="count", scale=lsb, history=history)


def _rounded(values: FloatArray, rate: float, dither: Dither | None, rng: "np.random.Generator | None") -> FloatArray:
    """Whole steps, less the dither if it is stripped."""
    if not np.isfinite(values).all():
        raise UsageError("some samples are not finite; round the record before samples are removed")
    if values.size and np.abs(values).max() > EXACT:
        raise UsageError(f"the samples are up to {np.abs(values).max():.3g} steps: use a larger step")
    if dither is None:
        return np.rint(values)
    added = dither.at(values.size, rate, rng)
    return np.rint(values + added) - (added if dither.stripped else 0.0)


def _step(lsb: float, unit: str) -> float:
    if not (math.isfinite(lsb) and lsb > 0):
        raise UsageError(f"the step of a quantizer must be above 0, not {lsb!r} {unit}")
    return lsb


def _words(what: str, lsb: float, unit: str, dither: Dither | None) -> str:
    return f"{what} rounded to {lsb:g} {unit}" + ("" if dither is None else f", {dither}")
