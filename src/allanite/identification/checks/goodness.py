"""Goodness of fit to the spectrum, and likely reasons for a misfit."""

import math

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.fit import EXPLAINED, Goodness, Line
from allanite.identification.likelihood.cells import CELLS, surroundings
from allanite.identification.likelihood.spectrum import BinnedSpectrum
from allanite.phrases.phrase import join, say

FALSE_LINE = 0.01
"""Probability that a record of noise alone shows a line."""

LEAST = 1e-12
"""Power over the model's that a sentence states at least: of a model far from the record it may come out negative."""


def cells_of(spectrum: BinnedSpectrum, used: BoolArray) -> tuple[IntArray, FloatArray]:
    """The cell of each bin that is used, and the bounds of the cells in coefficients."""
    first = spectrum.first[used]
    bounds = np.geomspace(first[0], spectrum.size if first[-1] == spectrum.first[-1] else first[-1] + 1, CELLS + 1)
    return np.clip(np.searchsorted(bounds, first, side="right") - 1, 0, CELLS - 1), bounds


def goodness(
    spectrum: BinnedSpectrum,
    powers: tuple[FloatArray, FloatArray, FloatArray],
    used: BoolArray,
    *,
    lost: float,
    loud: BoolArray,
    taken: tuple[Line, ...] = (),
) -> Goodness:
    """Cell-wise goodness of fit.

    In each cell the sum of I/m is chi-square with as many degrees of freedom as it has coefficients; its normal deviate
    is z, and the sum of z^2 over the cells is chi-square with the number of cells less what sizes and shapes take of
    them, `lost`, and a half. `powers` are observed and expected power and the count of the bins `used`, given the loose
    directions. In bins that are `loud` with the peaks of vibration no narrow peaks are looked for; `taken` are
    sinusoids removed before.
    """
    from scipy.special import chdtrc

    power, m, count = powers
    cell, bounds = cells_of(spectrum, used)
    edges = spectrum.frequency(bounds)
    nu, total = (np.bincount(cell, w, edges.size - 1).astype(np.float64) for w in (count, count * power / m))
    filled = nu > 0
    z = _normal(total[filled], nu[filled])
    p = float(chdtrc(max(float(filled.sum()) - lost - 0.5, 1.0), (z**2).sum()))
    ratio = total[filled] / nu[filled]
    bounds = np.append(edges[:-1][filled], edges[-1])
    reasons = [*_lines(spectrum, used, np.where(loud, np.inf, m), power)]
    if p < EXPLAINED:
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
    from scipy.special import gammainc, gammaincc, ndtri

    low, high = gammainc(nu / 2, total / 2), gammaincc(nu / 2, total / 2)
    with np.errstate(divide="ignore"):
        z = np.where(low < high, ndtri(low), -ndtri(high))
    # under a model far from the record a total can come out negative: its cube root says so
    cube = (np.cbrt(total / nu) - (1 - 2 / (9 * nu))) / np.sqrt(2 / (9 * nu))
    return np.where(np.isfinite(z), z, cube)


def _lines(spectrum: BinnedSpectrum, used: BoolArray, m: FloatArray, rest: FloatArray) -> list[str]:
    """Coefficients that exceed their neighbourhood, in a sentence; `rest` is the power without loose directions."""
    from scipy.special import ndtri

    power, count = spectrum.power[used], spectrum.count[used]
    peak = np.where(count == 1, rest, spectrum.peak[used])
    around = np.median(surroundings(power), axis=1)
    threshold = float(ndtri(0.5 * FALSE_LINE / count.sum())) ** 2
    found = peak > threshold * np.maximum(around, m)
    if not found.any():
        return []
    strength = np.where(found, peak / np.maximum(around, m), 0.0)
    best = np.sort(np.argsort(strength)[::-1][: min(5, int(found.sum()))])
    where = ", ".join(f"{f:.3g}" for f in spectrum.frequency(spectrum.peak_at[used][best]))
    share = float(peak[found].sum() / (power * count).sum())
    return [
        say(
            "narrow peaks at {frequencies} Hz (their maxima alone contain {share:.2g} % of the power): vibration, "
            "sway or interference",
            frequencies=where,
            share=100 * share,
        )
    ]


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
        say(
            "the spectrum rolls off: towards {frequency:g} Hz it falls to {level:.2g} of its level at a tenth of that "
            "frequency (a filter in the sensor or logger)",
            frequency=spectrum.rate / 2,
            level=top / middle,
        )
    ]


def _where(bounds: FloatArray, ratio: FloatArray, z: FloatArray) -> list[str]:
    """The cell with the largest misfit and its neighbours of the same sign; empty if all z are zero."""
    worst = int(np.abs(z).argmax())
    if z[worst] == 0:
        return []
    strong = (np.sign(z) == np.sign(z[worst])) & (np.abs(z) > max(3.0, 0.1 * abs(z[worst])))
    left = right = worst
    while left > 0 and strong[left - 1]:
        left -= 1
    while right < z.size - 1 and strong[right + 1]:
        right += 1
    mean = math.exp(float(np.log(np.maximum(ratio[left : right + 1], LEAST)).mean()))
    what = (
        say("motion, sway, vibration or a missing term")
        if mean > 1
        else say("a filter, or a term that does not belong in the model")
    )
    return [
        say(
            "from {low:.3g} to {high:.3g} Hz the power is {ratio:.3g} times that of the model: {cause}",
            low=bounds[left],
            high=bounds[right + 1],
            ratio=mean,
            cause=what,
        )
    ]
