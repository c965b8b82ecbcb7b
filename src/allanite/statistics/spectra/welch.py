"""Welch's estimate of a spectrum: the mean periodogram of overlapping segments."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.core.errors import UsageError
from allanite.core.language import say
from allanite.core.record import Record
from allanite.statistics.estimator import stretches
from allanite.statistics.row import FloatArray, IntArray

from .raw_spectrum import Raw, demand_frequencies

WINDOWS: dict[str, tuple[float, ...]] = {
    "boxcar": (1.0,),
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman": (0.42, 0.5, 0.08),
    "blackmanharris": (0.35875, 0.48829, 0.14128, 0.01168),
    "flattop": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
}
"""Windows as sums of cosines: w(t) = a0 - a1 cos(2 pi t) + a2 cos(4 pi t) - ..., over one period.

Those of scipy.signal, which takes a second to import; the number of cosines says which frequencies are omitted.
"""

AT_ONCE = 2**22
"""Samples that are transformed at once: what bounds the memory."""


@dataclass(frozen=True)
class Welch:
    """Mean of the periodograms of segments that overlap by half.

    The mean of each segment is subtracted. The lowest frequencies, which the window makes depend on the mean, are
    omitted: the first one for ``"hann"``, so that white noise is estimated without bias at all others. Segments contain
    no missing samples.

    Parameters
    ----------
    segment : float, optional
        Length of a segment, s; by default an eighth of the record, or its longest stretch without a missing sample if
        that is shorter.
    window : str
        A name in `WINDOWS`.

    References
    ----------
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70; D. B. Percival, A. T. Walden, Spectral Analysis for
    Physical Applications, 1993, sec. 6.17 (degrees of freedom).
    """

    segment: float | None = None
    window: str = "hann"

    def __post_init__(self) -> None:
        if self.window not in WINDOWS:
            raise UsageError(f"unknown window {self.window!r}; known windows: {', '.join(WINDOWS)}")
        if self.segment is not None and not (math.isfinite(self.segment) and self.segment > 0):
            raise UsageError(f"the length of a segment must be a positive number of seconds, not {self.segment!r}")

    @property
    def title(self) -> str:
        """Description with the settings."""
        return say("welch, {window} window", window=self.window)

    def estimate(self, record: Record) -> Raw:
        """Densities at evenly spaced frequencies; see `allanite.spectrum`."""
        values = record.rate_values
        runs = [values[a:b] for a, b in stretches(values)]
        length = self._length(record, runs)
        w = _window(self.window, length)
        hop = max(1, length // 2)
        counts = np.array([(run.size - length) // hop + 1 for run in runs if run.size >= length])
        power = np.zeros(length // 2 + 1)
        for run in runs:
            if run.size >= length:
                power += _summed_periodograms(run, w, hop)
        energy = float(w @ w)
        first, segments = len(WINDOWS[self.window]), int(counts.sum())
        density = power[first : (length + 1) // 2] / (segments * energy * record.rate)
        overlap = _welch_overlap(w, hop, counts)
        resolution = record.rate * energy / float(w.sum()) ** 2
        return Raw(first, record.rate / length, length, density, overlap, resolution)

    def _length(self, record: Record, runs: list[FloatArray]) -> int:
        longest = max((run.size for run in runs), default=0)
        if self.segment is None:
            length = min(longest, max(record.size // 8, 64))
        else:
            length = round(self.segment * record.rate)
            if length > longest:
                raise UsageError(
                    f"a segment of {self.segment:g} s does not fit: the longest stretch of {record.name!r} without "
                    f"a missing sample is {longest / record.rate:g} s"
                )
        demand_frequencies((length + 1) // 2 - len(WINDOWS[self.window]), record)
        return length


def _window(name: str, length: int) -> FloatArray:
    t = 2 * math.pi * np.arange(length) / length
    return np.asarray(sum((-1) ** j * a * np.cos(j * t) for j, a in enumerate(WINDOWS[name])), dtype=np.float64)


def _summed_periodograms(run: FloatArray, w: FloatArray, hop: int) -> FloatArray:
    from scipy.fft import rfft

    segments = np.lib.stride_tricks.sliding_window_view(run, w.size)[::hop]
    power = np.zeros(w.size // 2 + 1)
    group = max(1, AT_ONCE // w.size)
    for start in range(0, len(segments), group):
        part = segments[start : start + group]
        part = (part - part.mean(axis=1, keepdims=True)) * w
        power += (np.abs(rfft(part, axis=1)) ** 2).sum(axis=0)
    return power


def _welch_overlap(w: FloatArray, hop: int, counts: IntArray) -> FloatArray:
    """Covariance of two values l frequencies apart over their squared expectation, for a flat spectrum.

    Of two segments j hops apart the squared transforms of w(t) w(t + j hop) count, as often as there are such pairs.
    """
    total = float(counts.sum())
    size, energy = w.size, float(w @ w)
    result = np.zeros(size // 2 + 1)
    for j in range(-(-size // hop)):
        pairs = float(np.maximum(counts - j, 0).sum()) * (2 if j else 1)
        product = np.zeros(size)
        product[: size - j * hop] = w[: size - j * hop] * w[j * hop :]
        result += pairs * (np.abs(np.fft.rfft(product)) / energy) ** 2
    return result / total**2
