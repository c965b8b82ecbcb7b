"""Identification of noise: from a record or a curve to coefficients."""

from allanite.core.residuals import Residuals as Residuals, Shared as Shared

from .front import identify as identify
from .methods import METHODS as METHODS, automatic as automatic, symbols_of as symbols_of
