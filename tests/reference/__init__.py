"""Every statistic as its source prints it: slow, literal, `name(x, m, tau0)` -> squared deviation.

x holds the N + 1 points of the phase (angle), float64 or longdouble; a referee raises UndefinedError where it has no
term.
"""

from tests.reference.allan import adev, oadev
from tests.reference.hadamard import hdev, ohdev
from tests.reference.interval import mtie, tierms
from tests.reference.modified import mdev, tdev
from tests.reference.parabolic import pdev
from tests.reference.terms import UndefinedError
from tests.reference.theo import theo1, theobr, theoh
from tests.reference.total import htotdev, mtotdev, totdev, ttotdev
from tests.reference.wavelet import haar

REFEREES = {"adev": adev, "oadev": oadev, "mdev": mdev, "tdev": tdev, "hdev": hdev, "ohdev": ohdev, "totdev": totdev,
            "mtotdev": mtotdev, "ttotdev": ttotdev, "htotdev": htotdev, "theo1": theo1, "theobr": theobr,
            "theoh": theoh, "pdev": pdev, "mtie": mtie, "tierms": tierms, "haar": haar}  # fmt: skip


def factors(name, n):
    """Every m at which the referee is defined for n intervals, found by trying; none if there is no such m."""
    import numpy as np

    x = np.arange(n + 1.0) ** 2 + np.sin(np.arange(n + 1))
    return [m for m in range(1, n + 2) if _defined(REFEREES[name], x, m)]


def largest(name, n):
    """The largest m at which the referee is defined for n intervals, 0 if there is none."""
    return max(factors(name, n), default=0)


def _defined(referee, x, m):
    try:
        referee(x, m, 1.0)
    except UndefinedError:
        return False
    return True
