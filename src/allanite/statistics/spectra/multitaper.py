"""Thomson's multitaper estimate of a spectrum."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError, UsageError
from allanite.core.record import Record
from allanite.phrases.phrase import say, spelled, windowing

from .raw_spectrum import Raw, demand_frequencies

LARGEST_TAPERS = 2**16  # length up to which tapers are computed; longer ones are interpolated, with an error of 1e-8
SHAPE_LENGTH = 4096  # length at which the shape of the tapers is looked at


@dataclass(frozen=True)
class Multitaper:
    """Weighted mean of the periodograms of the entire record under orthogonal tapers (Slepian sequences).

    Frequencies below the full bandwidth, where a steep spectrum is strongly smeared, are omitted.

    Attributes
    ----------
    bandwidth : float
        Time-half-bandwidth product NW: power is spread over f - NW/T to f + NW/T.
    tapers : int, optional
        Number of tapers, by default ``2 NW - 3``. Higher tapers leak: with ``2 NW - 1`` the spectrum of a rate random
        walk is 15 to 50 % too high.
    weights : {"eigen", "equal"}
        Weight of each taper: the share of its power within the bandwidth, or equal weights.

    References
    ----------
    D. J. Thomson, Proc. IEEE 70 (1982) 1055.
    """

    bandwidth: float = 4.0
    tapers: int | None = None
    weights: str = "eigen"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.bandwidth) and 1 <= self.bandwidth <= 50):
            raise UsageError(
                f"the time-half-bandwidth product NW of the tapers must be between 1 and 50, not {self.bandwidth!r}"
            )
        if self.weights not in ("eigen", "equal"):
            raise UsageError(f"weights of tapers must be 'eigen' or 'equal', not {self.weights!r}")
        if not 1 <= self.count <= 2 * self.bandwidth:
            most = math.floor(2 * self.bandwidth)
            raise UsageError(
                f"with NW = {self.bandwidth:g} there are 1 to {most} tapers that do not leak, not {self.tapers!r}"
            )

    @property
    def count(self) -> int:
        """Number of tapers."""
        return max(1, math.floor(2 * self.bandwidth) - 3) if self.tapers is None else self.tapers

    @property
    def title(self) -> str:
        """Description with the settings."""
        return say("multitaper, NW = {bandwidth:g}, {count} tapers", bandwidth=self.bandwidth, count=self.count)

    def estimate(self, record: Record) -> Raw:
        """Densities at evenly spaced frequencies; see `allanite.spectrum`."""
        from scipy.fft import rfft

        y = record.rate_values
        lost = int((~np.isfinite(y)).sum())
        if lost:
            raise DataError(say("{lost} of {size} samples of {channel!r} are missing: tapers need a record without "
                                "gaps; use {option}, or select a window without gaps ({choice})", lost=lost,
                                size=y.size, channel=record.name, option=spelled("--estimator welch", "method=welch"),
                                choice=windowing()))  # fmt: skip
        first = math.ceil(2 * self.bandwidth)
        demand_frequencies((y.size + 1) // 2 - first, record)
        tapers, shares = slepian(y.size, self.bandwidth, self.count)
        weights = shares if self.weights == "eigen" else np.ones_like(shares)
        weights = weights / weights.sum()
        y = y - y.mean()
        density = np.zeros((y.size + 1) // 2 - first)
        for weight, taper in zip(weights, tapers, strict=True):
            density += weight * np.abs(rfft(y * taper)[first : (y.size + 1) // 2]) ** 2
        df = record.rate / y.size
        overlap, bandwidth = _shape(self.bandwidth, tuple(weights.tolist()), min(y.size, SHAPE_LENGTH))
        return Raw(first, df, y.size, density / record.rate, overlap, bandwidth * df)


def slepian(size: int, bandwidth: float, count: int) -> tuple[FloatArray, FloatArray]:
    """The first tapers, of unit energy, shape (count, size), and the share of each one's power within the bandwidth."""
    # As functions of t/T they depend on the bandwidth alone: those of a long record are interpolated.
    small = min(size, LARGEST_TAPERS)
    tapers, shares = _dpss(small, bandwidth, count)
    if small < size:
        from scipy.interpolate import CubicSpline

        shape = CubicSpline((np.arange(small) + 0.5) / small, tapers, axis=1)
        tapers = shape((np.arange(size) + 0.5) / size)
        tapers /= np.sqrt((tapers**2).sum(axis=1, keepdims=True))
    return tapers, shares


@lru_cache(maxsize=4)
def _dpss(size: int, bandwidth: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Tapers and shares, kept: the channels of a file, or simulated records, have one length."""
    from scipy.signal.windows import dpss

    tapers, shares = dpss(size, bandwidth, count, return_ratios=True)
    tapers.flags.writeable = shares.flags.writeable = False
    return tapers, shares


@lru_cache(maxsize=4)
def _shape(bandwidth: float, weights: tuple[float, ...], size: int) -> tuple[FloatArray, float]:
    """Overlap as in `Raw`, and the equivalent noise bandwidth in units of 1/T."""
    # Both depend on the bandwidth alone, and are computed for a short record.
    tapers, _ = slepian(size, bandwidth, len(weights))
    length = tapers.shape[1]
    overlap = np.zeros(length // 2 + 1)
    for a, taper in zip(weights, tapers, strict=True):
        for b, other in zip(weights, tapers, strict=True):
            overlap += a * b * np.abs(np.fft.rfft(taper * other)) ** 2
    overlap.flags.writeable = False
    response = np.array(weights) @ np.abs(np.fft.rfft(tapers, 16 * length, axis=1)) ** 2
    return overlap, length / float(response.max())
