"""A noise term: Gauss-Markov noise whose coefficient is the size of what drives it."""

from dataclasses import replace

from allanite.phrases.phrase import say
from allanite.terms.markov import SHORTEST, gauss_markov, markov_block
from allanite.terms.row import NoiseTerm, time_constant


def relaxation(T: float) -> NoiseTerm:
    """Gauss-Markov noise whose RMS is the coefficient times T^1.5."""
    base, size = gauss_markov(T), T**3
    return replace(
        base,
        symbol="RR",
        title=say("driven relaxation"),
        meaning=say("a rate that relaxes, by what drives it"),
        power=-1.5,
        structure=lambda t: size * base.structure(t),
        summed=lambda t: size * base.summed(t),
        derivative=lambda order, t: size * base.derivative(order, t),
        increments=lambda h: size * base.increments(h),
        spectrum=lambda f, tau0: size * tau0**3 * base.spectrum(f, tau0),
        dct=lambda k, n: size * base.dct(k, n),
        parameters=(replace(time_constant(20.0, SHORTEST), default=20.0),),
        quantity_meaning="",
        color="#123456",
        shaped=lambda shape, rate: relaxation(shape[0] * rate),
        block=lambda q, shape, h: markov_block(q * shape[0] ** 1.5, shape[0], h),
    )


RELAXED = relaxation(1.0)
