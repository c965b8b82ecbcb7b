"""Estimates of a spectrum: Welch's mean periodogram of overlapping segments, and Thomson's multitapers."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
import scipy

from allanite.core.aliases import constructed
from allanite.core.arrays import FloatArray, stretches
from allanite.core.errors import DataError, UsageError
from allanite.core.names import demand_name
from allanite.core.ranges import TIME, Range
from allanite.core.record import Record
from allanite.core.splines import cubic, valued
from allanite.phrases.phrase import say, spelled, windowing


class Raw(NamedTuple):
    """Two-sided densities at the frequencies k df, Hz, k = first ... first + size - 1."""

    # `period` is the number of frequencies in the sampling rate, so that k and period - k are mirrored. `overlap` is
    # the covariance of two values over the square of their expectation, by the difference of their k, for a flat
    # spectrum; zero beyond its end. `resolution` is the equivalent noise bandwidth, Hz.
    first: int
    df: float
    period: int
    density: FloatArray
    overlap: FloatArray
    resolution: float


@runtime_checkable
class SpectralEstimator(Protocol):
    """A spectrum estimator."""

    @property
    def title(self) -> str:
        """Description with the settings."""

    def estimate(self, record: Record) -> Raw:
        """Densities at evenly spaced frequencies."""


def demand_frequencies(count: int, record: Record) -> None:
    """Refuse a record, or a segment of it, that is too short for any frequency."""
    if count < 1:
        raise DataError(say("{channel!r} has too few of its {size} samples without a gap for a spectrum; record "
                            "longer, or use longer segments", channel=record.name, size=record.size))  # fmt: skip


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

MAX_SEGMENT = 2**22  # samples of a segment of a record that is read in parts, at most
BATCH_SAMPLES = 2**19  # samples that are transformed at once: 4 MB, which stay in the cache of a processor


@constructed
@dataclass(frozen=True)
class Welch:
    """Mean of the periodograms of segments that overlap by half.

    The mean of each segment is subtracted. The lowest frequencies, which the window makes depend on the mean, are
    omitted: the first one for ``"hann"``, so that white noise is estimated without bias at all others. Segments contain
    no missing samples.

    Attributes
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
        demand_name("window", self.window, WINDOWS)
        TIME.demand(self.segment, "the length of a segment")

    @property
    def title(self) -> str:
        """Description with the settings."""
        return say("welch, {window} window", window=self.window)

    def estimate(self, record: Record) -> Raw:
        """Densities at evenly spaced frequencies; see `allanite.spectrum`."""
        values = record.rate_values
        runs = [values[a:b] for a, b in stretches(np.isfinite(values))]
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
        sums = Periodograms(self.window, length)
        for run in runs:
            sums.push(run)
            sums.end()
        return sums.raw(record.rate)

    def in_parts(self, record: Record, size: int) -> "Periodograms":
        """Sums for a record of so many samples of which `record` is the beginning, to be pushed in parts.

        Without `segment`, segments are an eighth of the record, but at most `LONGEST` samples.
        """
        usual = min(max(size // 8, 64), MAX_SEGMENT)
        length = usual if self.segment is None else round(self.segment * record.rate)
        if length > MAX_SEGMENT:
            raise UsageError(
                f"a segment of {self.segment:g} s is {length} samples, and a record that is read in parts has "
                f"segments of at most {MAX_SEGMENT}: give {spelled('--segment', 'segment=')} up to "
                f"{MAX_SEGMENT / record.rate:.6g} s"
            )
        demand_frequencies((length + 1) // 2 - len(WINDOWS[self.window]), record)
        return Periodograms(self.window, length)


class Periodograms:
    """Sums of the periodograms of segments that overlap by half, of samples that come in parts."""

    def __init__(self, window: str, length: int) -> None:
        self.window, self.length, self.hop = window, length, max(1, length // 2)
        t = 2 * math.pi * np.arange(length) / length
        self.w = np.asarray(sum((-1) ** j * a * np.cos(j * t) for j, a in enumerate(WINDOWS[window])), dtype=np.float64)
        self.power = np.zeros(length // 2 + 1)
        self.counts: dict[int, int] = {}
        self._now = 0
        self._rest: list[FloatArray] = []

    def push(self, values: FloatArray) -> None:
        """Add samples that follow the last ones; segments contain none that is not finite."""
        at = 0
        for begin, stop in stretches(np.isfinite(values)).tolist():
            if begin > at:
                self.end()
            self._run(values[begin:stop])
            at = stop
        if at < values.size:
            self.end()

    def end(self) -> None:
        """The next sample does not follow the last one."""
        if self._now:
            self.counts[self._now] = self.counts.get(self._now, 0) + 1
        self._now, self._rest = 0, []

    def raw(self, rate: float, factor: float = 1.0) -> Raw:
        """Densities of the samples times `factor`, at this sampling rate."""
        self.end()
        if not self.counts:
            raise DataError(
                say("no gap-free stretch of {length} samples, the length of a segment; use shorter segments",
                    length=self.length)
            )  # fmt: skip
        energy, first = float(self.w @ self.w), len(WINDOWS[self.window])
        segments = sum(size * many for size, many in self.counts.items())
        density = self.power[first : (self.length + 1) // 2] * (factor**2 / (segments * energy * rate))
        overlap = _welch_overlap(self.w, self.hop, self.counts)
        resolution = rate * energy / float(self.w.sum()) ** 2
        return Raw(first, rate / self.length, self.length, density, overlap, resolution)

    def _run(self, part: FloatArray) -> None:
        """Add samples that follow the last ones without a gap."""
        self._rest.append(part)
        size = sum(piece.size for piece in self._rest)
        if size < self.length:
            self._rest[-1] = part.copy()  # the caller may use its memory again
            return
        run = part if len(self._rest) == 1 else np.concatenate(self._rest)
        w = self.w
        segments = np.lib.stride_tricks.sliding_window_view(run, w.size)[:: self.hop]
        power = np.zeros(w.size // 2 + 1)
        group = max(1, BATCH_SAMPLES // w.size)
        for start in range(0, len(segments), group):
            part = segments[start : start + group]
            part = (part - part.mean(axis=1, keepdims=True)) * w
            power += (np.abs(scipy.fft.rfft(part, axis=1)) ** 2).sum(axis=0)
        self.power += power
        count = (size - self.length) // self.hop + 1
        self._now += count
        self._rest = [run[count * self.hop :].copy()]


def _welch_overlap(w: FloatArray, hop: int, counts: dict[int, int]) -> FloatArray:
    """Covariance of two values l frequencies apart over their squared expectation, for a flat spectrum."""
    # Of two segments j hops apart the squared transforms of w(t) w(t + j hop) count, as often as there are such pairs;
    # `counts` are runs without a gap by the number of segments in each.
    total = float(sum(size * many for size, many in counts.items()))
    size, energy = w.size, float(w @ w)
    result = np.zeros(size // 2 + 1)
    for j in range(-(-size // hop)):
        pairs = float(sum(max(size - j, 0) * many for size, many in counts.items())) * (2 if j else 1)
        product = np.zeros(size)
        product[: size - j * hop] = w[: size - j * hop] * w[j * hop :]
        result += pairs * (np.abs(np.fft.rfft(product)) / energy) ** 2
    return result / total**2


LARGEST_TAPERS = 2**16  # length up to which tapers are computed; longer ones are interpolated, with an error of 1e-8
SHAPE_LENGTH = 4096  # length at which the shape of the tapers is looked at


@constructed
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
        Range(1, 50).demand(self.bandwidth, "the time-half-bandwidth product NW of the tapers")
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
            density += weight * np.abs(scipy.fft.rfft(y * taper)[first : (y.size + 1) // 2]) ** 2
        df = record.rate / y.size
        overlap, bandwidth = _shape(self.bandwidth, tuple(weights.tolist()), min(y.size, SHAPE_LENGTH))
        return Raw(first, df, y.size, density / record.rate, overlap, bandwidth * df)


def slepian(size: int, bandwidth: float, count: int) -> tuple[FloatArray, FloatArray]:
    """The first tapers, of unit energy, shape (count, size), and the share of each one's power within the bandwidth."""
    # As functions of t/T they depend on the bandwidth alone: those of a long record are interpolated.
    small = min(size, LARGEST_TAPERS)
    tapers, shares = _dpss(small, bandwidth, count)
    if small < size:
        at = (np.arange(small) + 0.5) / small
        tapers = valued(at, cubic(at, tapers), (np.arange(size) + 0.5) / size)
        tapers /= np.sqrt((tapers**2).sum(axis=1, keepdims=True))
    return tapers, shares


@lru_cache(maxsize=4)
def _dpss(size: int, bandwidth: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Tapers and shares, kept: the channels of a file, or simulated records, have one length."""
    tapers, shares = scipy.signal.windows.dpss(size, bandwidth, count, return_ratios=True)
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
