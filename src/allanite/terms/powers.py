"""Terms whose structure function is a power of t: quantization, angle and rate random walk, ramp."""

import math
from collections.abc import Callable

import numpy as np

from allanite.phrases.phrase import say

from .row import Block, FloatArray, NoiseTerm


def _monomial(coefficient: float, power: int) -> Callable[[int, FloatArray], FloatArray]:
    """Derivatives of ``coefficient * t^power``."""

    def derivative(order: int, t: FloatArray) -> FloatArray:
        if order > power:
            return np.zeros_like(t)
        return coefficient * math.perm(power, order) * t ** (power - order)

    return derivative


def _at_small_lags(*values: float) -> Callable[[FloatArray], FloatArray]:
    """Function of the lag with these values at 0, 1, 2, ... and zero beyond."""
    table = np.array([*values, 0.0])
    return lambda h: table[np.minimum(h, len(values)).astype(np.int64)]


def _random_walk_spectrum(f: FloatArray, tau0: float) -> FloatArray:
    s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
    return np.asarray(tau0**2 * (1 - 2 * s / 3) / (4 * s))


def ramp_coefficients(k: FloatArray, n: int) -> FloatArray:
    """DCT-II coefficients (orthonormal) of the rate j - (n-1)/2, j = 0..n-1, at k >= 1; zero at even k."""
    half = (0.5 * math.pi / n) * k
    odd = np.asarray(k, dtype=np.int64) % 2
    return np.asarray(-math.sqrt(2.0 / n) * odd * np.cos(half) / (2 * np.sin(half) ** 2))


def white_noise(N: float, h: float) -> Block:
    """White rate noise: no state, only measurement noise."""
    nothing, empty = np.zeros((0, 0)), np.zeros(0)
    return Block((), nothing, nothing, nothing, empty, np.zeros((1, 1)), nothing, empty, white=N**2 / h)


def integrators(names: tuple[str, ...], h: float, *, density: float = 0.0, start: float = 0.0, note: str = "") -> Block:
    """The bias and its derivatives, the last of them driven by white noise of `density`."""
    # `names` are those of the states; `start` is the standard deviation of the last one at the start.
    s = len(names)
    order = np.subtract.outer(np.arange(s), np.arange(s)).T  # how often state j is integrated to give state i
    factorial = np.array([math.factorial(k) for k in range(s + 2)], dtype=np.float64)
    Phi = np.where(order >= 0, h ** np.maximum(order, 0) / factorial[np.maximum(order, 0)], 0.0)
    # after a time u an impulse has left u^a / a! in a state, and in the mean u^s / s! over h
    a = np.append(np.arange(s - 1, -1, -1), s)
    lost = np.append(np.zeros(s), 1)
    power = 1 + np.add.outer(a, a)
    Q = density * h ** (power - np.add.outer(lost, lost)) / (power * np.outer(factorial[a], factorial[a]))
    Qc, P0 = np.zeros((s, s)), np.zeros((s, s))
    Qc[-1, -1], P0[-1, -1] = density, start**2
    return Block(names=tuple((name, -float(k)) for k, name in enumerate(names)), F=np.eye(s, k=1), Qc=Qc,
                 Phi=Phi, mean=h ** np.arange(s) / factorial[1 : s + 1], Q=Q, P0=P0, output=np.eye(s)[0], bias=True,
                 note=note)  # fmt: skip


def angle_noise(Q: float, h: float) -> Block:
    """White angle noise: the mean rate over an interval gets the difference of its ends' errors, over h."""
    # A state of discrete time: the error of the angle at the end of the interval, new in every interval.
    return Block(names=((say("angle error"), 1),), F=np.zeros((1, 1)), Qc=np.zeros((1, 1)),
                 Phi=np.zeros((1, 1)), mean=np.array([-1 / h]), Q=Q**2 * np.array([[1.0, 1 / h], [1 / h, 1 / h**2]]),
                 P0=np.array([[Q**2]]), output=np.zeros(1),
                 note=say("quantization is modelled as white Gaussian angle noise; that it is bounded by half a step, "
                          "and depends on the angle itself, is neglected"))  # fmt: skip


TITLES = {"accelerometer": (say("velocity random walk"), say("acceleration random walk"), say("acceleration ramp")),
          "dimensionless": (say("time random walk"), say("signal random walk"), say("signal ramp"))}  # fmt: skip
"""Where N, K and R are called otherwise than for a gyro: name of the signal -> their titles."""


def _titles(place: int) -> dict[str, str]:
    return {signal: titles[place] for signal, titles in TITLES.items()}


QUANTIZATION = NoiseTerm(
    symbol="Q", synonyms=("QN",), title=say("quantization noise"),
    meaning=say("white noise of the angle: rounding of the angle output, or timing jitter of the readout"),
    quantity_title=say("white noise of the integrated {quantity}"),
    quantity_meaning=say("noise whose spectral density grows as the square of the frequency; its integral is white"),
    formula=r"\sigma^2(\tau) = 3 Q^2 / \tau^2",
    reference=say("IEEE Std 952; Q = LSB / sqrt(12) for a dithered angle quantizer"),
    power=1.0, slope=-1.0, read_at=math.sqrt(3.0), level=3.0, structure=lambda t: np.where(np.asarray(t) > 0, 2.0, 0.0),
    derivative=_monomial(2.0, 0), summed=lambda t: -np.asarray(t, dtype=np.float64),
    increments=_at_small_lags(6.0, -4.0, 1.0), spectrum=lambda f, tau0: 4 / tau0 * np.sin(math.pi * f * tau0) ** 2,
    dct=lambda k, n: 4 * np.asarray(np.sin((0.5 * math.pi / n) * k) ** 2), edge=1.0,
    density=r"S(f) = \frac{4 Q^2}{\tau_0} \sin^2(\pi f \tau_0) \approx (2 \pi f)^2 \tau_0 Q^2",
    origin="Rounding of an angle output: the pulses of a ring laser gyroscope or of a rebalance loop, and the jitter "
    "of the readout times. What one sample loses the next one gains, so that the angle error never exceeds a "
    "step. Rounding of a rate output is different: its errors accumulate and produce angle random walk.",
    advice="It dominates the shortest averaging times, with slope -1. The line has the value Q at tau = sqrt(3). "
    "Overlapping Allan and Hadamard deviations cannot distinguish it from other angle noise; in the modified "
    "Allan deviation it falls faster, with slope -3/2. It does not grow with time: in navigation beyond a few "
    "seconds it can usually be neglected.",
    typical=0.5, color="#B24282", dark="#C061AE", dash=(1.2, 1.6), alpha=2, automatic=True,
    block=lambda Q, shape, h: angle_noise(Q, h),
)  # fmt: skip

ANGLE_RANDOM_WALK = NoiseTerm(
    symbol="N", synonyms=("ARW", "VRW"), title=say("angle random walk"), titles=_titles(0),
    meaning=say("white noise of the rate; the angle error grows as N sqrt(t)"),
    quantity_title=say("white noise of the {quantity}"),
    quantity_meaning=say("white noise of the samples, among it their rounding; averaging reduces it with the square "
                         "root of time"),
    formula=r"\sigma^2(\tau) = N^2 / \tau", reference="IEEE Std 952", power=0.5, slope=-0.5, read_at=1.0, level=1.0,
    structure=lambda t: np.asarray(t, dtype=np.float64), derivative=_monomial(1.0, 1),
    summed=lambda t: (np.asarray(t) ** 3 - t) / 6, increments=_at_small_lags(2.0, -1.0),
    spectrum=lambda f, tau0: np.ones_like(f), dct=lambda k, _: np.ones_like(k), density=r"S(f) = N^2",
    origin="All noise faster than the sampling: shot noise and spontaneous emission in optical gyroscopes, thermal "
    "motion of the proof mass and amplifier noise in MEMS gyroscopes, dither of a ring laser, rounding of a "
    "rate output.",
    advice="Slope -1/2; N is the value of the line at tau = 1, in the unit of time of the coefficient: one hour for "
    "deg/sqrt(h). It is the square root of the two-sided power spectral density; a one-sided one "
    "(scipy.signal.welch, many data sheets) gives sqrt(2) N. A sample of duration tau0 has the standard "
    "deviation N / sqrt(tau0); after a time t the standard deviation of the angle is N sqrt(t).",
    typical=0.1, color="#2E74C9", dark="#8BB5F6", dash=(6, 2.4), alpha=0, automatic=True,
    block=lambda N, shape, h: white_noise(N, h),
)  # fmt: skip

RATE_RANDOM_WALK = NoiseTerm(
    symbol="K", synonyms=("RRW",), title=say("rate random walk"), titles=_titles(1),
    meaning=say("random walk of the rate; the bias drifts as K sqrt(t)"),
    quantity_title=say("random walk of the {quantity}"),
    quantity_meaning=say("changes that accumulate; over a time t they have the standard deviation K sqrt(t)"),
    formula=r"\sigma^2(\tau) = K^2 \tau / 3",
    reference=say("IEEE Std 952; the rate is the mean over each sample interval"),
    power=-0.5, slope=0.5, read_at=3.0, level=1 / 3, structure=lambda t: -(np.asarray(t, dtype=np.float64) ** 3) / 6,
    derivative=_monomial(-1 / 6, 3),
    summed=lambda t: -(np.asarray(t) ** 5 / 20 - np.asarray(t) ** 3 / 12 + np.asarray(t) / 30) / 6,
    increments=_at_small_lags(2 / 3, 1 / 6), spectrum=_random_walk_spectrum,
    dct=lambda k, n: _random_walk_spectrum(k / (2.0 * n), 1.0), density=r"S(f) = \frac{K^2}{(2 \pi f)^2}",
    origin="Slow changes that accumulate: a drifting temperature, ageing, or an exponentially correlated process whose "
    "correlation time is longer than the record.",
    advice="Slope +1/2; K is the value of the line at tau = 3. It is visible at long averaging times, where the curve "
    "has few degrees of freedom: a record of 10 tau says little about it at tau. It is the driving noise of the "
    "bias state of a Kalman filter, K^2 per second; the 'gyroscope_random_walk' of kalibr.",
    typical=10.0, color="#5B0200", dark="#E95C5D", dash=(3.2, 1.6), alpha=-2, automatic=True,
    block=lambda K, shape, h: integrators((say("bias, random walk") if K else say("bias"),), h, density=K**2),
)  # fmt: skip

RAMP = NoiseTerm(
    symbol="R", synonyms=("RR", "ramp", "drift"), title=say("rate ramp"), titles=_titles(2),
    meaning=say("a linear drift of the rate, with a sign"), quantity_title=say("ramp of the {quantity}"),
    quantity_meaning=say("a linear drift, with a sign"), formula=r"\sigma^2(\tau) = R^2 \tau^2 / 2",
    reference="IEEE Std 952", power=-1.0, slope=1.0, read_at=math.sqrt(2.0), level=0.5,
    structure=lambda t: -(np.asarray(t, dtype=np.float64) ** 4) / 12, derivative=_monomial(-1 / 12, 4),
    summed=lambda t: -(np.asarray(t) ** 6 / 30 - np.asarray(t) ** 4 / 12 + np.asarray(t) ** 2 / 20) / 12,
    increments=_at_small_lags(0.0), spectrum=lambda f, tau0: np.zeros_like(f), dct=lambda k, _: np.zeros_like(k),
    waveform=lambda n: np.arange(n, dtype=np.float64) - (n - 1) / 2,
    origin="A steady change during the record: warm-up, ageing, a fading light source, an accelerating platform. It is "
    "not a noise, and the next record may have a different one.",
    advice="Slope +1; |R| is the value of the line at tau = sqrt(2). A curve has no sign, so that R is estimated from "
    "the record. The Hadamard deviation is insensitive to it: where the Allan deviation is more than sqrt(2) "
    "times the Hadamard deviation, there is a ramp, or a noise steeper than a random walk. Remove it with a "
    "model of its cause (temperature), not with a fitted line, before interpreting the noise at long times.",
    typical=10.0, color="#6C4000", dark="#EBA008", dash=(11, 2.6), automatic=True,
    block=lambda R, shape, h: integrators(
        (say("bias"), say("rate ramp")),
        h,
        start=R, note=say("the ramp is a state whose initial standard deviation is |R|, without driving noise"),
    ),
)  # fmt: skip
