"""Low-pass filters of sensors and loggers, as factors of the expected power (docs/derivations.md)."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.phrases.phrase import say

NARROWEST, HIGHEST_CUTOFF, HIGHEST_RC = 0.004, 0.5, 1.0
"""The lowest and the highest cut-off frequency that is looked for, cycles per sample, and the highest of an RC filter,
whose images are no more than a ripple of 4 exp(-2 pi cut-off): a record does not show others.
"""

MAX_LAGS, LEAST_GAIN_OF_EDGES = 1024, 1e-9
"""Samples over which a filter correlates, at most; a gain so low that where it is less does not matter."""

TWO, THREE = math.sqrt(2 ** (1 / 2) - 1), math.sqrt(2 ** (1 / 3) - 1)
"""Cut-off of two and of three RC filters, one behind the other, over that of each."""

AVERAGED, TWICE, THRICE = 0.443, 0.3189, 0.2617
"""Cut-off of a moving average, of one behind another, and of three, times the number of samples."""


@dataclass(frozen=True)
class Filter:
    """A low-pass filter."""

    title: str
    # both in cycles per sample; the frequency is an array. 1 at zero frequency.
    gain: Callable[[FloatArray, float], FloatArray]
    # cut-offs at which the search begins, the highest first: between their ends the cut-off is looked for
    starts: FloatArray = field(default_factory=lambda: _octaves(HIGHEST_CUTOFF))
    whole: bool = False  # whether `starts` are whole numbers of samples, each of which has zeros of its own

    def edges(self, cutoff: float) -> tuple[float, float]:
        """Variance of white noise behind the filter at either edge of a record, and of its differences, over before."""
        # The variance of a coefficient of the frequency w is S(w) - (2/n) sum over h > 0 of r(h) [h cos wh + sin wh /
        # sin w], r being the autocovariances of the gain S. What it has beyond S has nearly the shape (2/n) cos^2(w/2)
        # of noise at the edges. It matters where the filter lets little pass, and is taken from there.
        f = np.arange(MAX_LAGS + 1) / (2 * MAX_LAGS)
        w, gain = 2 * np.pi * f[1:-1], self.gain(f, cutoff)
        weight = 1 / (gain[1:-1] + LEAST_GAIN_OF_EDGES) ** 2

        def beyond(S: FloatArray) -> float:
            r = np.fft.irfft(S)
            r[0], r[MAX_LAGS:] = 0.0, 0.0
            even, odd = np.fft.rfft(r * np.arange(r.size)).real, np.fft.rfft(r).imag
            lost = even[1:-1] - odd[1:-1] / np.sin(w)
            return max(float(-(weight @ lost) / (weight @ np.cos(w / 2) ** 2)), 0.0)

        return beyond(gain), beyond(gain * (2 * np.sin(np.pi * f)) ** 2)

    @property
    def widest(self) -> float:
        """The highest cut-off that is looked for."""
        return float(self.starts[0])


def _octaves(highest: float) -> FloatArray:
    """Cut-offs an octave apart."""
    trials = highest * 2.0 ** -np.arange(0.0, 8.0)
    return np.asarray(trials[trials > NARROWEST])


def _sampled_one_pole(f: FloatArray, cutoff: float) -> FloatArray:
    """An RC filter that is sampled; the same as y += a (x - y) at each sample."""
    p = math.exp(-2 * math.pi * cutoff)
    return np.asarray((1 - p) ** 2 / (1 - 2 * p * np.cos(2 * np.pi * f) + p * p))


def _sampled_two_poles(f: FloatArray, cutoff: float) -> FloatArray:
    """A Butterworth filter that is sampled: the sum of exp(-a|h|) (cos ah + sin a|h|) cos(2 pi f h) over all lags h."""
    a = math.sqrt(2) * math.pi * cutoff

    def total(x: FloatArray) -> FloatArray:
        both = [np.exp(-a + 1j * (a + sign * 2 * np.pi * x)) for sign in (1, -1)]
        return np.asarray(1 + np.real((1 - 1j) * sum(z / (1 - z) for z in both)))

    return np.asarray(total(f) / total(np.zeros(1)))


def _averaged_one_pole(f: FloatArray, cutoff: float) -> FloatArray:
    """An RC filter whose output is averaged over each sample interval."""
    # The sum over the images x = f + l of sinc(x)^2 / (1 + (x/c)^2), from the autocovariances of the mean of an
    # Ornstein-Uhlenbeck process over one sample.
    T = 1 / (2 * math.pi * cutoff)  # samples
    p = math.exp(-1 / T)
    g0 = 1 - T * (1 - p)
    first = 0.5 * T * (1 - p) ** 2
    cosine = np.cos(2 * np.pi * f)
    return np.asarray(g0 + 2 * first * (cosine - p) / (1 - 2 * p * cosine + p * p))


def _digital(order: int, every: int = 1) -> Callable[[FloatArray, float], FloatArray]:
    """A Butterworth filter by the bilinear transform, with zeros at half its rate; one in `every` sample is kept."""

    def kept(f: FloatArray, cutoff: float) -> FloatArray:
        images = np.abs((np.add.outer(np.arange(every), f) / every + 0.5) % 1.0 - 0.5)
        ratio = np.tan(np.pi * np.minimum(images, 0.5 - 1e-9)) / math.tan(np.pi * cutoff / every)  # infinite at 0.5
        return np.asarray((1 / (1 + ratio ** (2 * order))).sum(axis=0))

    return lambda f, cutoff: kept(f, cutoff) / kept(np.zeros(1), cutoff)


def _from_lags(r: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Spectrum of the autocovariances 1, r_1, r_2 .. of white noise behind a window, 1 at zero frequency."""
    h = np.arange(1, r.size + 1)
    return lambda f: np.asarray((1 + 2 * np.cos(2 * np.pi * np.multiply.outer(f, h)) @ r) / (1 + 2 * r.sum()))


def _moving_average(f: FloatArray, cutoff: float) -> FloatArray:
    """The mean over `AVERAGED` / cut-off samples, a whole number or not."""
    length = max(AVERAGED / cutoff, 1.0)
    h = np.arange(1, math.ceil(length))
    return _from_lags(1 - h / length)(f)


def _bartlett(f: FloatArray, cutoff: float) -> FloatArray:
    """Two moving averages, one behind the other: a triangular window."""
    length = TWICE / cutoff
    x = np.arange(1, math.ceil(2 * length)) / length
    r = np.where(x < 1, 4 - 6 * x**2 + 3 * x**3, (2 - x) ** 3) / 4
    return _from_lags(r)(f)


def _thrice_averaged(f: FloatArray, cutoff: float) -> FloatArray:
    """Three moving averages, one behind the other: autocovariances are a B-spline of six equal intervals."""
    length = THRICE / cutoff
    x = np.arange(1, math.ceil(3 * length)) / length
    k = np.arange(7.0)
    powers = np.maximum(np.subtract.outer(x + 3, k), 0.0) ** 5
    r = powers @ np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0]) / 66
    return _from_lags(r)(f)


FILTERS: dict[str, Filter] = {
    "rc": Filter(say("1st-order low-pass"), _sampled_one_pole, _octaves(HIGHEST_RC)),
    "rc twice": Filter(
        say("two 1st-order low-passes, one behind the other"), lambda f, cutoff: _sampled_one_pole(f, cutoff / TWO) ** 2
    ),
    "rc three times": Filter(
        say("three 1st-order low-passes, one behind the other"),
        lambda f, cutoff: _sampled_one_pole(f, cutoff / THREE) ** 3,
    ),
    "averaged rc": Filter(
        say("1st-order low-pass, averaged over each sample"), _averaged_one_pole, _octaves(HIGHEST_RC)
    ),
    "butterworth": Filter(say("2nd-order low-pass"), _sampled_two_poles),
    "bilinear 1": Filter(say("digital 1st-order low-pass"), _digital(1), _octaves(0.45)),
    "bilinear 2": Filter(say("digital 2nd-order low-pass"), _digital(2), _octaves(0.45)),
    "decimated": Filter(say("digital 2nd-order low-pass at 4 times the rate"), _digital(2, 4)),
    "average": Filter(say("moving average"), _moving_average, AVERAGED / np.arange(1.0, 33.0), whole=True),
    "average twice": Filter(
        say("moving average of a moving average"),
        lambda f, cutoff: _moving_average(f, AVERAGED / TWICE * cutoff) ** 2,
        TWICE / np.arange(1.0, 33.0),
        whole=True,
    ),
    "bartlett": Filter(say("continuous moving average of a moving average (Bartlett window)"), _bartlett),
    "cic": Filter(say("three continuous moving averages, one behind the other (sinc^3, CIC)"), _thrice_averaged),
}
"""Filters that are tried; the cut-off frequency of each is the only unknown."""
