"""A sinusoid of the rate: vibration, sway, interference; averaged over each sample interval."""

import math

import numpy as np

from allanite.phrases.phrase import say

from .row import Block, FloatArray, NoiseTerm, Parameter


def sine(frequency: float, phase: float = 0.0) -> NoiseTerm:
    """The row of a sinusoid of the rate, amplitude 1, with `frequency` periods a sample interval."""
    w = 2 * math.pi * frequency
    amplitude = float(np.sinc(frequency))  # of the mean over an interval

    def structure(t: FloatArray) -> FloatArray:
        return np.asarray(2 * np.sin(w / 2 * np.asarray(t, dtype=np.float64)) ** 2 / w**2)

    def derivative(order: int, t: FloatArray) -> FloatArray:
        return np.asarray(-(w ** (order - 2)) * np.cos(w * t + order * math.pi / 2))

    def summed(t: FloatArray) -> FloatArray:
        # of (1 - cos(w t)) / w^2, without its constant and its square of t
        # cos(x) without its constant and its square, without cancellation
        x = w * np.asarray(t)
        x = np.asarray(x, dtype=np.float64)
        small = np.minimum(np.abs(x), 1.0)
        series = sum((-1) ** k * small ** (2 * k) / math.factorial(2 * k) for k in range(2, 11))
        return np.asarray(np.where(np.abs(x) < 1, series, np.cos(x) - 1 + x**2 / 2) / (w * 2 * math.sin(w / 2)) ** 2)

    def increments(h: FloatArray) -> FloatArray:
        return np.asarray(2 * amplitude**2 * math.sin(w / 2) ** 2 * np.cos(w * np.asarray(h)))

    def waveform(n: int) -> FloatArray:
        return np.asarray(amplitude * np.sin(w * (np.arange(n) + 0.5) + phase))

    return NoiseTerm(
        symbol="Sine",
        title=say("sinusoid"),
        meaning=say("a sinusoid of the rate, with an amplitude and a frequency"),
        quantity_meaning=say("a sinusoid, with an amplitude and a frequency"),
        formula=r"\sigma^2(\tau) = A^2 \sin^4(\pi f \tau) / (\pi f \tau)^2",
        reference=say("IEEE Std 952; the mean over all phases"),
        power=0.0,
        slope=math.nan,
        read_at=math.nan,
        level=math.nan,
        structure=structure,
        derivative=derivative,
        summed=summed,
        increments=increments,
        spectrum=lambda f, tau0: np.zeros_like(f),
        dct=lambda k, _: np.zeros_like(k),
        waveform=waveform,
        periodic=True,
        parameters=(
            Parameter("frequency", say("frequency"), "Hz", least=0.0, letter="f", typical=0.02, time=-1.0),
            Parameter("phase", say("phase"), "rad", default=0.0, typical=0.0),
        ),
        shape=(frequency, phase),
        shaped=lambda shape, rate: sine(shape[0] / rate, shape[1]),
        origin="Vibration, sway of the building or the vehicle, residual dither, mains interference and its beats with "
        "the sampling. It is not random: the next record may have it elsewhere.",
        advice="A hump with its maximum at tau = 0.371/f, where the Allan deviation is 0.725 A, and zeros at multiples "
        "of 1/f; the envelope falls with slope -1. The maximum may be mistaken for bias instability, and the "
        "flank for quantization. In the spectrum it is a narrow peak: there it is detected, its amplitude and "
        "frequency are estimated, and it is removed before the noise is identified.",
        color="#462362",
        dark="#7D7ADE",
        dash=(1.2, 3.2),
        block=lambda amplitude, shape, h: oscillator(amplitude, shape[0], h),
    )


def oscillator(amplitude: float, frequency: float, h: float) -> Block:
    """A sinusoid of unknown phase."""
    w = 2 * math.pi * frequency
    sine, cosine = math.sin(w * h), math.cos(w * h)
    return Block(
        names=(
            (say("sinusoid of {frequency:.6g} Hz", frequency=frequency), 0),
            (say("sinusoid of {frequency:.6g} Hz, quadrature", frequency=frequency), 0),
        ),
        F=np.array([[0.0, w], [-w, 0.0]]),
        Qc=np.zeros((2, 2)),
        Phi=np.array([[cosine, sine], [-sine, cosine]]),
        mean=np.array([sine, 2 * math.sin(w * h / 2) ** 2]) / (w * h),
        Q=np.zeros((3, 3)),
        P0=np.eye(2) * amplitude**2 / 2,
        output=np.array([1.0, 0.0]),
        note=say("a sinusoid is an oscillator without noise: its frequency must be known and constant"),
    )


SINE = sine(0.125)
