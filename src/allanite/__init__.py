"""allanite: what the random errors of gyroscopes and accelerometers are made of."""

from .curve import Curve as Curve
from .errors import AllaniteError as AllaniteError
from .errors import DataError as DataError
from .errors import UnitError as UnitError
from .errors import UsageError as UsageError
from .fit import Estimate as Estimate
from .fit import Fit as Fit
from .model import B as B
from .model import K as K
from .model import Model as Model
from .model import N as N
from .model import Q as Q
from .model import R as R
from .model import Term as Term
from .noise import METHODS as METHODS
from .noise import identify as identify
from .readers import read as read
from .record import Record as Record
from .record import Recording as Recording
from .report import plot as plot
from .report import report as report
from .simulate import simulate as simulate
from .statistics import STATISTICS as STATISTICS
from .statistics import deviation as deviation
from .statistics import expected as expected
from .study import Recipe as Recipe
from .study import Study as Study
from .study import analyze as analyze
from .terms import TERMS as TERMS

__version__ = "0.1.0.dev0"
