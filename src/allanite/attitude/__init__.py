"""Roll and pitch from gyros and accelerometers: the strapdown gyro-vertical, and its filter from identified noise."""

from .loop import Loop as Loop
from .loop import kalman as kalman
from .loop import kalman_error as kalman_error
from .prediction import Prediction as Prediction
from .prediction import predicted_error as predicted_error
from .optimum import Optimum as Optimum
from .optimum import optimal_time_constant as optimal_time_constant
