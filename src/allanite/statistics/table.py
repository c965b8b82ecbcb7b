"""The table of statistics."""

from allanite.core.errors import UsageError

from .allan import ADEV, HAAR, OADEV
from .extremes import MTIE, TIERMS
from .hadamard import HDEV, OHDEV
from .modified import MDEV, TDEV
from .parabolic import PDEV
from .row import Statistic
from .theo import THEO1, THEOBR, THEOH
from .total import HTOTDEV, MTOTDEV, TOTDEV, TTOTDEV

STATISTICS: dict[str, Statistic] = {
    "adev": ADEV,
    "oadev": OADEV,
    "mdev": MDEV,
    "tdev": TDEV,
    "hdev": HDEV,
    "ohdev": OHDEV,
    "totdev": TOTDEV,
    "mtotdev": MTOTDEV,
    "ttotdev": TTOTDEV,
    "htotdev": HTOTDEV,
    "theo1": THEO1,
    "theobr": THEOBR,
    "theoh": THEOH,
    "pdev": PDEV,
    "haar": HAAR,
    "mtie": MTIE,
    "tierms": TIERMS,
}


def statistic_named(name: str) -> Statistic:
    """The row of `STATISTICS`; an unknown name is an error that lists the known ones."""
    if name not in STATISTICS:
        raise UsageError(f"unknown statistic {name!r}; known are {', '.join(STATISTICS)}")
    return STATISTICS[name]
