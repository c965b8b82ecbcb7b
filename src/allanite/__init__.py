"""allanite: what the random errors of gyroscopes and accelerometers are made of."""

from typing import TYPE_CHECKING, Any

from .curve import Curve as Curve
from .errors import AllaniteError as AllaniteError
from .errors import DataError as DataError
from .errors import LongJobWarning as LongJobWarning
from .errors import UnitError as UnitError
from .errors import UsageError as UsageError
from .model import GM as GM
from .model import B as B
from .model import K as K
from .model import Model as Model
from .model import N as N
from .model import Q as Q
from .model import R as R
from .model import Sine as Sine
from .model import Term as Term
from .record import Record as Record
from .record import Recording as Recording
from .report import plot as plot
from .report import report as report
from .simulate import simulate as simulate
from .terms import TERMS as TERMS
from .version import __version__ as __version__

if TYPE_CHECKING:
    from . import angle as angle
    from . import compensation as compensation
    from . import faults as faults
    from . import rate as rate
    from .comparing import compare as compare
    from .comparison import Comparison as Comparison
    from .compensation import Regression as Regression
    from .compensation import compensate as compensate
    from .compensation_study import CompensationChoices as CompensationChoices
    from .compensation_study import compensate_file as compensate_file
    from .correction import Correction as Correction
    from .fit import Estimate as Estimate
    from .fit import Fit as Fit
    from .noise import METHODS as METHODS
    from .noise import identify as identify
    from .noise.bound import Bound as Bound
    from .noise.bound import bound as bound
    from .noise.plan import RecordingPlan as RecordingPlan
    from .noise.plan import plan as plan
    from .noise.residuals import residuals as residuals
    from .noise.selfcheck import SelfCheck as SelfCheck
    from .noise.selfcheck import selfcheck as selfcheck
    from .noise.shared import shared as shared
    from .noise.whitening import whitened as whitened
    from .notation import parse_model as parse_model
    from .pooled import Pool as Pool
    from .pooling import pool as pool
    from .pooling import truncation as truncation
    from .psd import Spectrum as Spectrum
    from .rate_study import measure_rates as measure_rates
    from .readers import read as read
    from .readers import write as write
    from .ring_laser import GL1 as GL1
    from .ring_laser import RingLaser as RingLaser
    from .ring_laser import simulate_ring_laser as simulate_ring_laser
    from .sensors import SENSORS as SENSORS
    from .sensors import sensor as sensor
    from .signals import Budget as Budget
    from .signals import Stage as Stage
    from .signals import TorqueScale as TorqueScale
    from .signals import budget as budget
    from .signals import rate_from_current as rate_from_current
    from .signals_study import SignalPath as SignalPath
    from .signals_study import budget_file as budget_file
    from .statespace import StateSpace as StateSpace
    from .statespace import state_space as state_space
    from .statistics import STATISTICS as STATISTICS
    from .statistics import deviation as deviation
    from .statistics import expected as expected
    from .statistics.dynamic import dynamic as dynamic
    from .statistics.multitaper import Multitaper as Multitaper
    from .statistics.spectrum import spectrum as spectrum
    from .statistics.stability import averaging_stability as averaging_stability
    from .statistics.stability import minimum as minimum
    from .statistics.welch import Welch as Welch
    from .study import Recipe as Recipe
    from .study import Study as Study
    from .study import analyze as analyze
    from .surface import Surface as Surface
    from .whiteness import Residuals as Residuals
    from .whiteness import Shared as Shared

_ROOMS = ("noise", "prepare", "readers", "statistics", "study")

_LATER = {room: f".{room}" for room in _ROOMS} | {
    "angle": ".angle",
    "compensation": ".compensation",
    "faults": ".faults",
    "rate": ".rate",
    "compare": ".comparing",
    "Comparison": ".comparison",
    "Regression": ".compensation",
    "compensate": ".compensation",
    "CompensationChoices": ".compensation_study",
    "compensate_file": ".compensation_study",
    "Correction": ".correction",
    "Estimate": ".fit",
    "Fit": ".fit",
    "METHODS": ".noise",
    "identify": ".noise",
    "Bound": ".noise.bound",
    "bound": ".noise.bound",
    "RecordingPlan": ".noise.plan",
    "plan": ".noise.plan",
    "residuals": ".noise.residuals",
    "SelfCheck": ".noise.selfcheck",
    "selfcheck": ".noise.selfcheck",
    "shared": ".noise.shared",
    "whitened": ".noise.whitening",
    "parse_model": ".notation",
    "Pool": ".pooled",
    "pool": ".pooling",
    "truncation": ".pooling",
    "Spectrum": ".psd",
    "measure_rates": ".rate_study",
    "read": ".readers",
    "write": ".readers",
    "GL1": ".ring_laser",
    "RingLaser": ".ring_laser",
    "simulate_ring_laser": ".ring_laser",
    "SENSORS": ".sensors",
    "sensor": ".sensors",
    "Budget": ".signals",
    "Stage": ".signals",
    "TorqueScale": ".signals",
    "budget": ".signals",
    "rate_from_current": ".signals",
    "SignalPath": ".signals_study",
    "budget_file": ".signals_study",
    "StateSpace": ".statespace",
    "state_space": ".statespace",
    "STATISTICS": ".statistics",
    "deviation": ".statistics",
    "expected": ".statistics",
    "dynamic": ".statistics.dynamic",
    "Multitaper": ".statistics.multitaper",
    "spectrum": ".statistics.spectrum",
    "averaging_stability": ".statistics.stability",
    "minimum": ".statistics.stability",
    "Welch": ".statistics.welch",
    "Recipe": ".study",
    "Study": ".study",
    "analyze": ".study",
    "Surface": ".surface",
    "Residuals": ".whiteness",
    "Shared": ".whiteness",
}
"""Names that are imported when first asked for, and the modules they are in: the program starts without them."""


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'allanite' has no attribute {name!r}")
    from importlib import import_module

    module = import_module(_LATER[name], __name__)
    globals()[name] = module if _LATER[name] == f".{name}" else getattr(module, name)
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATER} - {"TYPE_CHECKING", "Any"})
