"""A constant rate measured in a short time: estimators, their accuracy, the experiment that compares them, north."""

from .earth import North as North
from .earth import earth_rate as earth_rate
from .earth import north as north
from .estimate import RateEstimate as RateEstimate
from .experiment import Experiment as Experiment
from .measure import estimate as estimate
from .positions import reversal as reversal
from .positions import subtract_bias as subtract_bias
from .predict import predicted_standard_error as predicted_standard_error
from .predict import rank as rank
from .ranking import Ranking as Ranking
from .run import Plan as Plan
from .run import by_duration as by_duration
from .run import experiment as experiment
from .setting import TARGETS as TARGETS
from .setting import Options as Options
from .table import RATE_ESTIMATORS as RATE_ESTIMATORS
