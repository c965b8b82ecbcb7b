from .comparing import pool as pool
from .comparing import truncation as truncation
from .pooled import Pool as Pool
from .sheet import SheetComparison as SheetComparison
from .sheet import compare_with_sheet as compare_with_sheet
