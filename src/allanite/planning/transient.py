"""How accurate a warm-up can be: the information about its size and its time constant."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.model import Model, Term
from allanite.identification.checks.whitening import deviations
from allanite.prepare.gaps import whole

STEP = 1.001
"""Factor on the time constant by which the waveform is differentiated."""


def transient_errors(t: Term, noise: Sequence[Term], n: int, rate: float) -> tuple[float, ...]:
    """Relative standard errors of size and time constant beside known noise and an unknown bias."""
    from scipy.fft import dct

    at, deviation = deviations(Model(tuple(noise)), whole(n), rate)
    scale = np.interp(np.arange(1.0, n), at, deviation)

    def seen(factor: float) -> FloatArray:
        wave = replace(t, shape=(t.shape[0] * factor,)).sampled(rate).waveform
        assert wave is not None  # noqa: S101 - a warm-up has one
        return np.asarray(t.value * dct(wave(n), norm="ortho")[1:] / scale)

    slopes = np.stack((seen(1.0), (seen(STEP) - seen(1 / STEP)) / (2 * math.log(STEP))))
    information = slopes @ slopes.T
    if not np.linalg.det(information) > 0:
        return math.inf, math.inf
    size, time = np.sqrt(np.diag(np.linalg.inv(information))).tolist()
    return size, time
