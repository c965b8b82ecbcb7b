"""Bias of a statistic against the one whose expectation it estimates: exact, as published, or by a model."""

from collections.abc import Sequence

import numpy as np

from allanite.core.errors import UsageError
from allanite.core.model import Model
from allanite.statistics.grids import part_of
from allanite.statistics.moments.lagsums import responses
from allanite.statistics.moments.means import mean_moments, takes_means
from allanite.statistics.moments.moments import by_term, noise_of
from allanite.statistics.row import FloatArray, IntArray, Statistic
from allanite.statistics.table import STATISTICS, Points

BIASES = ("exact", "published", "model", "plain")


def demand_bias(bias: str | None, row: Statistic) -> None:
    """Refuse a correction that is unknown or that the row does not have; the message says which there are."""
    if bias is None or bias == "plain":
        return
    if bias not in BIASES:
        raise UsageError(f"unknown correction of bias {bias!r}; known are {', '.join(BIASES)}, or None")
    if bool(row.parts) != (bias == "model"):
        hybrids = ", ".join(name for name, r in STATISTICS.items() if r.parts)
        raise UsageError(
            f"bias='model' is for {hybrids}, whose own bias ratio supposes one kind of noise; "
            f"{row.name} takes {'bias=model or None' if row.parts else 'exact or published'}"
        )


def correction(points: Points, bias: str, models: Sequence[Model], alpha: Sequence[int] | None) -> FloatArray:
    """What the plain variance is multiplied with, one for each point, under one model for all points or one for each.

    `alpha` are the power laws at the points, for the published tables; "model" replaces the bias ratio of a hybrid.
    """
    row, m, size = points.row, points.m, points.size
    if bias == "published":
        if alpha is None:
            raise UsageError("published factors of bias go by a power law at each tau: take noise='auto'")
        return 1 / published_bias(row, np.array(alpha), m, size)
    each = models if len(models) == len(m) else list(models) * len(m)
    made = part_of(row, m, size, points.join)
    parts = [row.parts[i] if row.parts else row for i in made]
    return np.array([_exact(part, int(k), model, points) for part, k, model in zip(parts, m, each, strict=True)])


def mean_factors(points: Points, models: Sequence[Model], scale: FloatArray | None = None) -> FloatArray:
    """Expectation of the plain statistic over that from means of what is there, shape (k, points).

    Under a model for all points or one for each, with its terms' powers times each `scale`, shape (k, t).
    """
    each = models if len(models) == len(points.m) else list(models) * len(points.m)
    factor = np.ones((1 if scale is None else len(scale), len(points.m)))
    for i, (m, whole) in enumerate(zip(points.m.tolist(), each, strict=True)):
        if takes_means(points.row, m, points.places, points.size):
            model = noise_of(whole) if scale is None else whole
            power = np.array([[t.power(points.rate) for t in model]]) * (1.0 if scale is None else scale)
            terms = [t.sampled(points.rate) for t in model]
            found = mean_moments(points.row, m, points.places, points.size).expectation(terms)
            factor[:, i] = (power @ responses(points.row, terms, m)) / (power @ found)
    return factor


def _exact(row: Statistic, m: int, model: Model, points: Points) -> float:
    """Expectation of the target over that of the statistic, at the same tau."""
    if not row.target:
        return 1.0
    target, rate = STATISTICS[row.target], points.rate
    if row.tau_factor != 1:  # the target may have no point there, but its expectation has
        tau = m * row.tau_factor / rate
        aim = by_term(target, model, 1, None, 1 / tau).sum()
    else:
        aim = by_term(target, model, m, None, rate).sum()
    return float(aim / by_term(row, model, m, points.size, rate).sum())


def published_bias(row: Statistic, alpha: int | IntArray, m: IntArray, size: int) -> FloatArray:
    """The published ratio of a statistic's expectation to that of its target, shape of m; an error if there is none.

    `alpha` is the exponent of the spectrum of the rate, at all averaging factors or at each. A statistic without bias,
    or whose bias is removed otherwise (theobr, theoh), has 1 for every noise. It is what tables and other programs
    divide by, for comparison: the exact expectation under the noise at hand is `allanite.expected`.
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
                f"no bias of {row.name} is published for noise of alpha = {law}, only for {known}; "
                "divide by the exact expectation instead, or take a statistic without bias"
            )
        here = alphas == law
        result[here] = published.factor(published.coefficients[law], m[here], size)
    return result
