"""A constant rate measured in a short time: estimators, their accuracy, the experiment that compares them, north."""

from .campaign import measure_rates as measure_rates
from .earth import North as North
from .earth import earth_rate as earth_rate
from .earth import north as north
from .estimates import RateEstimate as RateEstimate
from .estimates import reversal as reversal
from .estimates import subtract_bias as subtract_bias
from .experiments import Experiment as Experiment
from .predict import RATE_ESTIMATORS as RATE_ESTIMATORS
from .predict import Ranking as Ranking
from .predict import predicted_standard_error as predicted_standard_error
from .predict import rank as rank
from .row import TARGETS as TARGETS
from .row import EstimatorSettings as EstimatorSettings
from .run import Closeup as Closeup
from .run import ExperimentSettings as ExperimentSettings
from .run import by_duration as by_duration
from .run import closeup as closeup
from .run import estimate as estimate
from .run import experiment as experiment
