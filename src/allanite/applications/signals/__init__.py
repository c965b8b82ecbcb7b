"""From raw signals to a rate, and the noise that quantization adds to it."""

from .budgeting import PathSettings as PathSettings
from .budgeting import budget_file as budget_file
from .budgeting import mixed as mixed
from .rounding_noise import Budget as Budget
from .rounding_noise import StageNoise as StageNoise
from .rounding_noise import budget as budget
from .stage import Codes as Codes
from .stage import Stage as Stage
from .stage import TorqueScale as TorqueScale
from .stage import rate_from_current as rate_from_current
