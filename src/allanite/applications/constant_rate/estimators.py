"""The table of estimators."""

from allanite.extending import row_of

from .linear import CONDITIONAL, HAMMING, MEAN, OPTIMAL, REGRESSION
from .row import RateEstimator
from .staircase import STAIRCASE

RATE_ESTIMATORS: dict[str, RateEstimator] = {
    row.name: row for row in (MEAN, HAMMING, REGRESSION, CONDITIONAL, STAIRCASE, OPTIMAL)
}


def estimator_named(name: str) -> RateEstimator:
    """The row of `RATE_ESTIMATORS`; an unknown name is an error that lists the known ones."""
    return row_of("rate estimator", name, RATE_ESTIMATORS)
