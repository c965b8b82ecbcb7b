"""Harmonic errors of angle sensors: of a gimbal, estimated in service, and of any encoder against a reference."""

from .calibration import Calibration as Calibration, estimate as estimate
from .encoder import calibrate as calibrate
from .geometry import Gimbals as Gimbals, gimbals as gimbals
from .harmonics import NUISANCES as NUISANCES, Harmonics as Harmonics, readings as readings, simulate as simulate
from .motion import Ring as Ring, Sway as Sway
from .plans import AnglePlan as AnglePlan, AngleSettings as AngleSettings, Scan as Scan, plan as plan, scan as scan
from .solve import Solution as Solution
