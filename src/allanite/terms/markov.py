"""Gauss-Markov noise of the rate and of the angle: exponentially correlated, averaged over each sample interval.

For a complex u, whose real part is positive, the functions are the analytic continuations. Sums of two conjugate
exponentials with conjugate weights are a damped oscillation.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import say

from .row import Block, FloatArray, NoiseTerm, time_constant

Values = NDArray[Any]  # real for a real u, complex for a complex one

SMALL = 0.05  # size of u below which differences of exponentials are taken from their series


def rest(u: Values | complex, order: int) -> Values:
    """exp(-u) without the first `order` terms of its series, without cancellation."""
    u = np.asarray(u)
    small = np.abs(u) < SMALL * 4
    k = np.arange(order, order + 9)
    factorials = np.array([math.factorial(i) for i in k])
    series = ((-np.where(small, u, 0.0)[..., None]) ** k / factorials).sum(axis=-1)
    direct = np.exp(-u) - sum((-u) ** i / math.factorial(i) for i in range(order))
    return np.where(small, series, direct)


@dataclass(frozen=True)
class Exponential:
    """The columns of a row for the covariance exp(-u |t|), t in sample intervals."""

    u: complex

    @cached_property
    def T(self) -> complex:
        """The time constant."""
        return 1 / self.u

    @cached_property
    def loss(self) -> complex:
        """1 - exp(-u)."""
        return complex(-np.expm1(-self.u)) if isinstance(self.u, complex) else -math.expm1(-self.u)

    @cached_property
    def variance(self) -> complex:
        """Variance of a mean over one interval."""
        value: complex = 2 * self.T**2 * rest(self.u, 2).item()
        return value

    @cached_property
    def neighbour(self) -> complex:
        """Covariance of two neighbouring means."""
        return (self.loss * self.T) ** 2

    def structure(self, t: Values) -> Values:
        """D(t)."""
        return np.asarray(2 * self.T**2 * rest(np.asarray(t, dtype=np.float64) * self.u, 2))

    def derivative(self, order: int, t: Values) -> Values:
        """Derivatives of D."""
        if order == 1:
            return np.asarray(-2 * self.T * np.expm1(-t * self.u))
        return np.asarray(2 * self.T**2 * (-self.u) ** order * np.exp(-t * self.u))

    def summed(self, t: Values) -> Values:
        """Second sum of D, without its constant and its square of t."""
        T, u, small = self.T, self.u, abs(self.u) < SMALL
        t = np.asarray(t, dtype=np.float64)
        excess = u**2 / 12 + u**4 / 360 + u**6 / 20160 if small else (2 * np.cosh(u) - 2) / u**2 - 1
        inverse = 1 / (u**2 * (1 + excess))  # of 2 cosh u - 2
        if small:
            linear = (u**2 * (1 / 120 - 1 / 72) + u**4 * (1 / 5040 - 1 / 2160)) / (1 + excess)
        else:
            linear = T * inverse * (np.sinh(u) - u) - 1 / 6
        return np.asarray(2 * T * (t**3 / 6 * excess / (1 + excess) + linear * t + T * inverse * rest(t * u, 4)))

    def increments(self, h: Values) -> Values:
        """Covariance of the first differences of the means."""
        h, C = np.asarray(h, dtype=np.float64), self._covariance
        near = 2 * C(h) - C(np.abs(h - 1)) - C(h + 1)
        return np.where(h < 2, near, -self.neighbour * self.loss**2 * np.exp(-self.u * np.maximum(h - 2, 0)))

    def _covariance(self, h: Values) -> Values:
        beyond = self.neighbour * np.exp(-self.u * np.maximum(np.abs(h) - 1, 0))
        return np.where(h == 0, self.variance, beyond)

    def spectrum(self, f: Values, tau0: float) -> Values:
        """Two-sided spectral density of the means."""
        p, loss = np.exp(-self.u), self.loss
        s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
        numerator = 2 * self.T * loss**2 + 4 * s * (p * self.variance - self.neighbour)
        return np.asarray(tau0 * numerator / (loss**2 + 4 * p * s))

    def dct(self, k: Values, n: int) -> Values:
        """Variance of the k-th coefficient of the DCT-II of n means."""
        f = np.asarray(k, dtype=np.float64) / (2 * n)
        return np.asarray(self.spectrum(f, 1.0) - self.T**2 * self.ends(k, n))

    def ends(self, k: Values, n: int) -> Values:
        """What the ends of a record add to the k-th coefficient of the DCT-II of the derivative of such a process."""
        # The sums of exp(-u h) over h < n are geometric series.
        k = np.asarray(k, dtype=np.float64)
        s = np.sin((0.5 * math.pi / n) * k) ** 2
        other = np.where(k % 2 == 0, -np.expm1(-self.u * n), 1 + np.exp(-self.u * n))  # 1 - (-1)^k exp(-u n)
        return np.asarray(4 / n * (1 - s) * other * self.lorentzian(s) ** 2)

    def lorentzian(self, s: Values) -> Values:
        """(1 - p)^2 / ((1 - p)^2 + 4 p s) with p = exp(-u), at s = sin^2(omega / 2): 1 at low frequencies."""
        return np.asarray(1 / (1 + 4 * s * np.exp(-self.u) / self.loss**2))


SHORTEST = 3.0  # samples from which a time constant can be distinguished from white noise


def gauss_markov(T: float) -> NoiseTerm:
    """The row of Gauss-Markov rate noise, with a time constant of T sample intervals."""
    functions = Exponential(1 / T)
    return NoiseTerm(
        symbol="GM", synonyms=("markov",), title=say("Gauss-Markov noise"),
        meaning=say("exponentially correlated (first-order Gauss-Markov) noise of the rate, with a time constant T"),
        quantity_meaning=say("exponentially correlated (first-order Gauss-Markov) noise with a time constant T"),
        formula=r"\sigma^2(\tau) = (2 s^2 T / \tau) (1 - (T / 2 \tau) (3 - 4 \exp(-\tau/T) + \exp(-2 \tau/T)))",
        reference=say("IEEE Std 952; s is the RMS rate, q = s sqrt(2/T) the driving noise"),
        power=0.0, slope=math.nan, read_at=math.nan, level=math.nan, structure=functions.structure,
        derivative=functions.derivative, summed=functions.summed, increments=functions.increments,
        spectrum=functions.spectrum, dct=functions.dct, parameters=(time_constant(20.0, SHORTEST),), shape=(T,),
        shaped=lambda shape, rate: gauss_markov(shape[0] * rate), density=r"S(f) = \frac{2 s^2 T}{1 + (2 \pi f T)^2}",
        origin="A single relaxation process: a temperature that follows its surroundings, a trapped charge, a filter "
        "at the output, a control loop. Sums of a few such processes with time constants a decade apart can "
        "hardly be distinguished from flicker.",
        advice="A hump: the Allan deviation increases with slope +1/2 up to tau = 1.89 T, where it is 0.617 s, and "
        "decreases with slope -1/2 beyond. Well below T it resembles a rate random walk with K = s sqrt(2/T), "
        "well above an angle random walk with N = s sqrt(2 T). In a Kalman filter it is a state with Phi = "
        "exp(-tau0/T) and the driving noise s^2 (1 - Phi^2). A flat top of the hump is not flicker: the "
        "likelihood distinguishes the two if the record permits.",
        color="#72780E", dark="#BBFD7A", dash=(8, 1.8, 1.4, 1.8, 1.4, 1.8),
        block=lambda size, shape, h: markov_block(size, shape[0], h), second="GML",
    )  # fmt: skip


def slow_gauss_markov(T: float) -> NoiseTerm:
    """The row of a second Gauss-Markov rate noise, of a longer time constant than the first."""
    return replace(gauss_markov(T), symbol="GML", synonyms=("GM GM",), title=say("slow Gauss-Markov noise"),
                   meaning=say("Gauss-Markov noise of the rate beside another, GM, whose time constant is shorter"),
                   quantity_meaning=say("Gauss-Markov noise beside another, GM, whose time constant is shorter"),
                   parameters=(time_constant(600.0, SHORTEST),),
                   shaped=lambda shape, rate: slow_gauss_markov(shape[0] * rate), origin="A second relaxation process "
                   "beside that of GM: the temperature of a housing beside that of a sensor, a second control loop.",
                   advice="A second hump, at a longer averaging time than that of GM. It is looked for when both are "
                   "among the terms that are asked for: N,GM,GM is N,GM,GML. One process alone is called GM.",
                   color="#872D96", dark="#C36900", dash=(8, 1.8, 1.4, 1.8), second="")  # fmt: skip


def markov_block(size: float, T: float, h: float) -> Block:
    """Gauss-Markov noise of RMS `size` and time constant `T`."""
    u = h / T
    loss = -math.expm1(-u)
    # (2u - 3 + 4 exp(-u) - exp(-2u)) / u^2, without cancellation: what the noise within the interval adds
    var_mean = size**2 * (
        (2 * u - 3 + 4 * math.exp(-u) - math.exp(-2 * u)) / u**2
        if u > 0.3
        else math.fsum((-1) ** k * (4 - 2.0**k) / math.factorial(k) * u ** (k - 2) for k in range(3, 20))
    )
    Q = np.array([[-math.expm1(-2 * u) * size**2, size**2 * loss**2 / u], [size**2 * loss**2 / u, var_mean]])
    return Block(names=((say("Gauss-Markov rate, T = {time:.6g} s", time=T), 0),), F=np.array([[-1 / T]]),
                 Qc=np.array([[2 * size**2 / T]]), Phi=np.array([[math.exp(-u)]]), mean=np.array([loss / u]), Q=Q,
                 P0=np.array([[size**2]]), output=np.ones(1))  # fmt: skip


GAUSS_MARKOV, SLOW_GAUSS_MARKOV = gauss_markov(1.0), slow_gauss_markov(1.0)

SHORTEST_ANGLE = 0.5  # samples from which a time constant can be distinguished from quantization
LEAST = 0.02  # power of a coefficient over that of the spectrum, at least


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
        symbol="GMA", title=say("Gauss-Markov noise of the angle"),
        titles={
            "accelerometer": say("Gauss-Markov noise of the velocity"),
            "dimensionless": say("Gauss-Markov noise of the time"),
        },
        meaning=say("exponentially correlated (first-order Gauss-Markov) noise of the angle, with a time constant T"),
        quantity_title=say("Gauss-Markov noise of the integrated {quantity}"),
        quantity_meaning=say("exponentially correlated (first-order Gauss-Markov) noise of the integral, with a time "
                             "constant T"),
        formula=r"\sigma^2(\tau) = (s^2 / \tau^2) (3 - 4 \exp(-\tau/T) + \exp(-2 \tau/T))",
        reference=say("a first-order Markov process of the angle; structure function 2 s^2 (1 - exp(-t/T)), s the "
                      "RMS angle"),
        power=1.0, slope=math.nan, read_at=math.nan, level=math.nan,
        structure=lambda t: -2 * np.expm1(-u * np.asarray(t, dtype=np.float64)),
        derivative=derivative, summed=summed, increments=increments, spectrum=spectrum, dct=dct, ends=1.0,
        parameters=(time_constant(2.0, SHORTEST_ANGLE),), shape=(T,),
        shaped=lambda shape, rate: angle_markov(shape[0] * rate),
        density=r"S(f) = \frac{2 s^2 T (2 \pi f)^2}{1 + (2 \pi f T)^2}",
        origin="An error of the angle itself that is forgotten within a time constant: backlash and friction of a "
        "mechanism, eccentricity of a readout that turns slowly, the residual motion of a stabilized platform, "
        "the residual dither of a ring laser after its removal by a filter.",
        advice="Below T it is angle random walk with N = s sqrt(2/T), slope -1/2; above, it is bounded and falls with "
        "slope -1 as quantization does, with Q = s. With T below a sample interval it cannot be told from "
        "quantization, with T above the record's length not from angle random walk. It is looked for when its "
        "symbol is among the terms that are asked for. In a Kalman filter it is a state of the angle error.",
        typical=0.5, color="#0E13FC", dark="#3BF9B4", dash=(6, 1.4, 3, 1.4),
        block=lambda size, shape, h: angle_markov_block(size, shape[0], h),
    )  # fmt: skip


def angle_markov_block(size: float, T: float, h: float) -> Block:
    """Gauss-Markov noise of the angle of RMS `size` and time constant `T`: the mean rate is its change over h."""
    loss, driven = -math.expm1(-h / T), -math.expm1(-2 * h / T) * size**2
    return Block(names=((say("Gauss-Markov angle, T = {time:.6g} s", time=T), 1),), F=np.array([[-1 / T]]),
                 Qc=np.array([[2 * size**2 / T]]), Phi=np.array([[math.exp(-h / T)]]), mean=np.array([-loss / h]),
                 Q=driven * np.array([[1.0, 1 / h], [1 / h, 1 / h**2]]), P0=np.array([[size**2]]),
                 output=np.zeros(1), note=say("the error of the angle is a state: its change over the interval enters "
                                              "the mean rate"))  # fmt: skip


ANGLE_MARKOV = angle_markov(1.0)
