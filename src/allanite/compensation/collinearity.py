"""Whether the whitened columns of a regression can be separated from each other and from a ramp."""

from typing import NamedTuple

import numpy as np

from allanite.core.language import join, say
from allanite.core.wording import spelled
from allanite.identification.likelihood.likelihood import Likelihood

from .design import Design
from .restricted import FloatArray

CONDITION = 30.0
"""Scaled condition number above which coefficients cannot be separated (Belsley, Kuh, Welsch 1980)."""

TRENDING = 0.9
"""Share of a ramp explained by the regressors above which they are confounded with it."""


class Collinearity(NamedTuple):
    """Scaled condition number, variance inflation of each column, and warnings."""

    condition: float
    inflation: FloatArray
    notes: tuple[str, ...]


def collinearity(design: Design, likelihood: Likelihood, theta: FloatArray) -> Collinearity:
    """Collinearity of the columns of a design under the noise theta."""
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
    ramp = _of_ramp(design, likelihood.expectation(theta), A)
    if ramp > TRENDING:
        notes.append(
            say(
                "the regressors have a trend: they explain {percent:.3g} % of a linear drift, so that a rate ramp R "
                "cannot be separated from their effect in this record ({option} estimates one jointly); a record in "
                "which they return to their initial values would separate them",
                percent=100 * ramp,
                option=spelled("--trend", "trend=True"),
            )
        )
    return Collinearity(condition, inflation, tuple(notes))


def information(likelihood: Likelihood, theta: FloatArray) -> FloatArray:
    """X' C^-1 X of the flat directions, shape (p, p), the edges known."""
    flat = np.flatnonzero(likelihood.flat)
    return np.asarray(np.einsum("bij,b->ij", likelihood.UU[:, flat][:, :, flat], 1 / likelihood.expectation(theta)))


def _of_ramp(design: Design, m: FloatArray, A: FloatArray) -> float:
    """Share of a ramp that the columns explain, whitened; 0 where time is one of them."""
    if len(design.taken) < len(design.regressors):
        return 0.0
    # the ramp takes the place of the rates: its products with the columns are all that is wanted
    seen = design.likelihood("N", y=np.linspace(-1.0, 1.0, design.y.size))
    b = (1 / m) @ seen.Uc[:, np.flatnonzero(seen.flat)]
    whole = float((1 / m) @ (seen.count * seen.power))
    return float(b @ np.linalg.solve(A, b) / whole)
