"""Roll and pitch from gyros and accelerometers: the strapdown gyro-vertical, and its filter from identified noise."""

from .filters import (  # isort: skip
    FILTERS as FILTERS, Setting as Setting, attitudes as attitudes, rotation_vectors as rotation_vectors)  # fmt: skip
from .inertial import Inertial as Inertial
from .loop import Loop as Loop, kalman as kalman
from .optimum import Optimum as Optimum, optimal_time_constant as optimal_time_constant

from .prediction import (  # isort: skip
    Prediction as Prediction, Source as Source, error_density as error_density, predicted_error as predicted_error
)  # fmt: skip
from .result import Angle as Angle, VerticalSettings as VerticalSettings, VerticalStudy as VerticalStudy

from .scenarios import (  # isort: skip
    SCENARIOS as SCENARIOS, ScenarioErrors as ScenarioErrors, Trial as Trial, compare_filters as compare_filters,
    simulate_motion as simulate_motion)  # fmt: skip
from .tuning import vertical as vertical
