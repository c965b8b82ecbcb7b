r"""The complementary loop: how gyro and accelerometer errors reach the angle, in continuous time and as it is sampled.

The angle is propagated with the gyro and pulled towards the tilt that the accelerometer reads,

    theta' = omega - b + k1 (tilt - theta),    b' = -k2 (tilt - theta),

with k2 = 0 for the filter of first order, whose time constant is 1 / k1. Rate noise n_g and tilt noise n_a make the
error

    E = (N_g + (k1 + k2 / s) N_a) / (s + k1 + k2 / s).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from allanite.extending import FloatArray, UsageError, Value, given, public, spelled

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, repr=False)
class Loop(Value):
    """A complementary filter.

    Attributes
    ----------
    k1 : float
        Gain of the angle, 1/s.
    k2 : float
        Gain of the gyro bias, 1/s^2; 0 for the filter of first order.

    Examples
    --------
    >>> Loop.of(1.5).time_constant, Loop(0.9, 0.016).order, round(Loop(0.89099, 0.016160).damping, 2)
    (1.5, 2, 3.5)
    """

    _also = ("order", "time_constant")

    k1: float
    k2: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.k1) and self.k1 > 0 and math.isfinite(self.k2) and self.k2 >= 0):
            raise UsageError(
                f"a filter has a gain k1 above 0 and k2 of at least 0, not k1 = {given(self.k1)}, k2 = {given(self.k2)}"
            )

    @classmethod
    def of(cls, time_constant: "float | Loop") -> "Loop":
        """The filter of first order with this time constant, s; a filter is returned as it is."""
        if isinstance(time_constant, Loop):
            return time_constant
        if not (math.isfinite(time_constant) and time_constant > 0):
            raise UsageError(f"a time constant must be a number of seconds above 0, not {given(time_constant)}")
        return cls(1 / time_constant)

    @property
    def order(self) -> int:
        """1, or 2 if the filter estimates the gyro bias."""
        return 2 if self.k2 else 1

    @property
    def time_constant(self) -> float:
        """1 / k1, s."""
        return 1 / self.k1

    @property
    def frequency(self) -> float:
        """Natural frequency of the filter of second order, rad/s."""
        return math.sqrt(self.k2)

    @property
    def damping(self) -> float:
        """Damping ratio of the filter of second order."""
        return self.k1 / (2 * self.frequency) if self.k2 else math.inf

    def scaled(self, factor: float) -> "Loop":
        """The filter whose time constants are longer by a factor."""
        return Loop(self.k1 / factor, self.k2 / factor**2)

    def responses(self, f: FloatArray, interval: float | None = None) -> tuple[ComplexArray, ComplexArray]:
        """Responses of the error to rate noise (s) and to tilt noise, at frequencies in Hz.

        With a sample interval, those of the recursion

            prediction = theta + (omega - b) dt,    theta = alpha prediction + (1 - alpha) tilt,
            b = b - k2 dt (tilt - prediction),      alpha = exp(-k1 dt).
        """
        if interval is None:
            s = 2j * math.pi * np.asarray(f, dtype=np.float64)
            pull = self.k1 + self.k2 / s
            return np.reciprocal(s + pull), pull / (s + pull)
        alpha = math.exp(-self.k1 * interval)
        back = np.exp(-2j * math.pi * np.asarray(f, dtype=np.float64) * interval)
        # 1 - back without cancellation
        rise = 2j * np.sin(math.pi * np.asarray(f) * interval) * np.exp(-1j * math.pi * np.asarray(f) * interval)
        bias = self.k2 * interval**2 * back / rise
        loop: ComplexArray = 1 - alpha + alpha * rise + bias
        gain: ComplexArray = alpha * interval / loop
        return gain, (1 - alpha + bias) / loop

    def demand_sampled(self, interval: float) -> None:
        """Refuse a time constant that is not above the sample interval.

        Raises
        ------
        UsageError
        """
        if self.time_constant <= interval:
            raise UsageError(
                f"the time constant must be above the sample interval of {interval:g} s, not {self.time_constant:g} s: "
                f"the angle would be that of the accelerometer alone; give a longer one with "
                f"{spelled('--time-constant', 'time_constant=...')}"
            )

    def _summary(self) -> str:
        second = f", k2 = {self.k2:.4g} 1/s^2" if self.k2 else ""
        return f"k1 = {self.k1:.4g} 1/s{second}"


@public
def kalman(N: float, tilt: float, K: float = 0.0) -> Loop:
    """The steady Kalman filter for white noises and a rate random walk, in closed form.

    Parameters
    ----------
    N : float
        Angle random walk of the gyro, rad/sqrt(s).
    tilt : float
        White noise of the tilt, rad/sqrt(Hz).
    K : float
        Rate random walk of the gyro, rad/s^1.5.

    Returns
    -------
    Loop
        k1 = sqrt(N^2 + 2 K tilt) / tilt, k2 = K / tilt; without K the complementary filter of first order with the time
        constant tilt / N, which is also the Wiener filter of these noises.

    Examples
    --------
    >>> round(kalman(8.7266e-5, 1e-4).time_constant, 3)
    1.146
    """
    _demand_noise(N, tilt, K)
    return Loop(math.sqrt(N**2 + 2 * K * tilt) / tilt, K / tilt)


@public
def kalman_error(N: float, tilt: float, K: float = 0.0) -> float:
    """Standard deviation of the angle of the steady `kalman` filter, rad: sqrt(tilt sqrt(N^2 + 2 K tilt))."""
    _demand_noise(N, tilt, K)
    return math.sqrt(tilt * math.sqrt(N**2 + 2 * K * tilt))


def _demand_noise(N: float, tilt: float, K: float) -> None:
    if not tilt > 0:
        raise UsageError(f"the white noise of the tilt must be above 0, not {given(tilt)}")
    if not (N >= 0 and K >= 0):
        raise UsageError(f"N and K of the gyro must not be negative, unlike {given(N)}, {given(K)}")
