"""From raw signals to a rate, and the noise that quantization adds to it."""

from .budgeting import PathSettings as PathSettings, budget_file as budget_file, mixed as mixed
from .rounding_noise import Budget as Budget, StageNoise as StageNoise, budget as budget
from .stage import Codes as Codes, Stage as Stage, TorqueScale as TorqueScale, rate_from_current as rate_from_current
