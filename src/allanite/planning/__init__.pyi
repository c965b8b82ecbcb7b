from .bound import Bound as Bound
from .datasheets import DATASHEETS as DATASHEETS
from .datasheets import SENSORS as SENSORS
from .datasheets import DataSheet as DataSheet
from .datasheets import data_sheet_named as data_sheet_named
from .plan import RecordingPlan as RecordingPlan
from .selfcheck import SelfCheck as SelfCheck
