"""R's .rda, .RData and .rds: matrices, data frames, time series and lists of them.

Their compression is removed by `packing`.
"""

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.readers.options import Options

from .contained import contained

TITLE = "R .rda, .RData and .rds (needs rdata)"

_MAGIC = (b"RDX2\nX\n", b"RDX3\nX\n", b"X\n\0\0\0\2", b"X\n\0\0\0\3")
_OTHER = (b"RDA2\n", b"RDA3\n", b"RDB2\n", b"RDB3\n")


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes are those of R's serialization."""
    return head.startswith(_MAGIC + _OTHER) or suffix in (".rda", ".rdata", ".rds")


def read(path: str, options: Options) -> Recording:
    """The channels of an R file; column names, ``freq`` and unit attributes are used if present."""
    with open(path, "rb") as file:
        head = file.read(8)
    if not head.startswith(_MAGIC):
        raise DataError(
            f"the file is not in R's binary format (it begins with {head!r}); write it again with save(x, "
            "file='x.rda') or saveRDS(x, 'x.rds')"
        )
    return contained("r", path, options)
