"""The models consistent with a record, with their weights."""

from allanite.core.averaged import Averaged, averaged
from allanite.core.model import Model, Term

from .estimates import CoefficientScale
from .model_selection import Found

NODES = 12
"""Models along the profile, at most."""

PRIOR = 0.0
"""Power of the coefficient in its prior."""

LEAST = 1e-3
"""Weight of a model, over that of the heaviest, below which it is omitted."""


def nodes(found: Found, scale: CoefficientScale, beside: tuple[Term, ...]) -> Averaged:
    """Models along the profile of the noise of the longest memory, all terms free, with what stands `beside` it.

    That noise dominates the long averaging times and is known from a few coefficients only: terms that were not
    selected may be present. The weights are those of its likelihood times a flat prior of its coefficient.
    """
    thetas, weight = found.profile(found.slowest).weighted(NODES, PRIOR)
    constants = found.everything.constants
    each = [scale.powers(found.noise, theta, constants) for theta in thetas]
    kept = [
        (Model((*terms, *beside)), float(w)) for terms, w in zip(each, weight, strict=True) if w > LEAST * weight.max()
    ]
    return averaged([model for model, _ in kept], [w for _, w in kept])
