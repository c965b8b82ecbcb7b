"""The confidence intervals of a curve: degrees of freedom and limits, computed on first use (docs/derivations.md)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.model import Model, Term
from allanite.core.plain import Portable
from allanite.core.units import Signal
from allanite.statistics.estimator import AngleRecord
from allanite.statistics.grids import times
from allanite.statistics.moments.compact import white_level
from allanite.statistics.moments.means import Places, TermMoments, mean_moments, relative, takes_means
from allanite.statistics.moments.moments import grouped, moments, noise_of
from allanite.statistics.row import Statistic
from allanite.statistics.table import CurvePoints
from allanite.terms import NoiseTerm

from .chisquares import ChiSquareSum, Eigenvalues, ReducedForms, is_sharp, matrices, quantiles, reduced, spectra
from .powerlaw import PowerLaw, identify_power_law

MANY_EDF = 60.0  # degrees of freedom from which on a chi-square of as many is the law
MAX_EDF = 1e8  # degrees of freedom beyond which a law is as good as certain
NO_SCATTER = 1e-15  # 1 / EDF at most of what does not scatter
LEADING = 3  # spectrum that are distinguished

RESCALING = (0.5, 1.3)
"""Factor within which the approximate leading eigenvalues may be scaled to the exact degrees of freedom."""


MAX_TOGETHER = 256  # runs of points whose moments are computed in one pass: it takes some kilobytes for each
MAX_PLACES = 4096  # stretches of a record whose moments are kept for other curves, at most: some 500 kB of places
MIN_SHARE = 1e-9  # share of a term below which it has none


@dataclass(frozen=True, eq=False)
class ModelLaw(Portable):
    """The law under a model at every point, or one for all; a sinusoid of a model adds nothing to the scatter."""

    # It does not scatter by itself, and what it adds beside noise is less than the share that it takes: limits of the
    # noise alone are wide enough.
    points: CurvePoints
    models: tuple[Model, ...]

    @cached_property
    def found(self) -> tuple[FloatArray, ChiSquareSum]:
        """Degrees of freedom and laws of V / E[V]."""
        return mixtures(self.points, self.models)

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        edf, mixture = self.found
        return edf, 1 / quantiles(mixture, (1 + level) / 2), 1 / quantiles(mixture, (1 - level) / 2)


def mixtures(points: CurvePoints, models: Sequence[Model]) -> tuple[FloatArray, ChiSquareSum]:
    """Degrees of freedom, shape (k,), and laws of V / E[V] at every point."""
    return joined([at.laws(np.ones((1, at.E.size))) for at in at_points(points, list(map(noise_of, models)))])


def joined(made: Sequence[tuple[FloatArray, ChiSquareSum]]) -> tuple[FloatArray, ChiSquareSum]:
    """Degrees of freedom and laws of several points one after the other."""
    laws = zip(*(law for _, law in made), strict=True)
    return np.concatenate([edf for edf, _ in made]), ChiSquareSum(*map(np.concatenate, laws))


@dataclass(frozen=True)
class Local:
    """What the law of a point takes from the terms of a model, whatever their sizes."""

    # `E` are their expectations, shape (t,), `r` their relative covariances, shape (t, t), `kept` what the scatter of a
    # hybrid's own bias ratio leaves of the degrees of freedom, shape (t,); `means` are given if incomplete windows
    # count.
    row: Statistic
    model: Model
    m: int
    count: int
    size: int
    rate: float
    E: FloatArray
    r: FloatArray
    kept: FloatArray
    means: tuple[TermMoments, ...] = ()

    def laws(self, scale: FloatArray) -> tuple[FloatArray, ChiSquareSum]:
        """Degrees of freedom and laws of V / E[V] with the terms' powers times each `scale`, shape (k, t)."""
        E = self.E * scale
        whole = E.sum(axis=1, keepdims=True)
        share = np.divide(E, whole, out=np.zeros_like(E), where=whole > 0)  # a statistic may remove all terms
        kept = np.where(whole[:, 0] > 0, share @ self.kept, 1.0)
        inverse = np.einsum("ki,ij,kj->k", share, self.r, share) / kept
        edf = np.maximum(1 / np.maximum(inverse, NO_SCATTER), 1.0)
        weight, dof = np.zeros((edf.size, LEADING + 2)), np.ones((edf.size, LEADING + 2))
        dof[:, 0] = np.minimum(edf, MAX_EDF)
        weight[:, 0] = 1 / dof[:, 0]
        law = ChiSquareSum(weight, dof, np.zeros(edf.size), np.zeros(edf.size))
        few = np.flatnonzero(edf < MANY_EDF)
        if few.size:
            fit, several = self._several(share[few], scale[few], 1 / edf[few])
            for part, exact in zip(law, several, strict=True):
                part[few[fit]] = exact
        return edf, law

    def _several(self, share: FloatArray, scale: FloatArray, inverse: FloatArray) -> tuple[IntArray, ChiSquareSum]:
        """The leading eigenvalues, a gamma for the rest and one for white angle noise, where they fit the EDF."""
        rows = [t.sampled(self.rate) for t in self.model]
        fixed = np.array([term.waveform is not None for term in rows])
        sharp = not self.means and is_sharp(self.row, self.count)
        white = np.array([sharp and white_level(term) > 0 for term in rows])
        smooth = ~(fixed | white)
        power = (np.array([t.power(self.rate) for t in self.model]) * scale)[:, smooth]
        held = np.flatnonzero(np.any(power > 0, axis=1))
        if not held.size:
            empty = np.empty((0, LEADING + 2))
            return held, ChiSquareSum(empty, empty, empty[:, 0], empty[:, 0])
        if self.means:
            forms = reduced(np.array([term.form for term, used in zip(self.means, smooth, strict=True) if used]))
        else:
            kinds = tuple(kind for kind, used in zip(kinds_of(self.model), smooth, strict=True) if used)
            forms = _forms(self.row, kinds, self.rate, self.m, (self.count, self.size))
        values = spectra(forms, power[held], LEADING)
        fit, laws = _mixtures(values, share[held], self.r, TermKinds(smooth, white, fixed), inverse[held])
        return held[fit], laws


class TermKinds(NamedTuple):
    """Which terms are smooth, which white angle noise, which deterministic, shape (t,) each."""

    smooth: BoolArray
    white: BoolArray
    fixed: BoolArray


def at_points(points: CurvePoints, models: Sequence[Model]) -> list[Local]:
    """What the terms of a model, or of one for each point, mean at every point."""
    row, size, rate = points.row, points.size, points.rate
    result: dict[int, Local] = {}
    alike: dict[tuple[int, tuple[Kind, ...]], list[int]] = {}  # places of points with the row and terms in common
    by_means, which = takes_means(row, points.m, points.places, size), row.part_of(points.m, size)
    for i, (part, means) in enumerate(zip(which.tolist(), by_means.tolist(), strict=True)):
        model = models[i if len(models) > 1 else 0]
        if means:
            result[i] = _of_means(points, int(points.m[i]), model)
        else:
            alike.setdefault((part, kinds_of(model)), []).append(i)
    block = max(MAX_TOGETHER // len(points.runs), 1)
    for (place, kinds), every in alike.items():
        part = row.parts[place] if row.parts else row
        hybrid = bool(row.parts) and part is row.parts[-1] and points.scattered
        for some in (every[at : at + block] for at in range(0, len(every), block)):
            m = tuple(points.m[some].tolist())
            made = _moments(part, kinds, m, tuple(tuple(grouped(points.runs, part, k)) for k in m), rate)
            for i, k, count, E, r in zip(some, m, *made, strict=True):
                model = models[i if len(models) > 1 else 0]
                kept = np.array([row.kept(term.row.slope, k / size) if hybrid else 1.0 for term in model])
                power = np.array([term.power(rate) for term in model])
                result[i] = Local(part, model, k, count, size, rate, E * power, r, kept)
    return [result[i] for i in range(points.m.size)]


Kind = tuple[NoiseTerm, tuple[float, ...]]
"""A term without its coefficient: its row, and its shape."""


def kinds_of(model: Model) -> tuple[Kind, ...]:
    """The terms of a model without their coefficients."""
    return tuple((term.row, term.shape) for term in model)


def _sampled(kinds: Sequence[Kind], rate: float) -> list[NoiseTerm]:
    return [row.shaped(shape, rate) if row.shaped else row for row, shape in kinds]


@lru_cache(maxsize=8)  # curves of the channels of a recording, some kilobytes each
def _moments(
    part: Statistic, kinds: tuple[Kind, ...], m: tuple[int, ...], runs: tuple[tuple[tuple[int, int], ...], ...],
    rate: float,
) -> tuple[list[int], FloatArray, FloatArray]:  # fmt: skip
    """Windows at each averaging factor, and moments for coefficients of 1."""
    count = [sum(int(part.count(n, np.array([k]))[0]) * times for n, times in own)
             for k, own in zip(m, runs, strict=True)]  # fmt: skip
    return count, *moments(part, _sampled(kinds, rate), np.array(m), runs)


@lru_cache(maxsize=64)  # points of such a curve, 40 KiB each
def _forms(part: Statistic, kinds: tuple[Kind, ...], rate: float, m: int, of: tuple[int, int]) -> ReducedForms:
    """The form at a point for coefficients of 1, `of` so many windows in a record of so many samples."""
    return reduced(matrices(part, _sampled(kinds, rate), m, *of))


_windows = lru_cache(maxsize=2)(mean_moments)  # terms of a model one after the other


@lru_cache(maxsize=512)  # points of the curves of channels that lost the same samples, up to 100 kB each
def _under(row: Statistic, kind: Kind, rate: float, at: tuple[int, Places, int]) -> TermMoments:
    """Moments under a term of coefficient 1 where windows with missing samples count: m, places and size."""
    return _windows(row, *at).under(*_sampled([kind], rate))


def _of_means(points: CurvePoints, m: int, model: Model) -> Local:
    """The same where windows with missing samples count."""
    row, rate, places = points.row, points.rate, tuple(points.places)
    if len(places) <= MAX_PLACES:
        each = tuple(_under(row, kind, rate, (m, places, points.size)) for kind in kinds_of(model))
    else:
        own = mean_moments(row, m, places, points.size)
        each = tuple(own.under(term) for term in _sampled(kinds_of(model), rate))
    E = np.array([term.E * t.power(rate) for term, t in zip(each, model, strict=True)])
    return Local(row, model, m, each[0].windows, points.size, rate, E, relative(each), np.ones(E.size), each)


def _mixtures(
    spectrum: Eigenvalues, share: FloatArray, r: FloatArray, kinds: TermKinds, inverse: FloatArray
) -> tuple[IntArray, ChiSquareSum]:
    """Laws with these shares, shape (k, t), that have the inverse degrees of freedom; which of them do, and theirs."""
    smooth, white, fixed = kinds
    mass = share[:, smooth].sum(axis=1)
    lead = mass[:, None] * np.pad(spectrum.leading, ((0, 0), (0, LEADING - spectrum.leading.shape[1])))
    first, own = lead.sum(axis=1), (lead**2).sum(axis=1)
    remainder, squares = mass - first, mass**2 * spectrum.squares - own
    nu = np.divide(remainder**2, squares, out=np.ones_like(mass), where=(remainder > 1e-12) & (squares > 0))
    angle, ramp = share[:, white].sum(axis=1), share[:, fixed].sum(axis=1)
    sharp = np.einsum("ki,ij,kj->k", share[:, white], r[np.ix_(white, white)], share[:, white])  # angle^2 / its EDF
    between = 2 * np.einsum("ki,ij,kj->k", share[:, fixed], r[fixed], share)
    # f with sum (f lead)^2 + (mass - f sum lead)^2 / nu = wanted, the larger root; none if it is far from 1
    wanted = inverse - between - sharp
    a, b, c = own + first**2 / nu, -2 * mass * first / nu, mass**2 / nu - wanted
    root = b * b - 4 * a * c
    fit = np.flatnonzero((root >= 0) & (a > 0))
    f = np.minimum((-b[fit] + np.sqrt(root[fit])) / (2 * a[fit]), mass[fit] / first[fit])
    near = (f >= RESCALING[0]) & (f <= RESCALING[1])
    fit, f = fit[near], f[near]
    rest = np.maximum(mass[fit] - f * first[fit], 0.0)  # where f leaves nothing, what rounding leaves may be negative
    held = angle[fit] > 0
    single = np.divide(sharp[fit], angle[fit], out=np.zeros(fit.size), where=held)
    weight = np.column_stack((f[:, None] * lead[fit], rest / nu[fit], single))
    dof = np.ones_like(weight)
    dof[:, LEADING] = nu[fit]
    dof[:, LEADING + 1] = np.divide(angle[fit], single, out=np.ones(fit.size), where=single > 0)
    # a third difference leaves of a ramp what rounding leaves
    known = ramp[fit] > MIN_SHARE
    beside = np.divide(between[fit], 2 * ramp[fit], out=np.zeros(fit.size), where=known)
    return fit, ChiSquareSum(weight, dof, ramp[fit], np.maximum(beside, 0.0))


@dataclass(frozen=True, eq=False)
class PublishedLaw(Portable):
    """A chi-square with the published degrees of freedom, at least 1, of the power law `alpha` at each point."""

    # UsageError where none are published.
    points: CurvePoints
    alpha: IntArray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        row, size = self.points.row, self.points.size
        edf = np.ones(self.points.m.size)
        for i, (alpha, m) in enumerate(zip(self.alpha.tolist(), self.points.m.tolist(), strict=True)):
            part = row.part_at(m, size)
            try:
                if part.published_edf is None:
                    raise KeyError
                edf[i] = max(part.published_edf(alpha, m, size + 1), 1.0)
            except KeyError:
                raise UsageError(
                    f"no degrees of freedom of {row.name} are published for noise of alpha = {alpha}, found at "
                    f"averaging factor {m}; use the exact ones (edf='exact')"
                ) from None
        return edf, edf / scipy.special.chdtri(edf, (1 - level) / 2), edf / scipy.special.chdtri(edf, (1 + level) / 2)


def power_laws(points: CurvePoints, angle: AngleRecord) -> tuple[PowerLaw, ...]:
    """The power law of the noise at each point."""
    row = points.row.parts[0] if points.row.parts else points.row
    return identify_power_law(angle, row, times(points.row, points.m, points.size))


def models_of(symbols: Iterable[str], signal: Signal) -> tuple[Model, ...]:
    """Models of one term with the coefficient 1, SI: of a single term no more is needed."""
    return tuple(Model((Term(symbol, 1.0, signal),)) for symbol in symbols)
