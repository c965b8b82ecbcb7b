"""A second simulator, which shares no code with the package: noise of a sensor, and what happens before the logger.

    python benchmarks/independent.py check

`check` compares the spectra of what is simulated with those of textbooks. Samples are means of the rate over the sample
interval, as of IEEE Std 952. Two-sided densities of the rate: N^2, B^2 / (2 pi f), K^2 / (2 pi f)^2; the angle has
white noise of standard deviation Q at each sample; R is a ramp; a Gauss-Markov process has a standard deviation and a
time constant. Cut-offs and frequencies of a disturbance are in cycles per sample.
"""

import math
import sys
from collections.abc import Callable, Sequence

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import butter, freqz, lfilter

Values = np.ndarray
Rng = np.random.Generator
Filter = tuple[Sequence[float], Sequence[float]]

LONGER, FINER = 4, 4  # the grid on which flicker noise is made: so many times as long and as fine as the record


def white(n: int, N: float, rate: float, rng: Rng) -> Values:
    """Means of white noise over each interval."""
    return N * math.sqrt(rate) * rng.standard_normal(n)


def flicker(n: int, B: float, rate: float, rng: Rng, finer: int = FINER) -> Values:
    """Means of flicker noise over each interval: coefficients of a longer and finer grid behind the window's sinc."""
    size = next_fast_len(LONGER * finer * n, real=True)
    size += size % 2
    f = np.arange(1, size // 2 + 1) * (finer * rate / size)
    amplitude = np.sqrt(B**2 / (2 * np.pi * f) * finer * rate * size / 2) * np.sinc(f / rate)
    z = np.zeros(size // 2 + 1, complex)
    z[1:] = (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)) * amplitude
    first = int(rng.integers(0, size - finer * n + 1))
    return irfft(z, size)[first : first + finer * n : finer]


def walk(n: int, K: float, rate: float, rng: Rng) -> Values:
    """Means of a random walk over each interval: the middle of its ends, and the mean of a Brownian bridge."""
    ends = np.concatenate([[0.0], np.cumsum(rng.standard_normal(n))])
    bridge = rng.standard_normal(n) / math.sqrt(12)
    return K / math.sqrt(rate) * ((ends[1:] + ends[:-1]) / 2 + bridge)


def angle_white(n: int, Q: float, rate: float, rng: Rng) -> Values:
    """Differences of white noise of the angle."""
    return Q * rate * np.diff(rng.standard_normal(n + 1))


def markov(n: int, sigma: float, T: float, rate: float, rng: Rng) -> Values:
    """Means of an Ornstein-Uhlenbeck process over each interval: exact moments of its end and its integral."""
    h = 1 / (rate * T)
    p, lost = math.exp(-h), -math.expm1(-h)
    end = -math.expm1(-2 * h)
    both = lost**2
    whole = 2 * h - 3 + 4 * p - p * p if h > 0.01 else h**3 * (2 / 3 - h / 2 + 7 * h**2 / 30)
    drive = rng.standard_normal(n)
    state = lfilter([1.0], [1.0, -p], math.sqrt(end) * drive, zi=[p * (first := rng.standard_normal())])[0]
    rest = math.sqrt(max(whole - both**2 / end, 0.0)) * rng.standard_normal(n)
    begin = np.concatenate([[first], state[:-1]])
    return sigma * (begin * lost + both / math.sqrt(end) * drive + rest) / h


def sensor(n: int, rate: float, rng: Rng, *, finer: int = FINER, **noise: object) -> Values:
    """The sum of terms: N, B, K, Q, R as numbers, GM as pairs of a standard deviation and a time constant."""
    made = {"N": white, "K": walk, "Q": angle_white}
    y = np.zeros(n)
    for symbol, size in noise.items():
        if symbol == "GM":
            y += sum(markov(n, sigma, T, rate, rng) for sigma, T in size)  # type: ignore[attr-defined]
        elif symbol == "R":
            y += float(size) * np.arange(n) / rate  # type: ignore[arg-type]
        elif symbol == "B":
            y += flicker(n, float(size), rate, rng, finer)  # type: ignore[arg-type]
        else:
            y += made[symbol](n, float(size), rate, rng)  # type: ignore[arg-type]
    return y


def rc(cutoff: float) -> Filter:
    """A first-order low-pass that follows its input exponentially."""
    p = math.exp(-2 * math.pi * cutoff)
    return [1 - p], [1.0, -p]


def butterworth(cutoff: float, order: int = 2) -> Filter:
    """A digital Butterworth filter, by the bilinear transform."""
    return butter(order, 2 * cutoff)


def average(m: int) -> Filter:
    """The mean of m samples."""
    return np.full(m, 1 / m), [1.0]


def behind(y: Values, filters: Sequence[Filter]) -> Values:
    """A record behind filters, one after the other."""
    for b, a in filters:
        y = lfilter(b, a, y)
    return y


def folded(filters: Sequence[Filter], every: int = 1) -> float:
    """Density of white noise at zero frequency behind filters of which one sample in `every` is kept, aliases too."""
    w = 2 * np.pi * np.arange(every) / every
    gain = np.prod([np.abs(freqz(b, a, w)[1]) ** 2 for b, a in filters], axis=0)
    return float(np.sum(gain))


def resonance(n: int, f: float, quality: float, peak: float, rng: Rng, *, squared: bool) -> Values:
    """White noise through two poles, with a numerator sin^2 or none; its peak density over that of white noise of 1."""
    w, r = 2 * math.pi * f, math.exp(-math.pi * f / quality)
    b, a = ([1.0, 0.0, -1.0] if squared else [1.0]), [1.0, -2 * r * math.cos(w), r * r]
    top = float(np.abs(freqz(b, a, [w])[1][0]))
    return math.sqrt(peak) / top * lfilter(b, a, rng.standard_normal(n))


SIZE, RECORDS = 2**14, 60
"""Samples and records of the check: an octave of the spectrum is known to 1 % or so, the lowest read to 4 %."""


def spectrum(make: Callable[[int, Rng], Values]) -> tuple[Values, Values]:
    """Frequencies in cycles per sample, and the mean two-sided periodogram of windowed records (Hann)."""
    window = np.hanning(SIZE)
    power = np.zeros(SIZE // 2 + 1)
    for seed in range(RECORDS):
        y = make(SIZE, np.random.default_rng(seed))
        power += np.abs(rfft(window * (y - y.mean()))) ** 2 / np.sum(window**2) / RECORDS
    return np.arange(power.size) / SIZE, power


def aliased(density: Callable[[Values], Values], f: Values) -> Values:
    """A density behind the mean over each interval, sampled: all images of a frequency."""
    images = f + np.arange(-200, 201)[:, None]
    return np.sum(density(np.abs(images)) * np.sinc(images) ** 2, axis=0)


def _resonant(f: Values) -> Values:
    """Power of two poles at 0.2 of quality 8, over that at the peak, times 30."""
    w, r = 2 * np.pi * 0.2, math.exp(-np.pi * 0.2 / 8)
    loss = [np.abs((1 - r * np.exp(1j * (w - x))) * (1 - r * np.exp(-1j * (w + x)))) ** 2 for x in (2 * np.pi * f, w)]
    return 30 * loss[1] / loss[0]


TEXTBOOK: dict[str, tuple[Callable[[int, Rng], Values], Callable[[Values], Values]]] = {
    "N": (lambda n, rng: white(n, 2.0, 1.0, rng), lambda f: 0 * f + 4.0),
    "B": (lambda n, rng: flicker(n, 1.0, 1.0, rng), lambda f: aliased(lambda x: 1 / (2 * np.pi * x), f)),
    "K": (lambda n, rng: walk(n, 1.0, 1.0, rng), lambda f: aliased(lambda x: (2 * np.pi * x) ** -2.0, f)),
    "Q": (lambda n, rng: angle_white(n, 1.0, 1.0, rng), lambda f: 4 * np.sin(np.pi * f) ** 2),
    "GM, 3 samples": (lambda n, rng: markov(n, 1.0, 3.0, 1.0, rng),
                      lambda f: aliased(lambda x: 6 / (1 + (6 * np.pi * x) ** 2), f)),
    "GM, 300 samples": (lambda n, rng: markov(n, 1.0, 300.0, 1.0, rng),
                        lambda f: aliased(lambda x: 600 / (1 + (600 * np.pi * x) ** 2), f)),
    "resonance": (lambda n, rng: resonance(n + 500, 0.2, 8.0, 30.0, rng, squared=False)[500:], _resonant),
    "RC, 0.1, one in 4": (lambda n, rng: behind(white(4 * n + 400, 1.0, 4.0, rng), [rc(0.1 / 4)])[400::4],
                          lambda f: aliased(lambda x: 1 / (1 + (x / 0.1) ** 2) / np.sinc(x) ** 2, f) + 0.0),
}  # fmt: skip
"""What is simulated, of 1 Hz, and its density."""

TOLERANCE = 0.05
"""Largest relative difference of the power of an octave: 4 standard errors of the lowest, 24 of the highest."""


def check() -> bool:
    """Print the ratio of the measured power to that of textbooks in octaves; whether all are near 1."""
    good = True
    for name, (make, density) in TEXTBOOK.items():
        f, power = spectrum(make)
        ratios = []
        for octave in range(7):
            inside = (f > 0.5 * 2.0 ** -(octave + 1)) & (f <= 0.49 * 2.0**-octave)
            ratios.append(float(np.mean(power[inside] / density(f[inside]))))
        off = max(abs(ratio - 1) for ratio in ratios)
        good &= off < TOLERANCE
        print(f"{name:18}", *(f"{ratio:.3f}" for ratio in ratios[::-1]), "" if off < TOLERANCE else "WRONG")
    return good


if __name__ == "__main__":
    if sys.argv[1:] != ["check"]:
        sys.exit(__doc__)
    sys.exit(not check())
