"""Roll and pitch from gyros and accelerometers: the strapdown gyro-vertical, and its filter from identified noise."""

from .filters import FILTERS as FILTERS
from .filters import Setting as Setting
from .filters import attitudes as attitudes
from .filters import rotation_vectors as rotation_vectors
from .inertial import Inertial as Inertial
from .loop import Loop as Loop
from .loop import kalman as kalman
from .optimum import Optimum as Optimum
from .optimum import optimal_time_constant as optimal_time_constant
from .prediction import Prediction as Prediction
from .prediction import Source as Source
from .prediction import error_density as error_density
from .prediction import predicted_error as predicted_error
from .result import Angle as Angle
from .result import VerticalSettings as VerticalSettings
from .result import VerticalStudy as VerticalStudy
from .scenarios import SCENARIOS as SCENARIOS
from .scenarios import ScenarioErrors as ScenarioErrors
from .scenarios import Trial as Trial
from .scenarios import compare_filters as compare_filters
from .scenarios import simulate_motion as simulate_motion
from .tuning import vertical as vertical
