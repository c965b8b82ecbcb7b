from .batch import Batch as Batch
from .job import analyze_files as analyze_files, run_batch as run_batch
from .lot import Lot as Lot, read_lot as read_lot
from .specification import Specification as Specification
