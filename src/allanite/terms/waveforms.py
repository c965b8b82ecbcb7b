"""Waveforms of the rate: a sinusoid, and an exponential warm-up that begins with the record."""

import math
from typing import Any

import numpy as np

from allanite.phrases.phrase import say

from .row import Block, FloatArray, NoiseTerm, Parameter, time_constant


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
        symbol="Sine", title=say("sinusoid"), meaning=say("a sinusoid of the rate, with an amplitude and a frequency"),
        quantity_meaning=say("a sinusoid, with an amplitude and a frequency"),
        formula=r"\sigma^2(\tau) = A^2 \sin^4(\pi f \tau) / (\pi f \tau)^2",
        reference=say("IEEE Std 952; the mean over all phases"),
        power=0.0, slope=math.nan, read_at=math.nan, level=math.nan, structure=structure, derivative=derivative,
        summed=summed, increments=increments, spectrum=lambda f, tau0: np.zeros_like(f),
        dct=lambda k, _: np.zeros_like(k), waveform=waveform, periodic=True,
        parameters=(
            Parameter("frequency", say("frequency"), "Hz", least=0.0, letter="f", typical=0.02, time=-1.0),
            Parameter("phase", say("phase"), "rad", default=0.0, typical=0.0),
        ),
        shape=(frequency, phase), shaped=lambda shape, rate: sine(shape[0] / rate, shape[1]),
        origin="Vibration, sway of the building or the vehicle, residual dither, mains interference and its beats with "
        "the sampling. It is not random: the next record may have it elsewhere.",
        advice="A hump with its maximum at tau = 0.371/f, where the Allan deviation is 0.725 A, and zeros at multiples "
        "of 1/f; the envelope falls with slope -1. The maximum may be mistaken for bias instability, and the "
        "flank for quantization. In the spectrum it is a narrow peak: there it is detected, its amplitude and "
        "frequency are estimated, and it is removed before the noise is identified.",
        color="#462362", dark="#7D7ADE", dash=(1.2, 3.2),
        block=lambda amplitude, shape, h: oscillator(amplitude, shape[0], h),
    )  # fmt: skip


def oscillator(amplitude: float, frequency: float, h: float) -> Block:
    """A sinusoid of unknown phase."""
    w = 2 * math.pi * frequency
    sine, cosine = math.sin(w * h), math.cos(w * h)
    return Block(
        names=(
            (say("sinusoid of {frequency:.6g} Hz", frequency=frequency), 0),
            (say("sinusoid of {frequency:.6g} Hz, quadrature", frequency=frequency), 0),
        ),
        F=np.array([[0.0, w], [-w, 0.0]]), Qc=np.zeros((2, 2)), Phi=np.array([[cosine, sine], [-sine, cosine]]),
        mean=np.array([sine, 2 * math.sin(w * h / 2) ** 2]) / (w * h), Q=np.zeros((3, 3)),
        P0=np.eye(2) * amplitude**2 / 2, output=np.array([1.0, 0.0]),
        note=say("a sinusoid is an oscillator without noise: its frequency must be known and constant"),
    )  # fmt: skip


SINE = sine(0.125)


def _none(*_: Any) -> FloatArray:
    raise ValueError("a warm-up (W) has no structure function, as it depends on the time since the record began: pass "
                     "the length of the record, or omit W from the model")  # fmt: skip


def warm_up(T: float) -> NoiseTerm:
    """The row of a warm-up 1 - exp(-t / T), with a time constant of T sample intervals."""
    u = 1 / T

    def waveform(n: int) -> FloatArray:
        return np.asarray(1 + math.expm1(-u) * T * np.exp(-u * np.arange(n)))

    return NoiseTerm(
        symbol="W", title=say("warm-up"),
        meaning=say("an exponential change of the rate from the start of the record on, with a sign and a time "
                    "constant"),
        formula=r"\Omega(t) = W (1 - \exp(-t / T))", reference=say("the mean over each sample interval"),
        power=0.0, slope=math.nan, read_at=math.nan, level=math.nan, structure=_none, derivative=_none,
        summed=_none, increments=_none, spectrum=lambda f, tau0: np.zeros_like(f), dct=lambda k, _: np.zeros_like(k),
        waveform=waveform, transient=True, parameters=(time_constant(200.0),), shape=(T,),
        shaped=lambda shape, rate: warm_up(shape[0] * rate),
        origin="The sensor comes to its temperature after it is switched on. It is not a noise: it begins with the "
        "power, and what a statistic shows of it depends on when the record begins and how long it is.",
        advice="It resembles a random walk or a ramp. A warm-up longer than a third of the record is a ramp. Cut it "
        "off rather than model it, and record after it: what is left of it then is below its standard error. It is "
        "looked for in every record, named in a finding, and accounted for in the residuals and in the curve that is "
        "drawn. Asked for by its symbol, it has an interval and is part of the model.",
        typical=20.0, color="#13042C", dark="#8BF08F", dash=(1.2, 1.2, 6, 1.2),
    )  # fmt: skip


WARM_UP = warm_up(1.0)
