"""Gauss-Markov noise of the angle: an exponentially correlated error of the angle; the rate is its derivative."""

import math

import numpy as np

from allanite.phrases.phrase import say

from .exponential import Exponential, rest
from .row import Block, FloatArray, NoiseTerm, time_constant

SHORTEST = 0.5
"""Samples from which a time constant can be distinguished from quantization."""

LEAST = 0.02
"""Power of a coefficient over that of the spectrum, at least."""


def angle_markov(T: float) -> NoiseTerm:
    """The row of Gauss-Markov noise of the angle, with a time constant of T sample intervals."""
    u = 1 / T
    functions = Exponential(u)
    loss = -math.expm1(-u)
    inverse = 0.25 / np.sinh(min(u, 700.0) / 2) ** 2  # of 1 / (2 cosh u - 2)
    linear = float(inverse * (rest(u, 3) - rest(-u, 3))) if u < 1 else 2 * u * inverse - 1 / math.tanh(u / 2)

    def summed(t: FloatArray) -> FloatArray:
        # of 2 (1 - exp(-u t)), without its constant and its square of t
        t = np.asarray(t, dtype=np.float64)
        return np.asarray(inverse * ((u * t) ** 3 / 3 - 2 * rest(u * t, 4)) + linear * t)

    def derivative(order: int, t: FloatArray) -> FloatArray:
        return np.asarray(-2 * (-u) ** order * np.exp(-u * t))

    def increments(h: FloatArray) -> FloatArray:
        h = np.asarray(h, dtype=np.float64)
        far = loss**4 * np.exp(-u * np.maximum(h - 2, 0))
        first = -2 * loss - loss**2 - loss**3
        return np.where(h == 0, 4 * loss + 2 * loss**2, np.where(h == 1, first, far))

    def spectrum(f: FloatArray, tau0: float) -> FloatArray:
        s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
        return np.asarray(4 / tau0 * s * functions.lorentzian(s) * -math.expm1(-2 * u) / loss**2)

    def dct(k: FloatArray, n: int) -> FloatArray:
        s = np.sin((0.5 * math.pi / n) * np.asarray(k, dtype=np.float64)) ** 2
        inside = spectrum(k / (2.0 * n), 1.0)
        # a time constant of a fifth of the record and more leaves nothing but the ends
        return np.asarray(np.maximum(inside + functions.ends(k, n) - 4 / n * (1 - s), LEAST * inside))

    return NoiseTerm(
        symbol="GMA",
        title=say("Gauss-Markov noise of the angle"),
        titles={
            "accelerometer": say("Gauss-Markov noise of the velocity"),
            "dimensionless": say("Gauss-Markov noise of the time"),
        },
        meaning=say("exponentially correlated (first-order Gauss-Markov) noise of the angle, with a time constant T"),
        quantity_title=say("Gauss-Markov noise of the integrated {quantity}"),
        quantity_meaning=say(
            "exponentially correlated (first-order Gauss-Markov) noise of the integral, with a time constant T"
        ),
        formula=r"\sigma^2(\tau) = (s^2 / \tau^2) (3 - 4 \exp(-\tau/T) + \exp(-2 \tau/T))",
        reference=say(
            "a first-order Markov process of the angle; structure function 2 s^2 (1 - exp(-t/T)), s the RMS angle"
        ),
        power=1.0,
        slope=math.nan,
        read_at=math.nan,
        level=math.nan,
        structure=lambda t: -2 * np.expm1(-u * np.asarray(t, dtype=np.float64)),
        derivative=derivative,
        summed=summed,
        increments=increments,
        spectrum=spectrum,
        dct=dct,
        ends=1.0,
        parameters=(time_constant(2.0, SHORTEST),),
        shape=(T,),
        shaped=lambda shape, rate: angle_markov(shape[0] * rate),
        density=r"S(f) = \frac{2 s^2 T (2 \pi f)^2}{1 + (2 \pi f T)^2}",
        origin="An error of the angle itself that is forgotten within a time constant: backlash and friction of a "
        "mechanism, eccentricity of a readout that turns slowly, the residual motion of a stabilized platform, "
        "the residual dither of a ring laser after its removal by a filter.",
        advice="Below T it is angle random walk with N = s sqrt(2/T), slope -1/2; above, it is bounded and falls with "
        "slope -1 as quantization does, with Q = s. With T below a sample interval it cannot be told from "
        "quantization, with T above the record's length not from angle random walk. It is looked for when its "
        "symbol is among the terms that are asked for. In a Kalman filter it is a state of the angle error.",
        typical=0.5,
        color="#0E13FC",
        dark="#3BF9B4",
        dash=(6, 1.4, 3, 1.4),
        block=lambda size, shape, h: angle_markov_block(size, shape[0], h),
    )


def angle_markov_block(size: float, T: float, h: float) -> Block:
    """Gauss-Markov noise of the angle of RMS `size` and time constant `T`: the mean rate is its change over h."""
    loss, driven = -math.expm1(-h / T), -math.expm1(-2 * h / T) * size**2
    return Block(
        names=((say("Gauss-Markov angle, T = {time:.6g} s", time=T), 1),),
        F=np.array([[-1 / T]]),
        Qc=np.array([[2 * size**2 / T]]),
        Phi=np.array([[math.exp(-h / T)]]),
        mean=np.array([-loss / h]),
        Q=driven * np.array([[1.0, 1 / h], [1 / h, 1 / h**2]]),
        P0=np.array([[size**2]]),
        output=np.zeros(1),
        note=say("the error of the angle is a state: its change over the interval enters the mean rate"),
    )


ANGLE_MARKOV = angle_markov(1.0)
