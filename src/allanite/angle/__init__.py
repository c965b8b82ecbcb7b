"""Harmonic errors of angle sensors: of a gimbal's, estimated in service, and of any encoder against a reference."""

from .design import NUISANCES as NUISANCES
from .encoder import calibrate as calibrate
from .estimate import Calibration as Calibration
from .estimate import estimate as estimate
from .gimbals import Gimbals as Gimbals
from .gimbals import Sway as Sway
from .gimbals import gimbals as gimbals
from .harmonics import Harmonics as Harmonics
from .plan import Plan as Plan
from .plan import Scan as Scan
from .plan import plan as plan
from .plan import scan as scan
from .simulate import readings as readings
from .simulate import simulate as simulate
from .solution import Solution as Solution
