"""Harmonic errors of angle sensors: of a gimbal, estimated in service, and of any encoder against a reference."""

from .calibration import Calibration as Calibration
from .calibration import estimate as estimate
from .encoder import calibrate as calibrate
from .geometry import Gimbals as Gimbals
from .geometry import gimbals as gimbals
from .harmonics import NUISANCES as NUISANCES
from .harmonics import Harmonics as Harmonics
from .harmonics import readings as readings
from .harmonics import simulate as simulate
from .motion import Ring as Ring
from .motion import Sway as Sway
from .plans import AnglePlan as AnglePlan
from .plans import AngleSettings as AngleSettings
from .plans import Scan as Scan
from .plans import plan as plan
from .plans import scan as scan
from .solve import Solution as Solution
