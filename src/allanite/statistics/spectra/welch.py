"""Welch's estimate of a spectrum: the mean periodogram of overlapping segments."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError, UsageError
from allanite.core.names import demand_name
from allanite.core.record import Record
from allanite.phrases.phrase import say, spelled
from allanite.statistics.estimator import stretches

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

MAX_SEGMENT = 2**22  # samples of a segment of a record that is read in parts, at most
BATCH_SAMPLES = 2**22  # samples that are transformed at once: what bounds the memory


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
        runs = stretches(values)
        at = 0
        for begin, stop in runs:
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
        from scipy.fft import rfft

        segments = np.lib.stride_tricks.sliding_window_view(run, w.size)[:: self.hop]
        power = np.zeros(w.size // 2 + 1)
        group = max(1, BATCH_SAMPLES // w.size)
        for start in range(0, len(segments), group):
            part = segments[start : start + group]
            part = (part - part.mean(axis=1, keepdims=True)) * w
            power += (np.abs(rfft(part, axis=1)) ** 2).sum(axis=0)
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
