"""A second simulator, of textbook formulas and numpy alone, which shares no code with the package.

    python benchmarks/judge.py

compares the spectra of what is simulated with those of textbooks. Samples are means of the rate over the sample
interval, as of IEEE Std 952. Two-sided densities of the rate: N^2, B^2 / (2 pi f), K^2 / (2 pi f)^2; the angle has
white noise of standard deviation Q at each sample; R is a ramp; a Gauss-Markov process has a standard deviation and a
time constant, s. Cut-offs and frequencies of what stands behind the sensor are in cycles a sample.
"""

import math
import sys
from collections.abc import Callable, Sequence

import numpy as np

Values = np.ndarray
Rng = np.random.Generator
Filter = tuple[Sequence[float], Sequence[float]]
"""Numerator and denominator of a digital filter, by powers of the delay."""

LONGER, FINER = 8, 4  # the grid on which flicker noise is made: so many times as long and as fine as the record
DEGREES = 4.0  # of freedom of the noise with heavy tails, whose kurtosis does not exist


def recursion(drive: Values, factor: complex) -> Values:
    """The series y[k] = factor * y[k - 1] + drive[k], from rest: its sums of 1, 2, 4, ... samples."""
    y, reach = np.array(drive), 1
    while reach < y.size and abs(factor) > 1e-18:
        y[reach:] += factor * y[:-reach]  # the right side is made before the left is written
        factor, reach = factor * factor, 2 * reach
    return y


def white(n: int, N: float, rate: float, rng: Rng, *, tailed: bool = False) -> Values:
    """Means of white noise over each interval, Gaussian or with heavy tails (Student's t)."""
    drive = rng.standard_t(DEGREES, n) * math.sqrt(1 - 2 / DEGREES) if tailed else rng.standard_normal(n)
    return N * math.sqrt(rate) * drive


def flicker(n: int, B: float, rate: float, rng: Rng) -> Values:
    """Means of flicker noise over each interval: coefficients of a longer and finer grid behind the window's sinc."""
    size = 1 << (LONGER * FINER * n - 1).bit_length()
    f = np.arange(1, size // 2 + 1) * (FINER * rate / size)
    amplitude = np.sqrt(B**2 / (2 * np.pi * f) * FINER * rate * size / 2) * np.sinc(f / rate)
    z = np.zeros(size // 2 + 1, complex)
    z[1:] = (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)) * amplitude
    first = int(rng.integers(0, size - FINER * n + 1))
    return np.fft.irfft(z, size)[first : first + FINER * n : FINER]


def walk(n: int, K: float, rate: float, rng: Rng) -> Values:
    """Means of a random walk over each interval: the middle of its ends, and the mean of a Brownian bridge."""
    ends = np.concatenate([[0.0], np.cumsum(rng.standard_normal(n))])
    bridge = rng.standard_normal(n) / math.sqrt(12)
    return K / math.sqrt(rate) * ((ends[1:] + ends[:-1]) / 2 + bridge)


def angle_white(n: int, Q: float, rate: float, rng: Rng) -> Values:
    """Differences of white noise of the angle."""
    return Q * rate * np.diff(rng.standard_normal(n + 1))


def markov(n: int, sigma: float, T: float, rate: float, rng: Rng) -> Values:
    """Means of an Ornstein-Uhlenbeck process over each interval: exact moments of its end and of its integral."""
    h = 1 / (rate * T)
    p, lost, end = math.exp(-h), -math.expm1(-h), -math.expm1(-2 * h)
    whole = 2 * h - 3 + 4 * p - p * p if h > 0.01 else h**3 * (2 / 3 - h / 2 + 7 * h**2 / 30)
    drive = rng.standard_normal(n)
    start = np.concatenate([[rng.standard_normal()], math.sqrt(end) * drive[:-1]])
    rest = math.sqrt(max(whole - lost**4 / end, 0.0)) * rng.standard_normal(n)
    return sigma * (recursion(start, p) * lost + lost**2 / math.sqrt(end) * drive + rest) / h


def sensor(n: int, rate: float, rng: Rng, *, tailed: bool = False, **noise: object) -> Values:
    """The sum of terms: N, B, K, Q, R as numbers, GM as pairs of a standard deviation and a time constant."""
    made = {"B": flicker, "K": walk, "Q": angle_white}
    y = np.zeros(n)
    for symbol, size in noise.items():
        if symbol == "GM":
            y += sum(markov(n, sigma, T, rate, rng) for sigma, T in size)
        elif symbol == "R":
            y += float(size) * np.arange(n) / rate
        elif symbol == "N":
            y += white(n, float(size), rate, rng, tailed=tailed)
        else:
            y += made[symbol](n, float(size), rate, rng)
    return y


def rc(cutoff: float) -> Filter:
    """A first-order low-pass that follows its input exponentially."""
    p = math.exp(-2 * math.pi * cutoff)
    return [1 - p], [1.0, -p]


def butterworth(cutoff: float) -> Filter:
    """A digital Butterworth filter of second order, by the bilinear transform."""
    w = math.tan(math.pi * cutoff)
    top, low = 1 + math.sqrt(2) * w + w * w, 1 - math.sqrt(2) * w + w * w
    return [w * w / top, 2 * w * w / top, w * w / top], [1.0, 2 * (w * w - 1) / top, low / top]


def average(m: int) -> Filter:
    """The mean of m samples."""
    return [1 / m] * m, [1.0]


def response(f: Values, low_pass: Filter) -> Values:
    """Gain of a filter, complex, at frequencies in cycles a sample."""
    delay = np.exp(-2j * np.pi * np.asarray(f))
    b, a = (np.polyval(list(part)[::-1], delay) for part in low_pass)
    return b / a


def behind(y: Values, low_pass: Filter) -> Values:
    """A record behind a filter that is at rest before it; zeros behind it take what would come round to its begin."""
    size = 1 << (2 * y.size - 1).bit_length()
    gain = response(np.arange(size // 2 + 1) / size, low_pass)
    return np.fft.irfft(np.fft.rfft(y, size) * gain, size)[: y.size]


def resonance(n: int, f: float, quality: float, peak: float, rng: Rng) -> Values:
    """White noise through two poles; its highest density over that of white noise of 1."""
    w, r = 2 * math.pi * f, math.exp(-math.pi * f / quality)
    pole = complex(r * math.cos(w), r * math.sin(w))
    y = np.imag(pole * recursion(rng.standard_normal(n).astype(complex), pole)) / pole.imag
    return math.sqrt(peak) / abs(response(np.array([f]), ([1.0], [1.0, -2 * pole.real, r * r]))[0]) * y


def telegraph(n: int, dwell: float, rng: Rng) -> Values:
    """Popcorn noise: 0 or 1, each for so many samples on average."""
    return np.cumsum(rng.random(n) < 1 / dwell) % 2 * 1.0


SIZE, RECORDS = 2**14, 60
"""Samples and records of the check: an octave of the spectrum is known to 1 % or so, the lowest read to 4 %."""


def spectrum(make: Callable[[int, Rng], Values], name: str) -> tuple[Values, Values]:
    """Frequencies in cycles a sample, and the mean two-sided periodogram of windowed records (Hann)."""
    window = np.hanning(SIZE)
    power = np.zeros(SIZE // 2 + 1)
    for number in range(RECORDS):
        y = make(SIZE, np.random.default_rng((*name.encode(), number)))
        power += np.abs(np.fft.rfft(window * (y - y.mean()))) ** 2 / np.sum(window**2) / RECORDS
    return np.arange(power.size) / SIZE, power


def aliased(density: Callable[[Values], Values], f: Values) -> Values:
    """A density behind the mean over each interval, sampled: all images of a frequency."""
    images = f + np.arange(-200, 201)[:, None]
    return np.sum(density(np.abs(images)) * np.sinc(images) ** 2, axis=0)


def _resonant(f: Values) -> Values:
    w, r = 2 * np.pi * 0.2, math.exp(-np.pi * 0.2 / 8)
    loss = [np.abs((1 - r * np.exp(1j * (w - x))) * (1 - r * np.exp(-1j * (w + x)))) ** 2 for x in (2 * np.pi * f, w)]
    return 30 * loss[1] / loss[0]


TEXTBOOK: dict[str, tuple[Callable[[int, Rng], Values], Callable[[Values], Values]]] = {
    "N": (lambda n, rng: white(n, 2.0, 1.0, rng), lambda f: 0 * f + 4.0),
    "N, tailed": (lambda n, rng: white(n, 2.0, 1.0, rng, tailed=True), lambda f: 0 * f + 4.0),
    "B": (lambda n, rng: flicker(n, 1.0, 1.0, rng), lambda f: aliased(lambda x: 1 / (2 * np.pi * x), f)),
    "K": (lambda n, rng: walk(n, 1.0, 1.0, rng), lambda f: aliased(lambda x: (2 * np.pi * x) ** -2.0, f)),
    "Q": (lambda n, rng: angle_white(n, 1.0, 1.0, rng), lambda f: 4 * np.sin(np.pi * f) ** 2),
    "GM, 3 samples": (lambda n, rng: markov(n, 1.0, 3.0, 1.0, rng),
                      lambda f: aliased(lambda x: 6 / (1 + (6 * np.pi * x) ** 2), f)),
    "GM, 300 samples": (lambda n, rng: markov(n, 1.0, 300.0, 1.0, rng),
                        lambda f: aliased(lambda x: 600 / (1 + (600 * np.pi * x) ** 2), f)),
    "resonance": (lambda n, rng: resonance(n + 500, 0.2, 8.0, 30.0, rng)[500:], _resonant),
    "RC": (lambda n, rng: behind(white(n + 500, 1.0, 1.0, rng), rc(0.05))[500:],
           lambda f: (1 - (p := math.exp(-0.1 * np.pi))) ** 2 / (1 - 2 * p * np.cos(2 * np.pi * f) + p * p)),
    "Butterworth": (lambda n, rng: behind(white(n + 500, 1.0, 1.0, rng), butterworth(0.3))[500:],
                    lambda f: 1 / (1 + (np.tan(np.pi * f) / math.tan(np.pi * 0.3)) ** 4)),
    "mean of 4": (lambda n, rng: behind(white(n + 4, 1.0, 1.0, rng), average(4))[4:],
                  lambda f: (np.sin(4 * np.pi * f) / (4 * np.sin(np.pi * f))) ** 2),
    "popcorn": (lambda n, rng: telegraph(n, 50.0, rng),  # a Markov chain that keeps 24/25 of its correlation a sample
                lambda f: (1 - 0.96**2) / 4 / (1 - 2 * 0.96 * np.cos(2 * np.pi * f) + 0.96**2)),
}  # fmt: skip
"""What is simulated, of 1 Hz, and its density."""

TOLERANCE = 0.05
"""Largest relative difference of the power of an octave: 4 standard errors of the lowest, 24 of the highest."""


def ratios(name: str) -> list[float]:
    """Power over that of the textbook in octaves, of the highest first."""
    make, density = TEXTBOOK[name]
    f, power = spectrum(make, name)
    octaves = [(f > 0.49 * 2.0 ** -(k + 1)) & (f <= 0.49 * 2.0**-k) for k in range(7)]
    return [float(np.sum(power[inside]) / np.sum(density(f[inside]))) for inside in octaves]


if __name__ == "__main__":
    wrong = False
    for row in TEXTBOOK:
        each = ratios(row)
        good = max(abs(ratio - 1) for ratio in each) < TOLERANCE
        wrong |= not good
        print(f"{row:18}", *(f"{ratio:.3f}" for ratio in each), "" if good else "WRONG")
    sys.exit(wrong)
