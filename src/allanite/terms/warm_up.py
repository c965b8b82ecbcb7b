"""An exponential warm-up of the rate: deterministic, it begins with the record."""

import math
from typing import Any

import numpy as np

from allanite.phrases.phrase import say

from .row import FloatArray, NoiseTerm, time_constant


def _none(*_: Any) -> FloatArray:
    raise ValueError(
        "a warm-up (W) has no structure function, as it depends on the time since the record began: pass the length of "
        "the record, or omit W from the model"
    )


def warm_up(T: float) -> NoiseTerm:
    """The row of a warm-up 1 - exp(-t / T), with a time constant of T sample intervals."""
    u = 1 / T

    def waveform(n: int) -> FloatArray:
        return np.asarray(1 + math.expm1(-u) * T * np.exp(-u * np.arange(n)))

    return NoiseTerm(
        symbol="W",
        title=say("warm-up"),
        meaning=say(
            "an exponential change of the rate from the start of the record on, with a sign and a time constant"
        ),
        formula=r"\Omega(t) = W (1 - \exp(-t / T))",
        reference=say("the mean over each sample interval"),
        power=0.0,
        slope=math.nan,
        read_at=math.nan,
        level=math.nan,
        structure=_none,
        derivative=_none,
        summed=_none,
        increments=_none,
        spectrum=lambda f, tau0: np.zeros_like(f),
        dct=lambda k, _: np.zeros_like(k),
        waveform=waveform,
        transient=True,
        parameters=(time_constant(200.0),),
        shape=(T,),
        shaped=lambda shape, rate: warm_up(shape[0] * rate),
        origin="The sensor comes to its temperature after it is switched on. It is not a noise: it begins with the "
        "power, and what a statistic shows of it depends on when the record begins and how long it is.",
        advice="It resembles a random walk or a ramp. A warm-up longer than a third of the record is a ramp. Cut it "
        "off rather than model it, and record after it: what is left of it then is below its standard error. It is "
        "looked for in every record, named in a finding, and accounted for in the residuals and in the curve that is "
        "drawn. Asked for by its symbol, it has an interval and is part of the model.",
        typical=20.0,
        color="#13042C",
        dark="#8BF08F",
        dash=(1.2, 1.2, 6, 1.2),
    )


WARM_UP = warm_up(1.0)
