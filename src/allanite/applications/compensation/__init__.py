"""Compensation: estimates and removes the part of a rate that follows a temperature or another channel."""

from .compensating import compensate_file as compensate_file
from .fit import compensate as compensate
from .mixture import Gain as Gain
from .mixture import Mixture as Mixture
from .regression import Regression as Regression
from .regression import gain_on as gain_on
from .regression import load as load
from .regression import save as save
from .regressor import Effect as Effect
from .regressor import Regressor as Regressor
from .regressor import aligned as aligned
from .settings import CompensationSettings as CompensationSettings
from .settings import FitSettings as FitSettings
