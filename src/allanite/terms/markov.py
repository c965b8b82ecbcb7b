"""Gauss-Markov noise: an exponentially correlated rate, averaged over each sample interval."""

import math
from dataclasses import replace

import numpy as np

from allanite.phrases.phrase import say

from .exponential import Exponential
from .row import Block, NoiseTerm, time_constant

SHORTEST = 3.0
"""Samples from which a time constant can be distinguished from white noise."""


def gauss_markov(T: float) -> NoiseTerm:
    """The row of Gauss-Markov rate noise, with a time constant of T sample intervals."""
    functions = Exponential(1 / T)
    return NoiseTerm(
        symbol="GM",
        synonyms=("markov",),
        title=say("Gauss-Markov noise"),
        meaning=say("exponentially correlated (first-order Gauss-Markov) noise of the rate, with a time constant T"),
        quantity_meaning=say("exponentially correlated (first-order Gauss-Markov) noise with a time constant T"),
        formula=r"\sigma^2(\tau) = (2 s^2 T / \tau) (1 - (T / 2 \tau) (3 - 4 \exp(-\tau/T) + \exp(-2 \tau/T)))",
        reference=say("IEEE Std 952; s is the RMS rate, q = s sqrt(2/T) the driving noise"),
        power=0.0,
        slope=math.nan,
        read_at=math.nan,
        level=math.nan,
        structure=functions.structure,
        derivative=functions.derivative,
        summed=functions.summed,
        increments=functions.increments,
        spectrum=functions.spectrum,
        dct=functions.dct,
        parameters=(time_constant(20.0, SHORTEST),),
        shape=(T,),
        shaped=lambda shape, rate: gauss_markov(shape[0] * rate),
        density=r"S(f) = \frac{2 s^2 T}{1 + (2 \pi f T)^2}",
        origin="A single relaxation process: a temperature that follows its surroundings, a trapped charge, a filter "
        "at the output, a control loop. Sums of a few such processes with time constants a decade apart can "
        "hardly be distinguished from flicker.",
        advice="A hump: the Allan deviation increases with slope +1/2 up to tau = 1.89 T, where it is 0.617 s, and "
        "decreases with slope -1/2 beyond. Well below T it resembles a rate random walk with K = s sqrt(2/T), "
        "well above an angle random walk with N = s sqrt(2 T). In a Kalman filter it is a state with Phi = "
        "exp(-tau0/T) and the driving noise s^2 (1 - Phi^2). A flat top of the hump is not flicker: the "
        "likelihood distinguishes the two if the record permits.",
        color="#72780E",
        dark="#BBFD7A",
        dash=(8, 1.8, 1.4, 1.8, 1.4, 1.8),
        block=lambda size, shape, h: markov_block(size, shape[0], h),
        second="GML",
    )


def slow_gauss_markov(T: float) -> NoiseTerm:
    """The row of a second Gauss-Markov rate noise, of a longer time constant than the first."""
    return replace(
        gauss_markov(T),
        symbol="GML",
        synonyms=("GM GM",),
        title=say("slow Gauss-Markov noise"),
        meaning=say("Gauss-Markov noise of the rate beside another, GM, whose time constant is shorter"),
        quantity_meaning=say("Gauss-Markov noise beside another, GM, whose time constant is shorter"),
        parameters=(time_constant(600.0, SHORTEST),),
        shaped=lambda shape, rate: slow_gauss_markov(shape[0] * rate),
        origin="A second relaxation process beside that of GM: the temperature of a housing beside that of a sensor, a "
        "second control loop.",
        advice="A second hump, at a longer averaging time than that of GM. It is looked for when both are among the "
        "terms that are asked for: N,GM,GM is N,GM,GML. One process alone is called GM.",
        color="#872D96",
        dark="#C36900",
        dash=(8, 1.8, 1.4, 1.8),
        second="",
    )


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
    return Block(
        names=((say("Gauss-Markov rate, T = {time:.6g} s", time=T), 0),),
        F=np.array([[-1 / T]]),
        Qc=np.array([[2 * size**2 / T]]),
        Phi=np.array([[math.exp(-u)]]),
        mean=np.array([loss / u]),
        Q=Q,
        P0=np.array([[size**2]]),
        output=np.ones(1),
    )


GAUSS_MARKOV, SLOW_GAUSS_MARKOV = gauss_markov(1.0), slow_gauss_markov(1.0)
