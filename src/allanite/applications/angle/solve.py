"""Constants from samples: sample by sample, or all at once."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from allanite.extending import DataError, FloatArray, UsageError, demand_name

from .residuals import checks, level_check
from .solution import History, Solution
from .squareroot import SquareRoot, batch

VAGUE = 1e7
"""A prior deviation, in units of what one reading tells of a constant, that no result notices."""

SINGULAR = 1e-12
"""Singular value over the largest, below which a combination of constants is not seen at all."""

CHECKPOINTS = 200
"""Instants of the history that are kept."""


class System(NamedTuple):
    """Samples ``values = rows x + noise`` of constants x called `names`; `time` orders them."""

    names: tuple[str, ...]
    rows: FloatArray
    values: FloatArray
    time: FloatArray


def solve(
    system: System, *, sigma: float | None = None, prior: FloatArray | None = None, method: str = "recursive"
) -> Solution:
    """Constants from samples.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> time = np.arange(100.0)
    >>> rows = np.column_stack([np.ones(100), time])
    >>> found = solve(System(("offset", "slope"), rows, rows @ [2.0, 0.1] + rng.standard_normal(100), time))
    >>> bool(abs(found["slope"] - 0.1) < 3 * found.error("slope"))
    True
    """
    alone, spread, freedom = _alone(system, sigma, prior)
    vague = prior if prior is not None else VAGUE * spread / np.sqrt((system.rows**2).mean(axis=0))
    rows, values = system.rows / spread, system.values / spread
    demand_name("method", method, METHODS)
    end, history, left = METHODS[method](SquareRoot.before(vague), rows, values, system.time)
    level = () if sigma is None else (level_check(alone.squares / spread**2, freedom),)
    return Solution(
        names=system.names,
        values=end.values,
        covariance=end.covariance,
        sigma=spread,
        given=sigma is not None,
        freedom=math.inf if sigma is not None else freedom,
        condition=alone.condition,
        prior=prior,
        history=history,
        innovations=left,
        checks=(*level, *checks(left, values - rows @ end.values)),
        known=end,
    )


def _alone(system: System, sigma: float | None, prior: FloatArray | None) -> tuple[SquareRoot, float, int]:
    """What the samples tell without a prior; the noise of one; the degrees of freedom that are left."""
    n, p = system.rows.shape
    if sigma is not None and not (math.isfinite(sigma) and sigma > 0):
        raise UsageError(f"sigma must be a positive number, not {sigma!r}; omit it to have it estimated")
    if prior is not None and not (prior > 0).all():
        raise UsageError(f"prior standard deviations must be positive, not {prior.tolist()}")
    if n <= p:
        raise DataError(f"{n} samples are too few for {p} constants and their noise; record for longer")
    if np.ptp(system.values) == 0:
        raise DataError(f"the samples are constant (always {system.values[0]:.10g}); check the column")
    alone = batch(system.rows, system.values)
    values, directions = alone.singular
    seen = int((values > SINGULAR * values[0]).sum())
    if seen < p and prior is None:
        mixed = [name for name, part in zip(system.names, np.abs(directions[-1]), strict=True) if part > 0.1]
        raise DataError(
            f"the samples determine {seen} combinations of {p} constants; {', '.join(mixed)} cannot be separated: omit "
            "one of them, let the angles move further, or give a prior"
        )
    # a column in the span of others leaves rounding noise on the diagonal; least squares proper ignores it
    x, *_ = np.linalg.lstsq(alone.factor[:, :-1], alone.factor[:, -1], rcond=SINGULAR)
    squares = alone.squares + float(((alone.factor[:, -1] - alone.factor[:, :-1] @ x) ** 2).sum())
    spread = math.sqrt(squares / (n - seen)) if sigma is None else sigma
    if spread == 0:
        raise DataError("the constants explain every sample exactly, so that the noise cannot be estimated; give sigma")
    return SquareRoot(alone.factor, squares, n), spread, n - seen


Run = tuple[SquareRoot, History, FloatArray]


def _recursive(start: SquareRoot, rows: FloatArray, values: FloatArray, time: FloatArray) -> Run:
    marks = np.unique(np.linspace(0, values.size, min(CHECKPOINTS, values.size) + 1).astype(np.int64))
    known, left, way = start, [], []
    for first, last in pairwise(marks.tolist()):
        known, part = known.absorb(rows[first:last], values[first:last])
        left.append(part)
        way.append((known.values, known.errors))
    history = History(marks[1:], time[marks[1:] - 1], np.array([v for v, _ in way]), np.array([e for _, e in way]))
    return known, history, np.concatenate(left)


def _batch(start: SquareRoot, rows: FloatArray, values: FloatArray, time: FloatArray) -> Run:
    known = batch(rows, values, 1 / np.diag(start.factor))
    history = History(np.array([values.size]), time[-1:], known.values[None], known.errors[None])
    return known, history, values - rows @ known.values


METHODS = {"recursive": _recursive, "batch": _batch}
