"""Each noise term as states: exact transition over a sample interval, and what the mean over the interval gets.

A block has states z with dz = F z dt + w, the covariance of w being Qc per second. Over an interval h it is

    z(h) = Phi z(0) + noise,      mean of the first state over the interval = mean z(0) + noise,

with the joint covariance of both noises in closed form.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Block:
    """States of one term.

    Attributes
    ----------
    names : tuple of (str, float)
        Of each state: what it is, and the power of time that its unit carries beyond the signal.
    F, Qc : arrays, shape (s, s)
        Continuous time.
    Phi : array, shape (s, s)
    mean : array, shape (s,)
        What a state at the start adds to the mean over the interval.
    Q : array, shape (s + 1, s + 1)
        Covariance of the noises of the states and, last, of the mean.
    P0 : array, shape (s, s)
        Covariance at the start.
    output : array, shape (s,)
        What a state adds to the rate at an instant.
    """

    names: tuple[tuple[str, float], ...]
    F: FloatArray
    Qc: FloatArray
    Phi: FloatArray
    mean: FloatArray
    Q: FloatArray
    P0: FloatArray
    output: FloatArray


def markov(size: float, T: float, h: float) -> Block:
    """Gauss-Markov noise of effective value `size` and time constant `T`."""
    u = h / T
    loss = -math.expm1(-u)
    var_mean = size**2 * _mean_variance(u)
    Q = np.array([[-math.expm1(-2 * u) * size**2, size**2 * loss**2 / u], [size**2 * loss**2 / u, var_mean]])
    return Block(
        names=((f"Gauss-Markov rate, T = {T:.6g} s", 0),),
        F=np.array([[-1 / T]]),
        Qc=np.array([[2 * size**2 / T]]),
        Phi=np.array([[math.exp(-u)]]),
        mean=np.array([loss / u]),
        Q=Q,
        P0=np.array([[size**2]]),
        output=np.ones(1),
    )


def _mean_variance(u: float) -> float:
    """(2u - 3 + 4 exp(-u) - exp(-2u)) / u^2, without cancellation: what the noise within the interval adds."""
    if u > 0.3:
        return (2 * u - 3 + 4 * math.exp(-u) - math.exp(-2 * u)) / u**2
    return math.fsum((-1) ** k * (4 - 2.0**k) / math.factorial(k) * u ** (k - 2) for k in range(3, 20))


def walk(K: float, slope: float | None, turn_on: float, h: float) -> Block:
    """A bias with rate random walk `K`; with a `slope` of that standard deviation, if there is one."""
    with_slope = slope is not None
    names: tuple[tuple[str, float], ...] = (("bias, random walk" if K else "bias", 0),)
    if with_slope:
        names += (("rate ramp", -1),)
    s = len(names)
    F, Phi, mean, P0 = np.zeros((s, s)), np.eye(s), np.ones(s), np.zeros((s, s))
    P0[0, 0] = turn_on**2
    if with_slope:
        F[0, 1], Phi[0, 1], mean[1], P0[1, 1] = 1.0, h, h / 2, (slope or 0.0) ** 2
    Qc, Q = np.zeros((s, s)), np.zeros((s + 1, s + 1))
    Qc[0, 0] = K**2
    Q[0, 0], Q[0, -1], Q[-1, 0], Q[-1, -1] = K**2 * h, K**2 * h / 2, K**2 * h / 2, K**2 * h / 3
    return Block(names, F, Qc, Phi, mean, Q, P0, np.eye(s)[0])


def oscillator(amplitude: float, frequency: float, h: float) -> Block:
    """A sinusoid of unknown phase."""
    w = 2 * math.pi * frequency
    sine, cosine = math.sin(w * h), math.cos(w * h)
    return Block(
        names=((f"sinusoid of {frequency:.6g} Hz", 0), (f"sinusoid of {frequency:.6g} Hz, quadrature", 0)),
        F=np.array([[0.0, w], [-w, 0.0]]),
        Qc=np.zeros((2, 2)),
        Phi=np.array([[cosine, sine], [-sine, cosine]]),
        mean=np.array([sine, 2 * math.sin(w * h / 2) ** 2]) / (w * h),
        Q=np.zeros((3, 3)),
        P0=np.eye(2) * amplitude**2 / 2,
        output=np.array([1.0, 0.0]),
    )


def angle_noise(Q: float, h: float) -> Block:
    """White noise of the angle: the mean rate over an interval gets the difference of its ends' errors, over h.

    A state of discrete time: the error of the angle at the end of the interval, new in every interval.
    """
    return Block(
        names=(("error of the angle", 1),),
        F=np.zeros((1, 1)),
        Qc=np.zeros((1, 1)),
        Phi=np.zeros((1, 1)),
        mean=np.array([-1 / h]),
        Q=Q**2 * np.array([[1.0, 1 / h], [1 / h, 1 / h**2]]),
        P0=np.array([[Q**2]]),
        output=np.zeros(1),
    )
