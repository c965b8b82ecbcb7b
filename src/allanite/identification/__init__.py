"""Identification of noise: from a record or a curve to coefficients."""

from allanite.core.residuals import Residuals as Residuals
from allanite.core.residuals import Shared as Shared

from .front import identify as identify
from .methods import METHODS as METHODS
from .methods import automatic as automatic
from .methods import symbols_of as symbols_of
