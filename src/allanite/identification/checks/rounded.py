"""Whether the rounding errors of an angle are the white noise that quantization noise is."""

import math

import numpy as np

from allanite.core.estimate import Estimate
from allanite.core.record import Record
from allanite.prepare.rounding import grid

KIN = 0.05
"""Correlation of neighbouring rounding errors from which on Q and N are off."""


def correlated(record: Record, white: Estimate) -> str:
    """Why the noise of the angle and white noise of the rate are not meaningful; empty where they are, or no step is.

    An angle that moves by a normal step of sigma, in units of the step it is rounded to, has rounding errors that
    correlate by exp(-2 pi^2 sigma^2) from one reading to the next: the characteristic function of the step at 2 pi.
    """
    steps = record.steps[np.isfinite(record.steps)]
    step, size = grid(steps)[1] * record.rate_factor / record.rate, white.median
    if not step or not size:
        return ""
    sigma = size / math.sqrt(record.rate) / step
    r = math.exp(-2 * (math.pi * sigma) ** 2)
    if r < KIN:
        return ""
    return (
        f"white noise moves the angle by {sigma:.2g} of the step it is rounded to between readings: the rounding "
        f"errors correlate by {r:.2g} and are no white noise"
    )
