"""The power law of the bias drift: f^-1, as for flicker, or another exponent.

Noise with a power spectral density of f^-1.2 is described by flicker with some random walk or quantization well enough
to pass a goodness-of-fit test, and all three coefficients are then wrong.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.estimate import WEAK, Estimate
from allanite.core.finding import Finding
from allanite.core.fit import EXPLAINED
from allanite.core.limits import Normal
from allanite.core.model import coefficient_factor
from allanite.core.units import Signal
from allanite.identification.checks.goodness import goodness
from allanite.identification.likelihood.evidence import flicker_in
from allanite.identification.likelihood.law import AKAIKE
from allanite.identification.likelihood.model_selection import Found
from allanite.identification.likelihood.selection import Subset, standard_error
from allanite.identification.likelihood.whittle import column
from allanite.phrases.phrase import join, say
from allanite.terms import TERMS, WHITE

GRID = (0.6, 0.8, 1.0, 1.2, 1.4, 1.6)
"""Exponents of the first search."""

LEAST, MOST = 0.4, 1.8
"""Range of exponents in which the limits are searched."""

GAIN, SEVERAL, CLOSE = 8.0, 3, 4.0
"""Gain in Akaike's criterion over the terms that a free exponent needs. It takes the place of so many terms of drift
even where it loses the last number: it is the simpler explanation.
"""

NEAR = 3.0
"""Refining the exponent gains less than this in 2 L beyond the grid."""

APART = 0.05
"""Minimum distance of the exponent's 95 % limits from 1."""

INTERVAL = 3.841
"""Rise of 2 L at the 95 % limits."""


@dataclass(frozen=True)
class Exponent:
    """A power law f^-a of the bias drift.

    `a`, `low` and `high` are the exponent and its 95 % limits, `gain` the gain in AIC over the best of the terms;
    `corner` is the frequency, Hz, at which it equals the white noise, `N` that noise with its standard error, SI, both
    0 without white noise; `p` the goodness of fit; `needed` the gain that names it.
    """

    a: float
    low: float
    high: float
    gain: float
    corner: float = 0.0
    N: tuple[float, float] = (0.0, 0.0)
    p: float = 1.0
    needed: float = GAIN

    @property
    def named(self) -> bool:
        """Whether the noise is not flicker."""
        known = self.low > LEAST and self.high < MOST
        return known and self.gain > self.needed and (self.low > 1 + APART or self.high < 1 - APART)


def exponent(found: Found) -> Exponent | None:
    """The free exponent of the bias drift; None if flicker was not looked for, or there is no drift or no gain.

    Quantization, angle random walk and a power law f^-a of any size are fitted instead of the terms.
    """
    which = flicker_in(found.noise)
    wanders = np.array([not TERMS[s].slope < 0 for s in found.noise])
    if which is None or not (wanders & found.chosen.free[: wanders.size]).any():
        return None
    kept = np.append(~wanders, np.zeros(found.plain.free.size - wanders.size, dtype=bool))
    kept[which] = True
    best = found.chosen.aic
    tried = [(_with(found, a, kept), a) for a in GRID]
    coarse, a = min(tried, key=lambda pair: pair[0].value)
    drifting = int((found.chosen.theta[: wanders.size] > 0)[wanders].sum())
    needed = -CLOSE if drifting >= SEVERAL else GAIN
    if best - _aic(coarse) < needed - NEAR:
        return None
    return replace(_refined(found, a, kept, best), needed=needed)


def _refined(found: Found, around: float, kept: BoolArray, best: float) -> Exponent:
    from scipy.optimize import brentq, minimize_scalar

    def twice(a: float) -> float:
        return 2 * _with(found, a, kept).value

    step = GRID[1] - GRID[0]
    bounds = (max(LEAST, around - step), min(MOST, around + step))
    a = float(minimize_scalar(twice, bounds=bounds, method="bounded", options={"xatol": 0.002}).x)
    subset = _with(found, a, kept)
    drop = 2 * subset.value + INTERVAL
    low, high = (
        end if twice(end) < drop else float(brentq(lambda x: twice(x) - drop, a, end, xtol=1e-3))
        for end in (LEAST, MOST)
    )
    p = goodness(found.seen, subset.likelihood, subset.theta, found.used).p
    law = Exponent(a, low, high, best - _aic(subset), p=p)
    which = flicker_in(found.noise)
    if "N" not in found.noise or which is None:
        return law
    # together with the angle random walk, whose error allows for the unknown exponent
    at = found.noise.index("N")
    white, size = float(subset.theta[at]), float(subset.theta[which])
    if white <= 0 or size <= 0:
        return law
    up, down = (_with(found, law.a + step, kept).likelihood.S[:, which] for step in (0.01, -0.01))
    error = standard_error(subset, at, size * (up - down) / 0.02)
    scale = found.seen.unit_factor * found.seen.rate ** -TERMS["N"].power
    root = math.sqrt(white)
    corner = found.seen.rate * (size / white) ** (1 / law.a)
    return replace(law, corner=corner, N=(scale * root, scale * error / (2 * root)))


def _aic(subset: Subset) -> float:
    """Akaike's criterion; the exponent is one number more."""
    return subset.aic + AKAIKE


def _with(found: Found, a: float, kept: BoolArray) -> Subset:
    """The minimum of L with f^-a instead of flicker."""
    which = flicker_in(found.noise)
    assert which is not None  # noqa: S101 - `exponent` has seen to it
    part = found.plain.likelihood
    row = replace(TERMS[found.noise[which]], dct=partial(_dct, a=a))
    shape = column(row, found.seen)[found.used]
    if "N" in found.noise:  # its column is 1, except for a filter
        shape = shape * part.S[:, found.noise.index("N")]
    part = part.with_column(which, shape)
    return Subset(part, kept, *part.minimise(kept))


def _dct(k: FloatArray, n: int, a: float) -> FloatArray:
    """Variance of the DCT coefficients of the mean rates over each sample of noise of density f^-a, f in 1/sample.

    The last factor is what is lost to other coefficients, for exponents from 0.6 to 1.6 within 1 %, and 3 % at k = 1.
    """
    from scipy.special import zeta

    x = k / (2.0 * n)
    aliases = zeta(2 + a, x) + zeta(2 + a, 1 - x)
    return np.asarray(np.sin(math.pi * x) ** 2 / math.pi**2 * aliases * (1 - 0.2 / k))


def other_law(found: Found, plain: Found) -> Exponent | None:
    """The power law of the bias drift, if it is not that of flicker.

    If a `plain` fit of the whole spectrum failed, and another scope was found, the power law is the reason if it
    explains the whole spectrum.
    """
    law = exponent(found)
    if (law is None or not law.named) and plain is not found:
        law = exponent(plain)
        law = law if law is not None and law.p >= EXPLAINED else None
    return law if law is not None and law.named else None


def exponent_finding(law: Exponent, found: Found, signal: Signal) -> Finding:
    """The finding that the bias drift is not flicker."""
    harm = say("B, K and Q are not meaningful as coefficients")
    begins = say("towards low frequencies")
    if law.corner:
        unit = signal.sheet[TERMS["N"].power]
        value, error = (x / coefficient_factor("N", unit, signal) for x in law.N)
        harm = join("; ", (harm, f"N = {value:.4g} ± {error:.2g} {unit}"))
        begins = say("below {frequency:.2g} Hz", frequency=min(law.corner, found.seen.rate / 2))
    return Finding(
        "flicker exponent",
        say(
            "{where} the power spectral density falls as f^-{exponent:.2f} ({low:.2f} to {high:.2f}), not as f^-1",
            where=begins,
            exponent=law.a,
            low=law.low,
            high=law.high,
        ),
        harm,
        say("read the noise at the averaging times of interest off the Allan deviation"),
    )


def under(law: Exponent, estimate: Estimate) -> Estimate:
    """The estimate if the bias drift follows another power law: only the white noise besides it is valid."""
    row = TERMS[estimate.symbol]
    value, error = law.N
    if row.waveform is not None or estimate.status == "not observable":
        return estimate
    if row.slope != WHITE or not value:
        return estimate.invalid(
            say("the power spectral density falls as f^-{exponent:.2f}, like none of the terms", exponent=law.a)
        )
    normal = Normal(value, error)
    status = "identified" if error <= WEAK * value else "weak"
    return replace(
        estimate,
        value=value,
        standard_error=error,
        status=status,
        upper=normal(0.9)[1],
        limits=normal,
        profile=normal,
        median=value,
    )
