"""Who is asked for a published number: the referee, and the package once it has the statistic."""

from dataclasses import dataclass

import numpy as np
import pytest
from tests.reference import REFEREES
from tests.reference.terms import phase

import allanite as al
from allanite.statistics import STATISTICS

WHO = ["referee", "allanite"]

COSTLY = ("mdev", "tdev", "mtie")
"""Referees whose cost is the number of points times m; MOST bounds it."""

MOST = 1e9


@dataclass(frozen=True, eq=False)
class Data:
    """A published record: its rate y where that was published, else its phase x."""

    tau0: float
    x: np.ndarray
    y: np.ndarray | None = None

    @classmethod
    def of_rate(cls, y, tau0=1.0):
        y = np.asarray(y)
        return cls(tau0, phase(y, tau0), y)


def value(who, name, data, m):
    """Deviations at the averaging factors m, plain definition."""
    if who == "referee":
        return np.array([float(REFEREES[name](data.x, int(k), data.tau0)) for k in m]) ** 0.5
    if name not in STATISTICS:
        pytest.skip(f"no {name} in STATISTICS")
    if data.y is None:
        record = al.Record(data.x.astype(float), rate=1 / data.tau0, unit="s", kind="angle")
    else:
        record = al.Record(data.y.astype(float), rate=1 / data.tau0, unit="1", kind="rate")
    return al.deviation(record, name, m=[int(k) for k in m]).deviation


def affordable(who, name, data, m):
    """Whether this row of a table is asked for: every one of the package, of the referee those that end today."""
    return who == "allanite" or name not in COSTLY or len(data.x) * m <= MOST


SINGLE = 2.0**-24
"""Six of some 2700 published numbers lie beyond half a unit, by at most 2.3e-8: constants in single precision."""


def disagreements(found, printed):
    """The pairs that differ by more than half a unit of the last printed digit and a rounding to single precision."""
    return [pair for pair in zip(found, printed, strict=True) if not _agree(*pair)]


def _agree(found, printed):
    mantissa, _, exponent = printed.lower().partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(found - float(printed)) <= 0.5 * unit + SINGLE * found
