"""A constant rate measured in a short time: estimators, their accuracy, the experiment that compares them, north."""

from .earth import North as North
from .earth import earth_rate as earth_rate
from .earth import north as north
from .estimate import RateEstimate as RateEstimate
from .estimate import reversal as reversal
from .estimate import subtract_bias as subtract_bias
from .measure import RATE_ESTIMATORS as RATE_ESTIMATORS
from .measure import estimate as estimate
from .measure import predicted_standard_error as predicted_standard_error
from .measure import rank as rank
from .predict import Ranking as Ranking
from .row import TARGETS as TARGETS
from .row import Options as Options
