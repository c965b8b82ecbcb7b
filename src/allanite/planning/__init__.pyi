from .bound import Bound as Bound
from .datasheets import (
    DATASHEETS as DATASHEETS,
    SENSORS as SENSORS,
    DataSheet as DataSheet,
    data_sheet_named as data_sheet_named,
)
from .plan import RecordingPlan as RecordingPlan
from .selfcheck import SelfCheck as SelfCheck
