"""What is likely wrong with a record whose residuals fail a check, and what to do."""

import math

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding
from allanite.core.fit import Fit
from allanite.core.record import Record
from allanite.core.residuals import Check
from allanite.prepare.outliers import outliers as outlying
from allanite.prepare.rounding import fast_noise, rounding

UNSTEADY, TAILED, KIN = 1.05, 0.1, 0.02
"""Ratio of levels, excess kurtosis and correlation from which a check that fails matters."""

LOUD = 1.2
"""Ratio of levels from which it matters beside a spectrum that is not explained."""

DIFFERENT = 1.5
"""Ratio of levels of the noise from which one set of coefficients is none of either part's."""


def reasons(
    record: Record, fit: Fit, checks: tuple[Check, ...], level: tuple[FloatArray, FloatArray], *, kept: bool
) -> list[Finding]:
    """What is likely wrong beside the spectrum, which `Goodness.reasons` explain."""
    spectral = fit.goodness is not None and not fit.goodness.explained
    if not spectral and all(check.passed for check in checks):
        return []
    coarse = _undithered(record)
    if coarse is not None:
        return [coarse]
    near, tails, halves, eighths = checks
    found = []
    ratio = max(halves.value, 1 / halves.value, eighths.value)
    if not (halves.passed and eighths.passed) and ratio > (LOUD if spectral else UNSTEADY):
        found.append(_unsteady(eighths, *level))
    # where the spectrum is wrong neighbours correlate, and a line has tails of its own; rounding makes light ones
    if not spectral and not tails.passed and tails.value > TAILED:
        found.append(_tailed(tails, curable=kept and outlying(record).at.size > 0))
    whole = fit.scope is None or fit.scope.whole
    if whole and not spectral and not near.passed and abs(near.value) > KIN:
        found.append(_kin(near, fit))
    return found


def _undithered(record: Record) -> Finding | None:
    """The readings are steps of a quantizer that nothing dithers."""
    steps = record.steps[np.isfinite(record.steps)]
    middle = max(0, (steps.size - 200_000) // 2)
    part = np.asarray(steps[middle : middle + 200_000], dtype=np.float64)
    found = rounding(steps, fast_noise(np.diff(part, 2)))
    if not found.sparse:
        return None
    size = found.step * (record.scale or 1.0)
    return Finding(
        "no dither",
        f"quantization is not white here: {found.counted}steps of {size:.4g} {record.unit} (LSB), and the fast noise "
        f"is {found.noise:.2g} step",
        "the rounding error follows the signal, and N and Q are not meaningful",
        "use a finer output of the sensor, or add dither before rounding",
        fatal=True,
    )


def _unsteady(check: Check, power: FloatArray, time: FloatArray) -> Finding:
    level = np.sqrt(power / np.median(power))
    odd = int(np.abs(np.log(level)).argmax())
    loud = level > math.sqrt(level.max() * level.min())
    first, last = int(loud.argmax()), loud.size - int(loud[::-1].argmax())
    different = check.value > DIFFERENT
    return Finding(
        "level",
        f"the noise level changes {check.value:.3g} times between eighths of the record, and is highest from "
        f"{time[first]:.6g} s to {time[last]:.6g} s",
        "one set of coefficients describes neither part" if different else "the coefficients are those of the average",
        "analyse the parts separately (--from, --until)",
        (float(time[odd]), float(time[odd + 1])),
        fatal=different,
    )


def _tailed(check: Check, *, curable: bool) -> Finding:
    return Finding(
        "heavy tails",
        f"the residuals have heavy tails (excess kurtosis {check.value:.3g}): outliers, bursts, or noise that comes "
        "and goes",
        "the coefficients hold, but their intervals are too narrow",
        "leave out the outliers (--outliers mark)" if curable else "",
    )


def _kin(check: Check, fit: Fit) -> Finding:
    tried = fit.scope is not None and fit.scope.choice == "auto"
    return Finding(
        "correlation",
        f"the residuals are not white: neighbours correlate by {check.value:.2g}",
        "the model misses something fast, and its intervals are too narrow",
        "" if tried else "let the fit look for a filter and for the frequencies that the terms explain (--band auto)",
        fatal=abs(check.value) > 5 * KIN,
    )
