"""The table of estimators."""

from allanite.extending import UsageError

from .linear import CONDITIONAL, HAMMING, MEAN, REGRESSION
from .optimal import OPTIMAL
from .row import RateEstimator
from .staircase import STAIRCASE

RATE_ESTIMATORS: dict[str, RateEstimator] = {
    row.name: row for row in (MEAN, HAMMING, REGRESSION, CONDITIONAL, STAIRCASE, OPTIMAL)
}


def estimator_named(name: str) -> RateEstimator:
    """The row of `RATE_ESTIMATORS`; an unknown name is an error that lists the known ones."""
    if name not in RATE_ESTIMATORS:
        raise UsageError(f"unknown rate estimator {name!r}; known estimators: {', '.join(RATE_ESTIMATORS)}")
    return RATE_ESTIMATORS[name]
