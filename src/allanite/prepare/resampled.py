"""Check of the sampling: readings repeated at a steady pace, or fast noise that swells and fades at one."""

import math

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding
from allanite.core.wording import percent

from .view import View

LONGEST = 1 << 18
"""Readings that are looked at, in the middle of the record."""

DEPTH = 0.08
"""Relative swelling of the fast noise's power from which a record is called resampled; interpolation makes 0.3."""

CONSEQUENCE = "neighbours are not independent, and what is read at the shortest averaging times is the resampling"
REMEDY = "analyse what the sensor put out, at its own rate"


def resampled(view: View) -> Finding | None:
    """A sensor read, or interpolated, at another rate than its own.

    Hold: every so many readings one repeats its neighbour. Linear interpolation: the power of the fast noise depends on
    where between two readings of the sensor the new one lies, so that it swells and fades at the difference of rates.
    """
    return _held(view) or _interpolated(view)


def _held(view: View) -> Finding | None:
    same = np.flatnonzero(view.steps[1:] == view.steps[:-1])
    if same.size < max(20, 0.001 * view.steps.size):
        return None
    between = np.diff(same)
    usual = float(between.mean())
    # by chance distances spread as widely as their mean; by the beat of two clocks they are a number or its neighbour
    if usual < 1.9 or float((np.abs(between - usual) > 1.0).mean()) > 0.05:
        return None
    rate = view.rate * (1 - same.size / view.steps.size)
    what = f"every {usual:.4g}th reading repeats the one before: a sensor of {rate:.5g} Hz read at {view.rate:.6g} Hz"
    return Finding("resampled", what, CONSEQUENCE, REMEDY)


def _interpolated(view: View) -> Finding | None:
    middle = max(0, (view.bends.size - LONGEST) // 2)
    bends = view.bends[middle : middle + LONGEST]
    if bends.size < 4096 or not view.fast:
        return None
    bends = np.clip(bends, -6 * math.sqrt(6) * view.fast, 6 * math.sqrt(6) * view.fast)
    power = np.square(bends)
    mean = float(power.mean())
    spectrum = _lines(power - mean)
    first = 32  # what is slower is a level that changes
    at = first + int(spectrum[first:].argmax())
    around = np.median(spectrum[max(first, at - 200) : at + 200])
    # the window spreads a line over bins; a sinusoid of amplitude A stands with A^2 size / 6 in the highest
    depth = math.sqrt(6 * float(spectrum[at]) / power.size) / mean
    if spectrum[at] < 30 * around or depth < max(DEPTH, 3 * _narrow(bends)):
        return None
    beat = at * view.rate / power.size
    what = (
        f"the fast noise swells and fades {beat:.5g} times a second, by {percent(depth)}: the readings were "
        f"interpolated, from {view.rate - beat:.6g} Hz or another rate that differs by a multiple of {beat:.5g} Hz"
    )
    return Finding("resampled", what, CONSEQUENCE, REMEDY)


def _lines(values: FloatArray) -> FloatArray:
    """Periodogram under a Hann window, white noise of variance 1 being 1."""
    from scipy.fft import rfft

    window = np.hanning(values.size)
    return np.asarray(np.abs(rfft(values * window)) ** 2 / float(np.square(window).sum()))


def _narrow(values: FloatArray) -> float:
    """Share of the power in narrow lines: two sinusoids beat, too, by as much as they hold of the power."""
    spectrum = _lines(values)
    size = max(spectrum.size // 64, 16)
    blocks = spectrum[: spectrum.size // size * size].reshape(-1, size)
    high = np.where(blocks > 20 * np.median(blocks, axis=1, keepdims=True), blocks, 0.0)
    return float(high.sum() / spectrum.sum())
