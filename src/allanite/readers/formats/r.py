"""R's .rda, .RData and .rds: matrices, data frames, time series and lists of them.

Their compression is removed by `packing`.
"""

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.readers.options import Options

from .contained import contained
from .registry import R_BINARY

TITLE = "R .rda, .RData and .rds (needs rdata)"


def read(path: str, options: Options) -> Recording:
    """The channels of an R file; column names, ``freq`` and unit attributes are used if present."""
    with open(path, "rb") as file:
        head = file.read(8)
    if not head.startswith(R_BINARY):
        raise DataError(f"the file is not in R's binary format (it begins with {head!r}); write it again with save(x, "
                        "file='x.rda') or saveRDS(x, 'x.rds')")  # fmt: skip
    return contained("r", path, options)
