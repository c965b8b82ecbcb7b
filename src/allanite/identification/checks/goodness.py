"""Goodness of fit to the spectrum, and likely reasons for a misfit."""

import math
from collections.abc import Iterator

import numpy as np
import scipy

from allanite.core.arrays import BoolArray, FloatArray, IntArray, stretches
from allanite.core.fit import MIN_P, Fit, Goodness, Line
from allanite.core.record import Record
from allanite.core.residuals import Check, try_band
from allanite.core.validity import Finding
from allanite.identification.likelihood.spectrum import CELLS, BinnedSpectrum, surroundings
from allanite.phrases.phrase import join, longest_without, say, spelled
from allanite.prepare.outliers import outliers as outlying
from allanite.prepare.rounding import rounding_of

UNSTEADY, HEAVY_TAILS, KIN = 1.2, 0.1, 0.02
"""Ratio of levels, excess kurtosis and correlation above which a failed check matters."""

DIFFERENT = 1.5  # ratio of noise levels above which one set of coefficients describes no part of the record


def reasons(
    record: Record, fit: Fit, checks: tuple[Check, ...], level: tuple[FloatArray, FloatArray], *, kept: bool
) -> list[Finding]:
    """Likely causes other than those of the spectrum, which `Goodness.reasons` explain."""
    spectral = fit.goodness is not None and not fit.goodness.explained
    if not spectral and all(check.passed for check in checks):
        return []
    steps = rounding_of(record)
    if steps.sparse:  # the samples are steps of a quantizer without sufficient dither
        how = say("steps of {size:.4g} {unit} (LSB), and the fast noise is {noise:.2g} step",
                  size=steps.step * (record.scale or 1.0), unit=record.unit, noise=steps.noise)  # fmt: skip
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
        say("the noise level changes by a factor of {ratio:.3g} between eighths of the record, and is highest "
            "{spans}", ratio=check.value, spans=join(", ", spans)),
        say("one set of coefficients describes neither part")
        if different
        else say("the coefficients are those of the average"),
        say("analyze the parts separately ({choice})", choice=longest_without(loud, (float(time[0]), float(time[-1])))),
        (float(time[odd]), float(time[odd + 1])),
        fatal=different,
    )  # fmt: skip


def _fast(near: Check, tails: Check, record: Record, fit: Fit, *, kept: bool) -> Iterator[Finding]:
    """The findings about the fast noise: heavy tails, and neighbours that correlate."""
    if not tails.passed and tails.value > HEAVY_TAILS:
        what = say("the residuals have heavy tails (excess kurtosis {kurtosis:.3g}): outliers, bursts, or "
                   "intermittent noise", kurtosis=tails.value)  # fmt: skip
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


FALSE_PEAK = 0.01  # probability that a record of noise alone shows a line

LEAST_RATIO = 1e-12
"""Power over the model's that a sentence states at least: of a model far from the record it may come out negative."""


def cells_of(spectrum: BinnedSpectrum, used: BoolArray) -> tuple[IntArray, FloatArray]:
    """The cell of each bin that is used, and the bounds of the cells in coefficients."""
    first = spectrum.first[used]
    bounds = np.geomspace(first[0], spectrum.size if first[-1] == spectrum.first[-1] else first[-1] + 1, CELLS + 1)
    return np.clip(np.searchsorted(bounds, first, side="right") - 1, 0, CELLS - 1), bounds


def goodness(
    spectrum: BinnedSpectrum, used: BoolArray, *, power: FloatArray, m: FloatArray, count: FloatArray, lost: float,
    loud: BoolArray, taken: tuple[Line, ...] = (),
) -> Goodness:  # fmt: skip
    """Cell-wise goodness of fit."""
    # In each cell the sum of I/m is chi-square with as many degrees of freedom as it has coefficients; its normal
    # deviate is z, and the sum of z^2 over the cells is chi-square with the number of cells less what sizes and shapes
    # take of them, `lost`, and a half. `power`, `m` and `count` are observed and expected power and the count of the
    # bins `used`, given the loose directions. In bins that are `loud` with the peaks of vibration no narrow peaks are
    # looked for; `taken` are sinusoids removed before.
    cell, bounds = cells_of(spectrum, used)
    edges = spectrum.frequency(bounds)
    nu, total = (np.bincount(cell, w, edges.size - 1).astype(np.float64) for w in (count, count * power / m))
    filled = nu > 0
    z = _normal(total[filled], nu[filled])
    p = float(scipy.special.chdtrc(max(float(filled.sum()) - lost - 0.5, 1.0), (z**2).sum()))
    ratio = total[filled] / nu[filled]
    bounds = np.append(edges[:-1][filled], edges[-1])
    reasons = [*_lines(spectrum, used, np.where(loud, np.inf, m), power)]
    if p < MIN_P:
        moving = (z > 5) & (ratio > 2)  # excess first: a strong one lifts the model everywhere else
        named = _roll_off(spectrum, used) + _where(bounds, ratio, z * moving)
        reasons += named or _where(bounds, ratio, z)
    remarks: tuple[str, ...] = ()
    if taken:
        where = join(", ", (line.words() for line in taken))
        remark = say("a sinusoid was removed first, at {where}: vibration, sway or interference", where=where)
        if len(taken) > 1:
            remark = say("sinusoids were removed first, at {where}: vibration, sway or interference", where=where)
        remarks = (remark,)
    return Goodness(bounds, ratio, z, p, tuple(reasons), remarks)


def _normal(total: FloatArray, nu: FloatArray) -> FloatArray:
    """Chi-square values as standard normal deviates; by Wilson and Hilferty if the tail underflows."""
    low, high = scipy.special.gammainc(nu / 2, total / 2), scipy.special.gammaincc(nu / 2, total / 2)
    with np.errstate(divide="ignore"):
        z = np.where(low < high, scipy.special.ndtri(low), -scipy.special.ndtri(high))
    # under a model far from the record a total can come out negative: its cube root says so
    cube = (np.cbrt(total / nu) - (1 - 2 / (9 * nu))) / np.sqrt(2 / (9 * nu))
    return np.where(np.isfinite(z), z, cube)


def _lines(spectrum: BinnedSpectrum, used: BoolArray, m: FloatArray, rest: FloatArray) -> list[str]:
    """Coefficients that exceed their neighbourhood, in a sentence; `rest` is the power without loose directions."""
    power, count = spectrum.power[used], spectrum.count[used]
    peak = np.where(count == 1, rest, spectrum.peak[used])
    around = np.median(surroundings(power), axis=1)
    threshold = float(scipy.special.ndtri(0.5 * FALSE_PEAK / count.sum())) ** 2
    standing_out = peak > threshold * np.maximum(around, m)
    if not standing_out.any():
        return []
    strength = np.where(standing_out, peak / np.maximum(around, m), 0.0)
    best = np.sort(np.argsort(strength)[::-1][: min(5, int(standing_out.sum()))])
    where = ", ".join(f"{f:.3g}" for f in spectrum.frequency(spectrum.peak_at[used][best]))
    share = float(peak[standing_out].sum() / (power * count).sum())
    return [
        say("narrow peaks at {frequencies} Hz (their maxima alone contain {share:.2g} % of the power): vibration, "
            "sway or interference", frequencies=where, share=100 * share)
    ]  # fmt: skip


def _roll_off(spectrum: BinnedSpectrum, used: BoolArray) -> list[str]:
    """Power that decreases towards half the sampling rate, judged by measured levels, independent of the model."""
    frequency = spectrum.frequency(spectrum.first[used]) / (spectrum.rate / 2)
    power, count = spectrum.power[used], spectrum.count[used]
    levels = []
    for low, high in ((0.8, 1.0), (0.08, 0.2)):
        part = (frequency >= low) & (frequency < high)
        if count[part].sum() < 100:
            return []
        levels.append(float(np.median(power[part])))
    top, middle = levels
    if top > 0.8 * middle:
        return []
    return [
        say("the spectrum rolls off: towards {frequency:g} Hz it falls to {level:.2g} of its level at a tenth of "
            "that frequency (a filter in the sensor or logger)", frequency=spectrum.rate / 2, level=top / middle)
    ]  # fmt: skip


def _where(bounds: FloatArray, ratio: FloatArray, z: FloatArray) -> list[str]:
    """The cell with the largest misfit and its neighbours of the same sign; empty if all z are zero."""
    worst = int(np.abs(z).argmax())
    if z[worst] == 0:
        return []
    strong = (np.sign(z) == np.sign(z[worst])) & (np.abs(z) > max(3.0, 0.1 * abs(z[worst])))
    first = last = worst
    while first > 0 and strong[first - 1]:
        first -= 1
    while last < z.size - 1 and strong[last + 1]:
        last += 1
    mean = math.exp(float(np.log(np.maximum(ratio[first : last + 1], LEAST_RATIO)).mean()))
    what = (
        say("motion, sway, vibration or a missing term")
        if mean > 1
        else say("a filter, or a term that does not belong in the model")
    )
    return [
        say("from {low:.3g} to {high:.3g} Hz the power is {ratio:.3g} times that of the model: {cause}",
            low=bounds[first], high=bounds[last + 1], ratio=mean, cause=what)
    ]  # fmt: skip
