"""The confidence intervals of a curve: degrees of freedom and limits, computed on first use (docs/derivations.md)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.model import Model, Term
from allanite.core.plain import Portable
from allanite.core.units import Signal
from allanite.statistics.estimator import AngleRecord
from allanite.statistics.grids import times
from allanite.statistics.moments.compact import white_level
from allanite.statistics.moments.means import MeanMoments, mean_moments, takes_means
from allanite.statistics.moments.moments import grouped, moments, noise_of
from allanite.statistics.row import Statistic
from allanite.statistics.table import CurvePoints
from allanite.terms import TERMS

from .chisquares import ChiSquareSum, Eigenvalues, is_sharp, matrices, quantiles, spectra
from .powerlaw import PowerLaw, identify_power_law

MANY_EDF = 60.0  # degrees of freedom from which on a chi-square of as many is the law
MAX_EDF = 1e8  # degrees of freedom beyond which a law is as good as certain
NO_SCATTER = 1e-15  # 1 / EDF at most of what does not scatter
LEADING = 3  # spectrum that are distinguished

RESCALING = (0.5, 1.3)
"""Factor within which the approximate leading eigenvalues may be scaled to the exact degrees of freedom."""


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
    models = [noise_of(model) for model in models]
    local = [at_point(points, i, models[i if len(models) > 1 else 0]) for i in range(points.m.size)]
    return stacked([at.laws(np.ones((1, at.E.size)))[0] for at in local])


def stacked(made: Sequence[tuple[float, ChiSquareSum]]) -> tuple[FloatArray, ChiSquareSum]:
    """Degrees of freedom and laws one by one, as arrays."""
    edf = np.array([e for e, _ in made])
    weight, dof, mean, beside = (np.array([m[i] for _, m in made]) for i in range(4))
    return edf, ChiSquareSum(weight, dof, mean, beside)


@dataclass(frozen=True)
class Local:
    """What the law of a point takes from the terms of a model, whatever their sizes."""

    # `E` are their expectations, shape (t,), `r` their relative covariances, shape (t, t), `kept` what the scatter of a
    # hybrid's own bias ratio leaves of the degrees of freedom, shape (t,); `means` is given if incomplete windows
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
    means: MeanMoments | None = None

    def laws(self, scale: FloatArray) -> list[tuple[float, ChiSquareSum]]:
        """Degrees of freedom and laws of V / E[V] with the terms' powers times each `scale`, shape (k, t)."""
        E = self.E * scale
        whole = E.sum(axis=1, keepdims=True)
        share = np.divide(E, whole, out=np.zeros_like(E), where=whole > 0)  # a statistic may remove all terms
        kept = np.where(whole[:, 0] > 0, share @ self.kept, 1.0)
        inverse = np.einsum("ki,ij,kj->k", share, self.r, share) / kept
        edf = [max(1 / max(v, NO_SCATTER), 1.0) for v in inverse.tolist()]
        few = np.array([e < MANY_EDF for e in edf])
        several = iter(self._several(share[few], scale[few], 1 / np.array(edf)[few]) if few.any() else [])
        laws = []
        for e, f in zip(edf, few, strict=True):
            law = next(several) if f else None
            if law is None:
                weight, dof = np.zeros(LEADING + 2), np.ones(LEADING + 2)
                dof[0] = min(e, MAX_EDF)
                weight[0] = 1 / dof[0]
                law = ChiSquareSum(weight, dof, np.array(0.0), np.array(0.0))
            laws.append((e, law))
        return laws

    def _several(self, share: FloatArray, scale: FloatArray, inverse: FloatArray) -> list[ChiSquareSum | None]:
        """The leading eigenvalues, a gamma for the rest and one for white angle noise; None if they fit no EDF."""
        rows = [t.sampled(self.rate) for t in self.model]
        fixed = np.array([term.waveform is not None for term in rows])
        sharp = self.means is None and is_sharp(self.row, self.count)
        white = np.array([sharp and white_level(term) > 0 for term in rows])
        smooth = ~(fixed | white)
        power = (np.array([t.power(self.rate) for t in self.model]) * scale)[:, smooth]
        held = np.asarray(np.any(power > 0, axis=1))
        if not held.any():
            return [None] * len(share)
        terms = [row for row, used in zip(rows, smooth, strict=True) if used]
        forms = self.means.forms(terms) if self.means else matrices(self.row, terms, self.m, self.count, self.size)
        values = iter(spectra(forms, power[held], LEADING))
        kinds = Kinds(smooth, white, fixed)
        return [
            _mixture(next(values), p, self.r, kinds, v) if h else None
            for p, v, h in zip(share, inverse.tolist(), held.tolist(), strict=True)
        ]


class Kinds(NamedTuple):
    """Which terms are smooth, which white angle noise, which deterministic, shape (t,) each."""

    smooth: BoolArray
    white: BoolArray
    fixed: BoolArray


def at_point(points: CurvePoints, i: int, model: Model) -> Local:
    """What a model's terms mean at a point."""
    row, m, size = points.row, int(points.m[i]), points.size
    if takes_means(row, m, points.places, size):
        # the same where windows with missing samples count
        row, rate = points.row, points.rate
        means, terms = mean_moments(row, m, points.places, points.size), [term.sampled(rate) for term in model]
        E = means.expectation(terms)
        power = np.array([term.power(rate) for term in model])
        count = means.windows.start.size
        return Local(
            row, model, m, count, points.size, rate, E * power, means.relative(terms, E), np.ones(len(terms)), means
        )
    part = row.part_at(m, size)
    runs = grouped(points.runs, part, m)
    count = sum(int(part.count(n, np.array([m]))[0]) * times for n, times in runs)
    hybrid = row.parts and part is row.parts[-1] and points.scattered
    kept = np.array([row.kept(term.row.slope, m / size) if hybrid else 1.0 for term in model])
    return Local(part, model, m, count, size, points.rate, *moments(part, model, m, runs, points.rate), kept)


def _mixture(
    spectrum: Eigenvalues, share: FloatArray, r: FloatArray, kinds: Kinds, inverse: float
) -> ChiSquareSum | None:
    smooth, white, fixed = kinds
    mass = float(share[smooth].sum())
    lead = np.pad(mass * spectrum.leading, (0, LEADING - spectrum.leading.size))
    remainder, squares = mass - float(lead.sum()), mass**2 * spectrum.squares - float(lead @ lead)
    nu = remainder**2 / squares if remainder > 1e-12 and squares > 0 else 1.0
    angle, ramp = float(share[white].sum()), float(share[fixed].sum())
    own = float(share[white] @ r[np.ix_(white, white)] @ share[white]) / angle**2 if angle else 0.0
    between = 2 * float(share[fixed] @ r[fixed] @ share)
    # f with sum (f lead)^2 + (mass - f sum lead)^2 / nu = wanted, the larger root; none if it is far from 1
    wanted, first = inverse - between - angle**2 * own, float(lead.sum())
    a, b, c = float(lead @ lead) + first**2 / nu, -2 * mass * first / nu, mass**2 / nu - wanted
    root = b * b - 4 * a * c
    if root < 0 or a == 0:
        return None
    f = min((-b + root**0.5) / (2 * a), mass / first)
    if not RESCALING[0] <= f <= RESCALING[1]:
        return None
    rest = max(mass - f * float(lead.sum()), 0.0)  # where f leaves nothing, what rounding leaves may be negative
    weight = np.array([*(f * lead), rest / nu, angle * own])
    dof = np.array([1.0] * LEADING + [nu, 1 / own if own else 1.0])
    # a third difference leaves of a ramp what rounding leaves
    beside = max(between / (2 * ramp), 0.0) if ramp > MIN_SHARE else 0.0
    return ChiSquareSum(weight, dof, np.array(ramp), np.array(beside))


def automatic_law(points: CurvePoints, angle: AngleRecord, signal: Signal) -> ModelLaw:
    """The law under the power law that is found at each averaging time."""
    return ModelLaw(points, tuple(Model((unit_term(law.symbol, signal),)) for law in power_laws(points, angle)))


@dataclass(frozen=True, eq=False)
class PublishedLaw(Portable):
    """A chi-square with the published degrees of freedom, at least 1, of the power law `alpha` at each point."""

    # UsageError where none are published.
    points: CurvePoints
    alpha: IntArray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        from scipy.special import chdtri

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
        return edf, edf / chdtri(edf, (1 - level) / 2), edf / chdtri(edf, (1 + level) / 2)


def power_laws(points: CurvePoints, angle: AngleRecord) -> tuple[PowerLaw, ...]:
    """The power law of the noise at each point."""
    row = points.row.parts[0] if points.row.parts else points.row
    return identify_power_law(angle, row, times(points.row, points.m, points.size))


def unit_term(symbol: str, signal: Signal) -> Term:
    """A term with the coefficient 1, SI: of a single term no more is needed."""
    assert symbol in TERMS  # noqa: S101 - the identification knows no other
    return Term(symbol, 1.0, signal)
