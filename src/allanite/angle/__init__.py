"""Harmonic errors of angle sensors: of a gimbal's, estimated in service, and of any encoder against a reference."""

from .design import NUISANCES as NUISANCES
from .encoder import calibrate as calibrate
from .estimate import Calibration as Calibration
from .estimate import estimate as estimate
from .gimbals import Gimbals as Gimbals
from .gimbals import gimbals as gimbals
from .harmonics import Harmonics as Harmonics
from .plan import Plan as Plan
from .plan import plan as plan
from .scan import Scan as Scan
from .scan import scan as scan
from .simulate import readings as readings
from .simulate import simulate as simulate
from .solution import Solution as Solution
from .sway import Sway as Sway
