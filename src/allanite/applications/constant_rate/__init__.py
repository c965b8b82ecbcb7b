"""A constant rate measured in a short time: estimators, their accuracy, the experiment that compares them, north."""

from .campaign import measure_rates as measure_rates
from .earth import North as North, earth_rate as earth_rate, north as north
from .estimates import RateEstimate as RateEstimate, reversal as reversal, subtract_bias as subtract_bias
from .experiments import Experiment as Experiment

from .predict import (  # isort: skip
    RATE_ESTIMATORS as RATE_ESTIMATORS, Ranking as Ranking, predicted_standard_error as predicted_standard_error, rank
    as rank)  # fmt: skip
from .row import TARGETS as TARGETS, EstimatorSettings as EstimatorSettings

from .run import (  # isort: skip
    Closeup as Closeup, ExperimentSettings as ExperimentSettings, by_duration as by_duration, closeup as closeup,
    estimate as estimate, experiment as experiment)  # fmt: skip
