"""The records of published numbers, by the rules that make them, and who is asked: the referee and the package."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tests.reference import REFEREES
from tests.reference.terms import phase

import allanite as al

FOLDER = Path(__file__).parent / "data"
WHO = ["referee", "allanite"]

COSTLY = ("mdev", "tdev", "mtie")  # referees whose cost is the number of points times m; MOST bounds it

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


def lcg(count=1000):
    """Numbers of NIST SP 1065: n_0 = 1234567890, n_{i+1} = 16807 n_i mod 2147483647; n / 2147483647."""
    n, values = 1234567890, []
    for _ in range(count):
        values.append(n / 2147483647)
        n = 16807 * n % 2147483647
    return np.array(values)


def flicker(white):
    """White noise through N. J. Kasdin's filter of flicker noise (Proc. IEEE 83, 1995, p. 802), summed exactly."""
    h = np.cumprod([1.0, *((k - 0.5) / k for k in range(1, len(white)))])
    return np.array([math.fsum(h[: k + 1] * white[k::-1]) for k in range(len(white))])


def printed(file):
    """Tables of a file of published values: words before the values of a line, and (averaging factor, value, more)."""
    for line in (FOLDER / file).read_text("utf-8").splitlines():
        words = line.split()
        if line.startswith("#"):
            continue
        cells = [word.split(":") for word in words if ":" in word]
        yield tuple(word for word in words if ":" not in word), [(int(m), *rest) for m, *rest in cells]


def value(who, name, data, m):
    """Deviations at the averaging factors m, plain definition."""
    if who == "referee":
        return np.array([float(REFEREES[name](data.x, int(k), data.tau0)) for k in m]) ** 0.5
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
