"""The table of noise terms: pure mathematics, one row a term.

A term enters every statistic through one function, its structure function ``D(t) = E[(x(s+t) - x(s))^2]`` of the angle
x (in the generalized sense: polynomials that every statistic here removes are omitted). All functions are for a
coefficient of 1 and, except `structure` and `spectrum`, for a sample interval of 1; they are linear in the square of
the coefficient.
"""

from allanite.plugins import Registry

from .flicker import ANGLE_FLICKER, FLICKER
from .markov import ANGLE_MARKOV, GAUSS_MARKOV, SLOW_GAUSS_MARKOV
from .oscillation import OSCILLATION
from .powers import ANGLE_RANDOM_WALK, QUANTIZATION, RAMP, RATE_RANDOM_WALK, ramp_coefficients
from .row import WHITE, NoiseTerm, Parameter
from .waveforms import SINE, WARM_UP

__all__ = ["TERMS", "WHITE", "NoiseTerm", "Parameter", "ramp_coefficients"]

_OWN = (*(QUANTIZATION, ANGLE_FLICKER, ANGLE_RANDOM_WALK, FLICKER, RATE_RANDOM_WALK, RAMP, WARM_UP),
        *(GAUSS_MARKOV, SLOW_GAUSS_MARKOV, ANGLE_MARKOV, OSCILLATION, SINE))  # fmt: skip

TERMS = Registry({row.symbol: row for row in _OWN}, "allanite.terms", kind=NoiseTerm, key="symbol")
