"""From raw signals to a rate, and what their rounding adds to its noise."""

from .budget import Budget as Budget
from .budget import StageNoise as StageNoise
from .budget import budget as budget
from .codes import Codes as Codes
from .stage import Stage as Stage
from .torque import TorqueScale as TorqueScale
from .torque import rate_from_current as rate_from_current
