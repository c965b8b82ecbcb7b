"""Sinusoids in a record: detected in its periodogram, estimated, and removed before the noise is identified."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, FloatArray, IntArray

from .spectrum import BinnedSpectrum, surroundings

FALSE_LINE = 0.01  # probability that a record of noise alone shows a line

SCREEN = 0.1
"""The same for the look at the cosine transform, which only decides whether the periodogram is worth its time."""

LOWEST_LINE = 4  # periods in the record that a sinusoid must have to be distinguished from a slow noise

MAX_LINES = 12
"""Number of peaks above which they are a hump of the spectrum rather than sinusoids; none is then removed."""

LINE_ROUNDS = 4  # periodograms: the sides of a strong line hide weak ones
BLOCKS = 2048  # pieces of the record in which a sinusoid near the peak of a line hardly turns

COMPANY, NEIGHBOURS = 50.0, 2
"""A sinusoid has no more others within so many periods of the record than one: what has, is a resonance or an unsteady
line, and no sum of a few sinusoids takes it out."""

TRUST = 3.0
"""The model's power is believed up to so many times that of the surroundings: a strong line lifts the model itself."""

SCATTERED = 30.0
"""Coefficients in the surroundings below which their power is not well known, and the model's believed the more."""


class Wave(NamedTuple):
    """A sinusoid of the mean rates in the unit of the samples; `frequency` in periods a sample, phase at the start."""

    frequency: float
    amplitude: float
    phase: float
    error: float

    def values(self, n: int) -> FloatArray:
        """At the middles of n sample intervals."""
        inner, outer = _turns(self.frequency, n)
        turned = np.outer(outer * np.exp(1j * self.phase), inner).ravel()[:n]
        return np.asarray(self.amplitude * turned.imag)


def _turns(frequency: float, n: int) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """exp(2 pi i f (k + 1/2)) as a product of a part within a block and one of the block."""
    length = -(-n // BLOCKS)
    inner = np.exp(2j * np.pi * frequency * (np.arange(length) + 0.5))
    return inner, np.exp(2j * np.pi * frequency * length * np.arange(-(-n // length)))


def levels(bins: BinnedSpectrum, m: FloatArray) -> FloatArray:
    """Power that noise has in each bin, shape (bins,): the model's, unless its surroundings say otherwise."""
    around = np.median(surroundings(bins.power), axis=1)
    many = surroundings(bins.count).sum(axis=1)
    return np.asarray(np.maximum(around, np.minimum(m, TRUST * (1 + SCATTERED / many) * around)))


def suspected(bins: BinnedSpectrum, level: FloatArray, used: BoolArray) -> bool:
    """Whether a coefficient of the cosine transform stands out."""
    threshold = float(scipy.special.ndtri(0.5 * SCREEN / bins.count.sum())) ** 2
    return bool((used & (bins.first >= 2 * LOWEST_LINE) & (bins.peak > threshold * level)).any())


@dataclass(frozen=True, eq=False)
class Periodogram:
    """Periodogram of the samples under a Hann window, over the noise's power (`level`); missing samples are zero."""

    # `power`, at k / n periods a sample, shape (n // 2 + 1,), is of noise alone exponentially distributed with mean 1.
    # `weighted` are the samples times the window, `total` and `square` sums of it and its square over those there.
    power: FloatArray
    weighted: FloatArray
    total: float
    square: float
    level: FloatArray

    def peaks(self, used: BoolArray) -> IntArray:
        """Where lines stand, the strongest first; of neighbours, the higher one."""
        threshold = -math.log(FALSE_LINE / max(int(used.sum()), 1))
        above = np.flatnonzero(used & (self.power > threshold))
        kept: list[int] = []
        for k in above[np.argsort(self.power[above])[::-1]].tolist():
            if all(abs(k - other) > 3 for other in kept):
                # level of the neighbours over that of the noise, if it is higher: on a resonance nothing is a line
                near = self.power[max(k - round(COMPANY), 0) : k + round(COMPANY) + 1]
                if self.power[k] > threshold * max(float(np.median(near)) / math.log(2), 1.0):
                    kept.append(k)
            if len(kept) == MAX_LINES:
                break
        return np.array(kept, dtype=np.int64)

    def wave(self, k: int) -> Wave:
        """The sinusoid at the peak k: where the periodogram is highest between its frequencies."""
        n = self.weighted.size
        inner, outer = _turns(k / n, n)
        padded = np.zeros(inner.size * outer.size)
        padded[:n] = self.weighted
        blocks = padded.reshape(outer.size, inner.size) @ inner.conj() * outer.conj()
        centre = (np.arange(outer.size) + 0.5) * inner.size

        def height(x: float) -> float:
            return -float(abs(blocks @ np.exp(-2j * np.pi * x / n * centre)))

        least = scipy.optimize.minimize_scalar(height, bounds=(-1.0, 1.0), method="bounded", options={"xatol": 1e-5})
        best = float(least.x)
        turned = complex(blocks @ np.exp(-2j * np.pi * best / n * centre)) * 2j / self.total
        error = math.sqrt(2 * float(self.level[k]) * self.square) / self.total
        return Wave((k + best) / n, abs(turned), float(np.angle(turned)), error)


def periodogram(y: FloatArray, bins: BinnedSpectrum, level: FloatArray) -> Periodogram:
    """Periodogram of samples without their mean, NaN if missing, and the noise level in the bins of their spectrum."""
    n = y.size
    window = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
    window[~np.isfinite(y)] = 0.0
    weighted = np.where(window > 0, y, 0.0) * window
    square = float(window @ window)
    # coefficient k of the cosine transform of `seen.size` samples is at k / (2 size) periods a sample
    at = np.arange(n // 2 + 1) * (2.0 * bins.size / n)
    everywhere = level[np.clip(np.searchsorted(bins.first, at, side="right") - 1, 0, level.size - 1)]
    power = np.abs(scipy.fft.rfft(weighted)) ** 2 / (square * everywhere)
    return Periodogram(power, weighted, float(window.sum()), square, everywhere)


def waves_of(
    y: FloatArray, seen: BinnedSpectrum, level: FloatArray, band: tuple[float, float]
) -> tuple[list[Wave], FloatArray]:
    """The sinusoids in y within a band (periods a sample), and what is left of y, which is overwritten."""
    # `y` are samples without their mean, NaN where they are lost; `seen` is the spectrum of those that are there, and
    # `level` the power of the noise in its bins.
    waves: list[Wave] = []
    n = y.size
    f = np.arange(n // 2 + 1) / n
    used = (f * n >= LOWEST_LINE) & (f >= band[0]) & (f <= band[1]) & (f < 0.5 - 2 / n)
    for _ in range(LINE_ROUNDS):
        power = periodogram(y, seen, level)
        peaks = power.peaks(used)[: MAX_LINES - len(waves)]
        if not peaks.size:
            break
        new = [power.wave(int(k)) for k in peaks]
        for wave in new:
            y -= wave.values(n)
        waves += new
    f = np.array([wave.frequency for wave in waves])
    steady = (np.sum(np.abs(f[:, None] - f) * n < COMPANY, axis=1) <= NEIGHBOURS) & (f.size < MAX_LINES)
    for i in np.flatnonzero(~steady):
        y += waves[i].values(n)
    return [waves[i] for i in np.flatnonzero(steady)], y
