"""The table of noise terms: pure mathematics, one row a term.

A term enters every statistic through one function, its structure function ``D(t) = E[(x(s+t) - x(s))^2]`` of the angle
x (in the generalised sense: polynomials that every statistic here removes are left out). All functions are for a
coefficient of 1 and, but for `structure` and `spectrum`, for a sample interval of 1; they are linear in the square of
the coefficient.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LN2 = math.log(2.0)


@dataclass(frozen=True)
class NoiseTerm:
    """A row of `TERMS`.

    Attributes
    ----------
    symbol, title, meaning, formula, reference
        What it is, in words and in LaTeX (Allan variance), and where that is written.
    power : float
        The coefficient is a signal times time to this power.
    slope : float
        Slope of log Allan deviation against log tau.
    read_at : float
        The asymptote, a straight line of that slope, has the value of the coefficient at this tau (in units of time).
    level : float
        Allan variance of the term at tau = 1 for a coefficient of 1.
    structure : t -> D(t)
        For t >= 0.
    derivative : (order, t) -> d^order D/dt^order
        For t > 0 and orders from 1 on: the far field of D, where differences of D itself would cancel.
    summed : l -> E(l)
        Second sum of D over integers, ``E(l+1) - 2 E(l) + E(l-1) = D(l)``, but for a square of l, which the statistics
        remove; for l >= 0, and between the integers from l = 3 on.
    increments : h -> covariance of the first differences of the rate, at lag h >= 0 samples.
    spectrum : (f, tau0) -> two-sided spectral density of the sampled rate, its mean over each tau0, aliases included.
        For 0 < f <= 1 / (2 tau0).
    dct : (k, n) -> variance of the k-th coefficient of the orthonormal DCT-II of n rates.
    edge : float
        Variance that the first and the last rate have beyond that.
    waveform : n -> the rate itself, for a deterministic term of coefficient 1; None for noise.
    density : str
        LaTeX of the two-sided spectral density of the rate, at frequencies far below the sampling rate but for Q.
    origin, advice : str
        For the documentation: where it comes from, and how it is read off and used.
    """

    symbol: str
    title: str
    meaning: str
    formula: str
    reference: str
    power: float
    slope: float
    read_at: float
    level: float
    structure: Callable[[FloatArray], FloatArray]
    derivative: Callable[[int, FloatArray], FloatArray]
    summed: Callable[[FloatArray], FloatArray]
    increments: Callable[[FloatArray], FloatArray]
    spectrum: Callable[[FloatArray, float], FloatArray]
    dct: Callable[[FloatArray, int], FloatArray]
    edge: float = 0.0
    waveform: Callable[[int], FloatArray] | None = None
    density: str = ""
    origin: str = ""
    advice: str = ""


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


def _sine_squared(k: FloatArray, n: int) -> FloatArray:
    """sin^2(omega/2) at omega = pi k / n."""
    return np.asarray(np.sin((0.5 * math.pi / n) * k) ** 2)


def _flicker_structure(t: FloatArray) -> FloatArray:
    t = np.asarray(t, dtype=np.float64)
    return -(t * t) * np.log(np.where(t > 0, t, 1.0)) / math.pi


def _flicker_derivative(order: int, t: FloatArray) -> FloatArray:
    if order == 1:
        return -(2 * np.log(t) + 1) * t / math.pi
    if order == 2:
        return -(2 * np.log(t) + 3) / math.pi
    sign = 1 if order % 2 else -1
    return -2 * sign * math.factorial(order - 3) / t ** (order - 2) / math.pi


def _flicker_increments(h: FloatArray) -> FloatArray:
    near = np.minimum(h, 30.0)
    D = _flicker_structure
    direct = -0.5 * (6 * D(near) - 4 * D(np.abs(near - 1)) - 4 * D(near + 1) + D(np.abs(near - 2)) + D(near + 2))
    far = np.maximum(h, 30.0) ** -2.0
    # fourth difference of h^2 ln h in powers of 1/h: the direct form loses (h^4) digits
    series = -far * (2 + far * (2 + far * (3 + far * 17 / 3))) / (2 * math.pi)
    return np.where(h < 30, direct, series)


def _flicker_series(t: FloatArray) -> FloatArray:
    """Euler-Maclaurin series of the second sum of t^2 ln t."""
    log = np.log(t)
    powers = 1 / (3024 * t**2) - 1 / (14400 * t**4) + 4.5094e-5 / t**6
    return t**4 * (log / 12 - 7 / 144) - t * t * log / 12 + log / 120 + powers + ZETA3 / (4 * math.pi**2) * t


def _flicker_near() -> FloatArray:
    """The second sum at 0 .. 13: the recursion down from where the series is exact."""
    e = np.zeros(14)
    e[12:] = _flicker_series(np.array([12.0, 13.0]))
    for k in range(12, 0, -1):
        e[k - 1] = k * k * math.log(k) + 2 * e[k] - e[k + 1]
    return e


ZETA3 = 1.2020569031595942
_FLICKER_NEAR = _flicker_near()


def _flicker_summed(t: FloatArray) -> FloatArray:
    t = np.asarray(t, dtype=np.float64)
    near = (t < 12) & (t == np.floor(t))
    table = _FLICKER_NEAR[np.where(near, t, 0).astype(np.int64)]
    return -np.where(near, table, _flicker_series(np.where(near, 12.0, t))) / math.pi


FLICKER_EDGE = np.array([0.7737, 0.9028, 0.9311, 0.9499, 0.9592, 0.9664, 0.9709, 0.9747])


def _flicker_spectrum(f: FloatArray, tau0: float) -> FloatArray:
    from scipy.special import zeta

    x = np.asarray(f, dtype=np.float64) * tau0
    aliases = zeta(3, x) + zeta(3, 1 - x)
    return np.asarray(4 * tau0 * np.sin(math.pi * x) ** 2 * aliases / (2 * math.pi) ** 3)


def _flicker_dct(k: FloatArray, n: int) -> FloatArray:
    # DCT-II does not quite diagonalise flicker: a factor of k alone, whatever n (computed exactly for k <= 8)
    edge = np.where(
        k < 8.5, FLICKER_EDGE[np.clip(k, 1, 8).astype(np.int64) - 1], 1 - 2 / (math.pi**2 * np.maximum(k, 1))
    )
    return np.asarray(_flicker_spectrum(k / (2.0 * n), 1.0) * edge)


def _random_walk_spectrum(f: FloatArray, tau0: float) -> FloatArray:
    s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
    return np.asarray(tau0**2 * (1 - 2 * s / 3) / (4 * s))


def ramp_coefficients(k: FloatArray, n: int) -> FloatArray:
    """DCT-II coefficients (orthonormal) of the rate j - (n-1)/2, j = 0..n-1, at k >= 1; zero at even k."""
    half = (0.5 * math.pi / n) * k
    odd = np.asarray(k, dtype=np.int64) % 2
    return np.asarray(-math.sqrt(2.0 / n) * odd * np.cos(half) / (2 * np.sin(half) ** 2))


def _ramp(n: int) -> FloatArray:
    return np.arange(n, dtype=np.float64) - (n - 1) / 2


TERMS: dict[str, NoiseTerm] = {
    "Q": NoiseTerm(
        symbol="Q",
        title="quantization noise",
        meaning="white noise of the angle: rounding of the angle output, or timing jitter of the readout",
        formula=r"\sigma^2(\tau) = 3 Q^2 / \tau^2",
        reference="IEEE Std 952; Q = LSB / sqrt(12) for a dithered angle quantizer",
        power=1.0,
        slope=-1.0,
        read_at=math.sqrt(3.0),
        level=3.0,
        structure=lambda t: np.where(np.asarray(t) > 0, 2.0, 0.0),
        derivative=_monomial(2.0, 0),
        summed=lambda t: -np.asarray(t, dtype=np.float64),
        increments=_at_small_lags(6.0, -4.0, 1.0),
        spectrum=lambda f, tau0: 4 / tau0 * np.sin(math.pi * f * tau0) ** 2,
        dct=lambda k, n: 4 * _sine_squared(k, n),
        edge=1.0,
        density=r"S(f) = \frac{4 Q^2}{\tau_0} \sin^2(\pi f \tau_0) \approx (2 \pi f)^2 \tau_0 Q^2",
        origin="Rounding of an angle output: the pulses of a ring laser gyroscope or of a rebalance loop, and the "
        "jitter of the instant at which they are read. What one sample loses the next one gains, so that the "
        "angle never errs by more than a step. Rounding of a rate output is something else: its errors add "
        "up, and make angle random walk.",
        advice="It rules the shortest averaging times with slope -1. The line has the value of Q at tau = sqrt(3). "
        "Overlapped Allan and Hadamard deviation cannot tell it from other noise of the angle; in the "
        "modified Allan deviation it falls faster, with slope -3/2. It does not grow with time: for "
        "navigation beyond seconds it can mostly be ignored.",
    ),
    "N": NoiseTerm(
        symbol="N",
        title="angle random walk",
        meaning="white noise of the rate; the angle error grows as N sqrt(t)",
        formula=r"\sigma^2(\tau) = N^2 / \tau",
        reference="IEEE Std 952",
        power=0.5,
        slope=-0.5,
        read_at=1.0,
        level=1.0,
        structure=lambda t: np.asarray(t, dtype=np.float64),
        derivative=_monomial(1.0, 1),
        summed=lambda t: (np.asarray(t) ** 3 - t) / 6,
        increments=_at_small_lags(2.0, -1.0),
        spectrum=lambda f, tau0: np.ones_like(f),
        dct=lambda k, _: np.ones_like(k),
        density=r"S(f) = N^2",
        origin="Everything that is faster than the sampling: shot noise of the light and spontaneous emission in "
        "optical gyroscopes, thermal motion of the proof mass and noise of the amplifier in micromechanical "
        "ones, dither of a ring laser, rounding of a rate output.",
        advice="Slope -1/2; N is the value of the line at tau = 1, in the unit of time of the coefficient: one hour "
        "for deg/sqrt(h). It is the square root of the two-sided density; a one-sided density "
        "(scipy.signal.welch, many data sheets) gives sqrt(2) N. A sample of duration tau0 has the standard "
        "deviation N / sqrt(tau0); after a time t the angle has wandered by N sqrt(t).",
    ),
    "B": NoiseTerm(
        symbol="B",
        title="bias instability",
        meaning="flicker of the rate: the floor of the Allan deviation lies at 0.664 B",
        formula=r"\sigma^2(\tau) = (2 \ln 2 / \pi) B^2",
        reference="IEEE Std 952",
        power=0.0,
        slope=0.0,
        read_at=1.0,
        level=2 * LN2 / math.pi,
        structure=_flicker_structure,
        derivative=_flicker_derivative,
        summed=_flicker_summed,
        increments=_flicker_increments,
        spectrum=_flicker_spectrum,
        dct=_flicker_dct,
        density=r"S(f) = \frac{B^2}{2 \pi f}",
        origin="Flicker of electronics, of the discharge in a ring laser, of whatever has many relaxation times: a "
        "spectrum that rises as 1/f towards low frequencies, so that every decade of time brings as much "
        "wandering of the bias as the one before.",
        advice="The flat part of the curve lies at 0.664 B. The minimum of the curve is not B: angle and rate random "
        "walk make a minimum by themselves, at sqrt(2 N K / sqrt(3)), without any flicker. Kalman filters "
        "have no state for it; it is stood in for by one or several Gauss-Markov processes.",
    ),
    "K": NoiseTerm(
        symbol="K",
        title="rate random walk",
        meaning="random walk of the rate; the bias wanders as K sqrt(t)",
        formula=r"\sigma^2(\tau) = K^2 \tau / 3",
        reference="IEEE Std 952; the rate is the mean over each sample interval",
        power=-0.5,
        slope=0.5,
        read_at=3.0,
        level=1 / 3,
        structure=lambda t: -(np.asarray(t, dtype=np.float64) ** 3) / 6,
        derivative=_monomial(-1 / 6, 3),
        summed=lambda t: -(np.asarray(t) ** 5 / 20 - np.asarray(t) ** 3 / 12 + np.asarray(t) / 30) / 6,
        increments=_at_small_lags(2 / 3, 1 / 6),
        spectrum=_random_walk_spectrum,
        dct=lambda k, n: _random_walk_spectrum(k / (2.0 * n), 1.0),
        density=r"S(f) = \frac{K^2}{(2 \pi f)^2}",
        origin="Slow change that adds up: temperature that wanders, ageing, the beginning of an exponentially "
        "correlated process whose correlation time is longer than the record.",
        advice="Slope +1/2; K is the value of the line at tau = 3. It lives at the long end, where the curve has few "
        "degrees of freedom: one record of a length of 10 tau says little about it at tau. It is the driving "
        "noise of the bias state of a Kalman filter, K^2 per second; the 'gyroscope_random_walk' of kalibr.",
    ),
    "R": NoiseTerm(
        symbol="R",
        title="rate ramp",
        meaning="a steady drift of the rate, with a sign",
        formula=r"\sigma^2(\tau) = R^2 \tau^2 / 2",
        reference="IEEE Std 952",
        power=-1.0,
        slope=1.0,
        read_at=math.sqrt(2.0),
        level=0.5,
        structure=lambda t: -(np.asarray(t, dtype=np.float64) ** 4) / 12,
        derivative=_monomial(-1 / 12, 4),
        summed=lambda t: -(np.asarray(t) ** 6 / 30 - np.asarray(t) ** 4 / 12 + np.asarray(t) ** 2 / 20) / 12,
        increments=_at_small_lags(0.0),
        spectrum=lambda f, tau0: np.zeros_like(f),
        dct=lambda k, _: np.zeros_like(k),
        waveform=_ramp,
        origin="A steady change during the record: warming up, ageing, a light source that fades, a platform that "
        "turns ever faster. It is no noise, and the next record may have another one.",
        advice="Slope +1; the size of R is the value of the line at tau = sqrt(2). A curve has no sign, so that here "
        "R is estimated from the record. The Hadamard deviation does not see it: where the Allan deviation is "
        "more than sqrt(2) times the Hadamard deviation, there is a ramp, or a noise steeper than a random "
        "walk. Remove it by a model of its cause (temperature), not by a fitted line, before you speak of the "
        "noise at long times.",
    ),
}
