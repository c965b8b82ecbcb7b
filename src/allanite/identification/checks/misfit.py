"""Likely causes if residuals fail a check, and remedies."""

import math
from collections.abc import Iterator

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding
from allanite.core.fit import Fit
from allanite.core.record import Record
from allanite.core.residuals import Check, try_band
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import longest_without, spelled
from allanite.prepare.outliers import outliers as outlying
from allanite.prepare.rounding import rounding_of
from allanite.prepare.view import stretches

UNSTEADY, TAILED, KIN = 1.2, 0.1, 0.02
"""Ratio of levels, excess kurtosis and correlation above which a failed check matters."""

DIFFERENT = 1.5
"""Ratio of noise levels above which one set of coefficients describes no part of the record."""


def reasons(
    record: Record, fit: Fit, checks: tuple[Check, ...], level: tuple[FloatArray, FloatArray], *, kept: bool
) -> list[Finding]:
    """Likely causes other than those of the spectrum, which `Goodness.reasons` explain."""
    spectral = fit.goodness is not None and not fit.goodness.explained
    if not spectral and all(check.passed for check in checks):
        return []
    steps = rounding_of(record)
    if steps.sparse:  # the samples are steps of a quantizer without sufficient dither
        how = say(
            "steps of {size:.4g} {unit} (LSB), and the fast noise is {noise:.2g} step",
            size=steps.step * (record.scale or 1.0), unit=record.unit, noise=steps.noise,
        )  # fmt: skip
        what = say(
            "quantization errors are not white: {details}", details=join(", ", filter(None, (steps.counted, how)))
        )
        harm = say("the rounding error follows the signal, and N and Q are not meaningful")
        remedy = say("use a finer output of the sensor, or add dither before rounding")
        if record.kind == "count" and record.rate >= 10:  # of a gyro that counts pulses they are expected
            remedy = say("analyze the counts of each second ({choice})", choice=spelled("--average 1", "average=1"))
        return [Finding("no dither", what, harm, remedy, fatal=True)]
    near, tails, halves, eighths = checks
    ratio = max(halves.value, 1 / halves.value, eighths.value)
    unsteady = [_unsteady(eighths, *level)] if not (halves.passed and eighths.passed) and ratio > UNSTEADY else []
    # a wrong spectrum makes neighbours correlate, a line has tails of its own, and rounding makes light tails
    return unsteady if spectral else [*unsteady, *_fast(near, tails, record, fit, kept=kept)]


def _unsteady(check: Check, power: FloatArray, time: FloatArray) -> Finding:
    level = np.sqrt(power / np.median(power))
    odd = int(np.abs(np.log(level)).argmax())
    runs = stretches(level > math.sqrt(level.max() * level.min()))
    different = check.value > DIFFERENT
    loud = [(float(time[a]), float(time[b])) for a, b in runs]
    spans = (say("from {start:.6g} s to {end:.6g} s", start=start, end=end) for start, end in loud)
    return Finding(
        "level",
        say(
            "the noise level changes by a factor of {ratio:.3g} between eighths of the record, and is highest {spans}",
            ratio=check.value,
            spans=join(", ", spans),
        ),
        say("one set of coefficients describes neither part")
        if different
        else say("the coefficients are those of the average"),
        say("analyze the parts separately ({choice})", choice=longest_without(loud, (float(time[0]), float(time[-1])))),
        (float(time[odd]), float(time[odd + 1])),
        fatal=different,
    )


def _fast(near: Check, tails: Check, record: Record, fit: Fit, *, kept: bool) -> Iterator[Finding]:
    """The findings about the fast noise: heavy tails, and neighbours that correlate."""
    if not tails.passed and tails.value > TAILED:
        what = say(
            "the residuals have heavy tails (excess kurtosis {kurtosis:.3g}): outliers, bursts, or intermittent noise",
            kurtosis=tails.value,
        )
        effect = say("the coefficients are valid; the intervals of the fast noise are widened for them")
        cure = say("exclude the outliers ({option})", option=spelled("--outliers mark", "prepare.mark_outliers"))
        yield Finding("heavy tails", what, effect, cure if kept and outlying(record).at.size > 0 else "")
    scope = fit.scope
    if (scope is None or scope.whole) and not near.passed and abs(near.value) > KIN:
        yield Finding(
            "correlation",
            say("the residuals are not white: their autocorrelation is {correlation:.2g}", correlation=near.value),
            say("the model misses fast noise, and its intervals are too narrow"),
            "" if scope is not None and scope.choice == "auto" else try_band(),
            fatal=abs(near.value) > 5 * KIN,
        )
