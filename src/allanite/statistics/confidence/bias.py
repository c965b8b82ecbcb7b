"""Bias of a statistic against the one whose expectation it estimates: exact, as published, or by a model."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.estimate import Averaged
from allanite.core.model import Model
from allanite.core.names import row_of
from allanite.statistics.moments.lagsums import responses
from allanite.statistics.moments.means import mean_moments, takes_means
from allanite.statistics.moments.moments import by_term
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS, CurvePoints


class Bias(NamedTuple):
    """A correction: what the plain variance is multiplied with at a point, and whether it is that of hybrids."""

    # `factor` takes the points, the place of one, its model and each scale of the powers of the model's terms, shape
    # (k, t). The published one follows from the exponent of the power law at each point instead.
    factor: Callable[[CurvePoints, int, Model, FloatArray], FloatArray] | None
    hybrid: bool = False


def chosen_bias(bias: str | None, row: Statistic, given: Averaged | None) -> Bias | None:
    """The correction that is asked for; a hybrid whose noise is `given` has that of the model."""
    demand_bias(bias, row)
    if bias is None and given is not None and row.parts:
        return BIASES["model"]
    return None if bias in (None, "plain") else BIASES[bias]


def demand_bias(bias: str | None, row: Statistic) -> None:
    """Refuse a correction that is unknown or that the row does not have; the message says which there are."""
    if bias is None or bias == "plain":
        return
    if row_of("bias correction", bias, BIASES).hybrid != bool(row.parts):
        hybrids = ", ".join(name for name, r in STATISTICS.items() if r.parts)
        raise UsageError(
            f"bias='model' is for {hybrids}, whose own bias ratio assumes a single power law; {row.name} takes "
            f"{'bias=model or None' if row.parts else 'exact or published'}"
        )


def corrections(
    points: CurvePoints, bias: Bias, models: Sequence[Model], scale: FloatArray, alpha: Sequence[int] = ()
) -> FloatArray:
    """What the plain variance is multiplied with, with each scale of the powers of the terms, shape (k, points)."""
    # The model is one for all points, or that of the power law at each, whose exponents are `alpha`.
    if bias.factor is None:
        if not len(alpha):
            raise UsageError("published bias factors assume a power law at each tau: use noise='auto'")
        return 1 / published_bias(points.row, np.array(alpha), points.m, points.size)[None]
    at = range(points.m.size)
    return np.array([bias.factor(points, i, models[i if len(models) > 1 else 0], scale) for i in at]).T


def _of_means(points: CurvePoints, i: int, terms: Model, scale: FloatArray) -> FloatArray:
    """Expectation of the plain statistic over that from means of what is there, with each scale of the powers."""
    row, m, rate = points.row, int(points.m[i]), points.rate
    kept = [i for i, t in enumerate(terms) if t.row.scatters]
    if not kept or not takes_means(row, m, points.places, points.size):  # or there is nothing to correct
        return np.ones(len(scale))
    noise = [terms.terms[i] for i in kept]
    power, rows = scale[:, kept] * [t.power(rate) for t in noise], [t.sampled(rate) for t in noise]
    own = power @ mean_moments(row, m, points.places, points.size).expectation(rows)
    return np.divide(power @ responses(row, rows, np.array([m]))[:, 0], own, out=np.ones(len(scale)), where=own > 0)


def _exact(points: CurvePoints, i: int, terms: Model, scale: FloatArray) -> FloatArray:
    """Expectation of the target over that of the statistic, at the same tau, with each scale of the terms' powers."""
    m, rate = int(points.m[i]), points.rate
    row = points.row.part_at(m, points.size)
    if not row.target:
        return np.ones(len(scale))
    target = STATISTICS[row.target]
    kept = [i for i, t in enumerate(terms) if not t.row.transient]
    terms, scale = Model(tuple(terms.terms[i] for i in kept)), scale[:, kept]
    # where a sample is not a sample of the target, it may have no point there, but its expectation has
    at = (1, None, rate / (m * row.tau_factor)) if row.tau_factor != 1 else (m, None, rate)
    aim, own = by_term(target, terms, *at), by_term(row, terms, m, points.size, rate)
    return np.asarray((scale @ aim) / (scale @ own))


BIASES = {"exact": Bias(_exact), "published": Bias(None), "model": Bias(_exact, hybrid=True), "plain": Bias(None)}
"""Corrections by their name."""

MEANS = Bias(_of_means)  # that of means of what is there instead of complete windows


def published_bias(row: Statistic, alpha: int | IntArray, m: IntArray, size: int) -> FloatArray:
    """The published ratio of a statistic's expectation to that of its target, shape of m; an error if there is none."""
    # `alpha` is the exponent of the spectrum of the rate, at all averaging factors or at each. A statistic without
    # bias, or whose bias is removed otherwise (theobr, theoh), has 1 for every noise. Tables and other programs divide
    # by it; use it for comparison: the exact expectation under the noise at hand is `allanite.expected`.
    alphas = np.broadcast_to(alpha, m.shape)
    result = np.ones(m.shape)
    published = row.published
    if published is None:
        return result
    for law in np.unique(alphas).tolist():
        if law not in published.coefficients:
            known = ", ".join(map(str, sorted(published.coefficients)))
            raise UsageError(
                f"no bias of {row.name} is published for noise of alpha = {law}, only for {known}; divide by the "
                "exact expectation instead, or use a statistic without bias"
            )
        here = alphas == law
        result[here] = published.factor(published.coefficients[law], m[here], size)
    return result
