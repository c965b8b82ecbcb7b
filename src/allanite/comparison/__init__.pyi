from .comparing import pool as pool, truncation as truncation
from .pooled import Pool as Pool
from .sheet import SheetComparison as SheetComparison, compare_with_sheet as compare_with_sheet
