"""Compensation: estimates and removes the part of a rate that follows a temperature or another channel."""

from .compensating import compensate_file as compensate_file
from .fit import compensate as compensate
from .mixture import Gain as Gain, Mixture as Mixture
from .regression import Regression as Regression, gain_on as gain_on, load as load, save as save
from .regressor import Effect as Effect, Regressor as Regressor, aligned as aligned
from .settings import CompensationSettings as CompensationSettings, FitSettings as FitSettings
