r"""The bound: the error of the optimal causal filter for the same noise.

The difference of gyro angle and tilt holds no motion, only the errors x = sum n_g dt and v = n_a. Its differences have
the density

    S = S_g dt^2 + |1 - z^-1|^2 S_a = |L|^2,

and with L without zeros outside the unit circle, by the cepstrum of S, the innovations are (1 - z^-1) (x - v) / L. The
causal part C of the response from innovations to the error v of the tilt is the filter of Wiener, whose error is

    (C / L) dt n_g + (1 - C (1 - z^-1) / L) n_a.

Below 1 / (2 T) the densities are taken to fall steeply: a run of the length T hardly contains what is there.
"""

import math

import numpy as np

from allanite.extending import FloatArray, UsageError

from .density import SensorNoise
from .loop import ComplexArray, Loop

STEPS = 64.0
"""Samples to the time constant, where there is no sampling rate."""

COARSE = 4.0
"""How much longer a sample interval may be where the transform would need too many."""

MEMORY = 400.0
"""Length of the filter in time constants, where there is no horizon."""

FINER = 4
"""Frequencies below the lowest of the horizon."""

MOST = 1 << 21
"""Points of the transform at most."""

STEEP = 4
"""Power of the frequency with which the densities fall below the lowest one."""

PER_OCTAVE = 128
"""Points of a density between which its logarithm is taken to be straight."""


def wiener_error(noise: SensorNoise, best: Loop) -> float:
    """Standard deviation of the angle of the optimal causal filter, rad; sinusoids and biases are taken to be known.

    Computed as the ratio of its error to that of the filter of first order, both on one grid of frequencies. Without a
    sampling rate the grid is that of a fine one.
    """
    interval, longest = noise.interval or best.time_constant / STEPS, MEMORY * best.time_constant
    if noise.duration:
        longest = FINER * 2 * noise.duration
    n = 1 << math.ceil(math.log2(min(MOST, max(1024, longest / interval))))
    interval = interval if noise.interval else min(max(interval, longest / n), COARSE * interval)
    sampled = SensorNoise(noise.gyro, noise.accelerometer, noise.duration, interval)
    f = np.asarray(np.fft.rfftfreq(n, interval), dtype=np.float64)
    low = sampled.lowest if noise.duration else float(f[1])
    x = np.geomspace(low, f[-1], max(16, math.ceil(PER_OCTAVE * math.log2(f[-1] / low))))
    below = np.maximum(f, f[1] / 4) / low if noise.duration else np.ones(f.size)

    def held(sensor: str) -> FloatArray:
        """Density of a sensor, which falls steeply below the lowest frequency."""
        density = sampled.total(sensor, x)
        if not density.all():
            raise UsageError(f"the bound needs noise of both sensors, but that of the {sensor} is 0")
        smooth = np.exp(np.interp(np.log(np.maximum(f, low)), np.log(x), np.log(density)))
        return np.asarray(smooth * np.minimum(below, 1.0) ** STEEP)

    rate, tilt = held("gyro"), held("accelerometer")
    # responses of the optimal filter to dt n_g and to n_a, from their densities
    rise = 1 - np.exp(-2j * math.pi / n * np.arange(n // 2 + 1))
    cepstrum = np.fft.irfft(np.log(rate * interval**2 + np.abs(rise) ** 2 * tilt), n) / 2
    cepstrum[1 : n // 2] *= 2
    cepstrum[n // 2 + 1 :] = 0.0
    L = np.exp(np.fft.rfft(cepstrum))
    cross = np.fft.irfft(tilt * np.conj(rise / L), n)
    cross[n // 2 :] = 0.0  # what precedes the innovation
    causal = np.fft.rfft(cross)
    optimal = _error((causal / L * interval, 1 - causal * rise / L), (rate, tilt))
    first = _error(best.responses(np.maximum(f, f[1] / 4), interval), (rate, tilt))
    return random_error(noise, best) * optimal / first


def random_error(noise: SensorNoise, loop: Loop) -> float:
    """Standard deviation of the angle from noise alone, rad."""
    f, weight = noise.nodes
    gain = [np.abs(response) ** 2 * weight for response in loop.responses(f, noise.interval)]
    return math.sqrt(sum(float(gain[sensor != "gyro"] @ density) for sensor, _, density in noise.noise))


def _error(responses: tuple[ComplexArray, ComplexArray], densities: tuple[FloatArray, FloatArray]) -> float:
    """Standard deviation of the error, in steps of the grid."""
    density = np.abs(responses[0]) ** 2 * densities[0] + np.abs(responses[1]) ** 2 * densities[1]
    return math.sqrt(float(np.sum(density[1:-1])) + float(density[0] + density[-1]) / 2)
