"""A noise term as states of a filter: exact transition over a sample interval, and what the mean over it gets.

A block has states z with dz = F z dt + w, the covariance of w being Qc per second. Over an interval h it is

    z(h) = Phi z(0) + noise,      mean of the first state over the interval = mean z(0) + noise,

with the joint covariance of both noises in closed form.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
        What a state adds to the rate at an instant; 0 for a state of discrete time.
    white : float
        Variance of the white noise that each reading gets besides.
    bias : bool
        Whether the states are the bias and its derivatives, which such blocks of a model have in common.
    note : str
        What a user of the filter should know.
    """

    names: tuple[tuple[str, float], ...]
    F: FloatArray
    Qc: FloatArray
    Phi: FloatArray
    mean: FloatArray
    Q: FloatArray
    P0: FloatArray
    output: FloatArray
    white: float = 0.0
    bias: bool = False
    note: str = ""


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


def white_noise(N: float, h: float) -> Block:
    """White noise of the rate: no state, only noise of the reading."""
    nothing, one = np.zeros((0, 0)), np.zeros(0)
    return Block((), nothing, nothing, nothing, one, np.zeros((1, 1)), nothing, one, white=N**2 / h)


def integrators(names: tuple[str, ...], h: float, *, density: float = 0.0, start: float = 0.0, note: str = "") -> Block:
    """The bias and its derivatives, the last of them driven by white noise of `density`.

    `names` are those of the states; `start` is the standard deviation of the last one at the start.
    """
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
    return Block(
        names=tuple((name, -float(k)) for k, name in enumerate(names)),
        F=np.eye(s, k=1),
        Qc=Qc,
        Phi=Phi,
        mean=h ** np.arange(s) / factorial[1 : s + 1],
        Q=Q,
        P0=P0,
        output=np.eye(s)[0],
        bias=True,
        note=note,
    )


def joined(blocks: Sequence[Block]) -> Block:
    """One block of the bias and its derivatives in place of several; those that add nothing leave no name."""
    longest = max(blocks, key=lambda block: len(block.names))
    s = len(longest.names)
    names, Qc, P0, Q = list(longest.names), np.zeros((s, s)), np.zeros((s, s)), np.zeros((s + 1, s + 1))
    for block in blocks:
        k = len(block.names)
        at = np.append(np.arange(k), s)
        Qc[:k, :k] += block.Qc
        P0[:k, :k] += block.P0
        Q[np.ix_(at, at)] += block.Q
        if block.Qc.any():
            names[k - 1] = block.names[-1]
    return replace(longest, names=tuple(names), Qc=Qc, P0=P0, Q=Q)


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
        note="a sinusoid is an oscillator without noise: its frequency must be known and steady",
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
        note="quantization is taken for white Gaussian noise of the angle; that it is bounded by half a step, and "
        "depends on the angle itself, is left out",
    )
