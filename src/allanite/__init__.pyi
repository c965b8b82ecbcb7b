from . import (
    batch as batch,
    claims as claims,
    comparison as comparison,
    exporting as exporting,
    identification as identification,
    interpretation as interpretation,
    planning as planning,
    prepare as prepare,
    simulation as simulation,
    statistics as statistics,
    terms as terms,
    testing as testing,
)
from .applications import (
    angle as angle,
    attitude as attitude,
    compensation as compensation,
    constant_rate as constant_rate,
    signals as signals,
)
from .applications.compensation import compensate as compensate
from .claims.checking import check as check
from .claims.drift import Drift as Drift
from .claims.drifting import drift as drift
from .comparison.comparing import compare as compare
from .comparison.comparison import Comparison as Comparison
from .core.curve import Curve as Curve
from .core.errors import (
    AllaniteError as AllaniteError,
    DataError as DataError,
    UnitError as UnitError,
    UsageError as UsageError,
)
from .core.estimate import Estimate as Estimate
from .core.fit import Fit as Fit
from .core.model import GM as GM, B as B, K as K, Model as Model, N as N, Q as Q, R as R, Term as Term
from .core.plain import from_dict as from_dict
from .core.record import Record as Record, Recording as Recording
from .core.spectrum import Spectrum as Spectrum
from .core.version import __version__ as __version__
from .exporting.export import Export as Export, export as export
from .exporting.imported import read_noise as read_noise
from .identification import identify as identify
from .identification.checks.residuals import residuals as residuals
from .identification.checks.whitening import shared as shared, whitened as whitened
from .planning.bound import bound as bound
from .planning.datasheets import sensor as sensor
from .planning.plan import plan as plan
from .planning.selfcheck import selfcheck as selfcheck
from .readers import read as read, write as write
from .reporting import plot as plot, report as report
from .simulation.record import simulate as simulate
from .statespace import StateSpace as StateSpace, state_space as state_space
from .statistics import expected as expected
from .statistics.dynamic import dynamic as dynamic
from .statistics.readings import averaging_stability as averaging_stability, minimum as minimum, readings as readings
from .statistics.spectra.estimators import Multitaper as Multitaper, Welch as Welch
from .statistics.spectra.spectrum import deviation_of_spectrum as deviation_of_spectrum, spectrum as spectrum
from .stream.accumulator import Accumulator as Accumulator
from .study.analysis import analyze as analyze
from .study.curves import deviation as deviation
from .study.recipe import Recipe as Recipe
from .study.results import Study as Study
