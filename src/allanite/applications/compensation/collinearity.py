"""Whether the whitened columns of a regression can be separated from each other, and from a ramp that is left out."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from allanite.extending import Likelihood, join, say, spelled

from .design import Design
from .restricted import FloatArray

CONDITION = 30.0
"""Scaled condition number above which coefficients cannot be separated (Belsley, Kuh, Welsch 1980)."""

TRENDING = 0.5
"""Share of a ramp explained by the regressors from which on they are confounded with it."""

LARGE = 3.0
"""Standard errors from which on an effect is beyond doubt."""


class Collinearity(NamedTuple):
    """Scaled condition number, variance inflation of each column, and warnings."""

    condition: float
    inflation: FloatArray
    notes: tuple[str, ...]


def collinearity(design: Design, likelihood: Likelihood, theta: FloatArray, symbols: str) -> Collinearity:
    """Collinearity of the columns of a design under the noise theta of some terms."""
    A = information(likelihood, theta)
    size = np.sqrt(np.diag(A))
    values = np.linalg.eigvalsh(A / np.outer(size, size))
    inflation = np.diag(np.linalg.inv(A / np.outer(size, size))).copy()
    condition = float(np.sqrt(values[-1] / max(values[0], 1e-300)))
    notes = []
    if condition > CONDITION:
        factors = zip(design.labels, inflation, strict=True)
        worst = join(", ", [join("", (label, f" ({factor:.3g})")) for label, factor in factors if factor > 10])
        notes.append(
            say(
                "the regressors can hardly be separated: scaled condition number {condition:.3g}, above {limit:g}; "
                "variance inflation {worst}. Their sum may be accurate although none of them is",
                condition=condition,
                limit=CONDITION,
                worst=worst or say("spread over all"),
            )
        )
    if design.trend:
        return Collinearity(condition, inflation, tuple(notes))
    # the share of a ramp that the columns explain, whitened, and the ramp beside them over its standard error
    ramp = np.linspace(-1.0, 1.0, design.y.size)
    wider = replace(design, X=np.column_stack((design.X, ramp))).likelihood(symbols)
    eta, V, _ = wider.directions(theta)
    share, t = 1 - 1 / float(V[-1, -1] * information(wider, theta)[-1, -1]), float(eta[-1] / np.sqrt(V[-1, -1]))
    why = None
    if share > TRENDING:
        why = say("the regressors have a trend: they explain {percent:.3g} % of a linear drift, so that a rate ramp R "
                  "would be taken for their effect", percent=100 * share)  # fmt: skip
    elif abs(t) > LARGE:
        why = say("the record shows a rate ramp R beside the regressors ({t:.3g} standard errors): part of it is taken "
                  "for their effect", t=abs(t))  # fmt: skip
    if why:
        notes.append(join("; ", (why, say("omit {option}", option=spelled("--no-trend", "trend=False")))))
    return Collinearity(condition, inflation, tuple(notes))


def information(likelihood: Likelihood, theta: FloatArray) -> FloatArray:
    """X' C^-1 X of the flat directions, shape (p, p), the edges known."""
    flat = np.flatnonzero(likelihood.flat)
    return np.asarray(np.einsum("bij,b->ij", likelihood.UU[:, flat][:, :, flat], 1 / likelihood.expectation(theta)))
