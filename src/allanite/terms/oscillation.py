"""Second-order Markov noise: a damped oscillation of the rate that noise keeps going, as in a control loop."""

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from allanite.phrases.phrase import say

from .markov import Exponential
from .row import Block, FloatArray, NoiseTerm, Parameter

CRITICAL = 1e-7
"""Distance from critical damping, where both time constants are equal, at which the functions are evaluated."""

PERIODS, HIGHEST = 10.0, 0.4  # natural frequencies that are looked for: periods in the record, and periods a sample

DAMPINGS = (0.01, 0.9)
"""Damping ratios that are looked for: a weaker one is that of a sinusoid, a stronger one of Gauss-Markov noise."""


def modes(frequency: float, damping: float) -> list[tuple[complex, Exponential]]:
    """Weights and exponentials whose sum is the covariance, of which the real part counts."""
    # s1, s2 = w (z +- sqrt(z^2 - 1)), and the covariance is (s2 exp(-s1 t) - s1 exp(-s2 t)) / (s2 - s1).
    w = 2 * math.pi * frequency
    z = damping if abs(damping - 1) > CRITICAL else 1 - CRITICAL
    root = cmath.sqrt(z * z - 1)
    if z < 1:  # a conjugate pair: twice the real part of one
        return [(1 + z / root, Exponential(w * (z - root)))]
    fast, slow = w * (z + root.real), w / (z + root.real)
    return [(fast / (fast - slow), Exponential(slow)), (-slow / (fast - slow), Exponential(fast))]


def oscillation(frequency: float, damping: float) -> NoiseTerm:
    """The row of second-order Markov noise: natural frequency in periods a sample interval, and damping ratio."""
    parts = modes(frequency, damping)

    def each(name: str) -> Callable[..., FloatArray]:
        return lambda *at: np.asarray(sum((weight * getattr(part, name)(*at)).real for weight, part in parts))

    def positive(name: str) -> Callable[..., FloatArray]:
        def column(*at: Any) -> FloatArray:  # far above the oscillation only rounding is left
            return np.maximum(each(name)(*at), 0.0)

        return column

    made: dict[str, Any] = {name: each(name) for name in LINEAR} | {name: positive(name) for name in POWERS}
    return NoiseTerm(
        symbol="GM2", title=say("second-order Markov noise"),
        meaning=say(
            "a damped oscillation of the rate that white noise keeps going (second-order Gauss-Markov), with a natural "
            "frequency and a damping ratio"
        ),
        formula=r"R(t) = s^2 \exp(-\zeta \omega t) (\cos \omega_d t + (\zeta \omega / \omega_d) \sin \omega_d t)",
        reference=say("the covariance R of the rate, with its second integral in the variance; s is the RMS rate"),
        power=0.0, slope=math.nan, read_at=math.nan, level=math.nan, **made,
        parameters=(
            Parameter("frequency", say("natural frequency"), "Hz", least=0.0, letter="f", typical=0.02, time=-1.0,
                      search=lambda n: (PERIODS / n, HIGHEST), steps=16),
            Parameter("damping", say("damping ratio"), "", least=0.0, letter="zeta", typical=0.15,
                      search=lambda n: DAMPINGS, steps=2),
        ),
        period=1 / frequency if damping < 1 else 0.0, shape=(frequency, damping),
        shaped=lambda shape, rate: oscillation(shape[0] / rate, shape[1]),
        density=r"S(f) = \frac{4 \zeta \omega^3 s^2}{(\omega^2 - (2 \pi f)^2)^2 + (2 \zeta \omega \, 2 \pi f)^2}",
        origin="A loop or a structure with a resonance that noise excites: the control loop of a stabilized platform "
        "or of a rebalanced sensor, a suspension, sway of a building by the wind. Unlike a sinusoid its phase and "
        "amplitude wander; unlike Gauss-Markov noise it returns through zero.",
        advice="A hump near tau = 0.37/f that is followed by one or several weaker ones, where the damping ratio is "
        "below about 0.3; with critical damping (1) it resembles Gauss-Markov noise with T = 1/(pi f). The width of "
        "its peak in the spectrum is 2 zeta f. The automatic search leaves out a resonance; this term is looked for "
        "when its symbol is among the terms that are asked for. In a Kalman filter it has two states.",
        color="#9438EC", dark="#D3B157", dash=(2.4, 1.2, 1, 1.2), block=oscillation_block,
    )  # fmt: skip


LINEAR, POWERS = ("structure", "derivative", "summed", "increments"), ("spectrum", "dct")
"""Columns of the row that are linear in the covariance."""


def oscillation_block(size: float, shape: tuple[float, ...], h: float) -> Block:
    """The rate and its derivative over the natural (angular) frequency, both of RMS `size`."""
    from scipy.linalg import expm

    w, z = 2 * math.pi * shape[0], shape[1]
    F = np.array([[0.0, w], [-w, -2 * z * w]])
    Qc = np.diag([0.0, 4 * z * w * size**2])
    whole = np.zeros((6, 6))  # Van Loan (1978), with the integral of the rate as a third state
    whole[:2, :2], whole[2, 0] = -F, -1.0
    whole[:2, 3:5], whole[3:5, 3:5], whole[3, 5] = Qc, F.T, 1.0
    halvings = max(0, math.ceil(math.log2(2 * (1 + z) * w * h)))  # over a long interval exp(-F h) would overflow
    exponential = expm(whole * h / 2**halvings)
    Phi = exponential[3:, 3:].T
    Q = Phi @ exponential[:3, 3:]
    for _ in range(halvings):
        Phi, Q = Phi @ Phi, Phi @ Q @ Phi.T + Q
    mean = np.diag([1.0, 1.0, 1 / h])
    return Block(names=((say("oscillation of {frequency:.6g} Hz", frequency=shape[0]), 0),
                        (say("oscillation of {frequency:.6g} Hz, derivative", frequency=shape[0]), 0)), F=F,
                 Qc=Qc, Phi=Phi[:2, :2], mean=Phi[2, :2] / h, Q=mean @ ((Q + Q.T) / 2) @ mean, P0=np.eye(2) * size**2,
                 output=np.array([1.0, 0.0]))  # fmt: skip


OSCILLATION = oscillation(0.05, 0.15)
