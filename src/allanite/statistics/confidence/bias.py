"""Bias of a statistic against the one whose expectation it estimates: exact, as published, or by a model."""

from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.estimate import Averaged
from allanite.core.model import Model
from allanite.core.names import demand_name
from allanite.statistics.grids import part_of
from allanite.statistics.moments.lagsums import responses
from allanite.statistics.moments.means import mean_moments, takes_means
from allanite.statistics.moments.moments import by_term
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS, CurvePoints

BIASES = ("exact", "published", "model", "plain")


def chosen_bias(bias: str | None, row: Statistic, given: Averaged | None) -> str | None:
    """The correction that is asked for; a hybrid whose noise is `given` has that of the model."""
    demand_bias(bias, row)
    if bias is None and given is not None and row.parts:
        return "model"
    return None if bias == "plain" else bias


def demand_bias(bias: str | None, row: Statistic) -> None:
    """Refuse a correction that is unknown or that the row does not have; the message says which there are."""
    if bias is None or bias == "plain":
        return
    demand_name("bias correction", bias, BIASES)
    if bool(row.parts) != (bias == "model"):
        hybrids = ", ".join(name for name, r in STATISTICS.items() if r.parts)
        raise UsageError(
            f"bias='model' is for {hybrids}, whose own bias ratio assumes a single power law; {row.name} takes "
            f"{'bias=model or None' if row.parts else 'exact or published'}"
        )


def correction(points: CurvePoints, bias: str, models: Sequence[Model], alpha: Sequence[int]) -> FloatArray:
    """What the plain variance is multiplied with, one for each point, under the power law of each.

    `alpha` are the exponents at the points, for the published tables; "model" replaces the bias ratio of a hybrid.
    """
    if bias == "published":
        return 1 / published_bias(points.row, np.array(alpha), points.m, points.size)
    one = [np.ones((1, len(model.terms))) for model in models]
    factor = _of_means if bias == "means" else _exact
    return np.array([factor(points, i, model, o)[0] for i, (model, o) in enumerate(zip(models, one, strict=True))])


def corrections(points: CurvePoints, bias: str, noise: Averaged) -> FloatArray:
    """What the plain variance is multiplied with under each model, shape (models, points)."""
    if bias == "published":
        raise UsageError("published bias factors assume a power law at each tau: use noise='auto'")
    factor = _of_means if bias == "means" else _exact
    return np.array([factor(points, i, noise.terms, noise.scale) for i in range(points.m.size)]).T


def _of_means(points: CurvePoints, i: int, terms: Model, scale: FloatArray) -> FloatArray:
    """Expectation of the plain statistic over that from means of what is there, with each scale of the powers."""
    row, m, rate = points.row, int(points.m[i]), points.rate
    if not takes_means(row, m, points.places, points.size):
        return np.ones(len(scale))
    kept = [i for i, t in enumerate(terms) if t.row.scatters]
    noise = [terms.terms[i] for i in kept]
    power, rows = scale[:, kept] * [t.power(rate) for t in noise], [t.sampled(rate) for t in noise]
    found = mean_moments(row, m, points.places, points.size).expectation(rows)
    own = power @ found
    # a model may have none of these terms: nothing to correct
    return np.divide(power @ responses(row, rows, np.array([m]))[:, 0], own, out=np.ones(len(scale)), where=own > 0)


def _exact(points: CurvePoints, i: int, terms: Model, scale: FloatArray) -> FloatArray:
    """Expectation of the target over that of the statistic, at the same tau, with each scale of the terms' powers."""
    row, m, rate = points.row, int(points.m[i]), points.rate
    if row.parts:
        row = row.parts[int(part_of(row, points.m[i : i + 1], points.size, points.join)[0])]
    if not row.target:
        return np.ones(len(scale))
    target = STATISTICS[row.target]
    kept = [i for i, t in enumerate(terms) if not t.row.transient]
    terms, scale = Model(tuple(terms.terms[i] for i in kept)), scale[:, kept]
    # where a sample is not a sample of the target, it may have no point there, but its expectation has
    at = (1, None, rate / (m * row.tau_factor)) if row.tau_factor != 1 else (m, None, rate)
    aim, own = by_term(target, terms, *at), by_term(row, terms, m, points.size, rate)
    return np.asarray((scale @ aim) / (scale @ own))


def published_bias(row: Statistic, alpha: int | IntArray, m: IntArray, size: int) -> FloatArray:
    """The published ratio of a statistic's expectation to that of its target, shape of m; an error if there is none.

    `alpha` is the exponent of the spectrum of the rate, at all averaging factors or at each. A statistic without bias,
    or whose bias is removed otherwise (theobr, theoh), has 1 for every noise. Tables and other programs divide by it;
    use it for comparison: the exact expectation under the noise at hand is `allanite.expected`.
    """
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
