"""How numbers are rounded, everywhere: to two digits of the half width of their interval."""

import math
from dataclasses import dataclass, field

from .units import RAISED

LARGE, SMALL = 1e6, 1e-3  # sizes from and below which a power of ten is written
FUZZ = 1e-9  # of a limit that is rounded up: one that has two digits keeps them


@dataclass(frozen=True)
class Digits:
    """A number, its limits and their half width as text, with the same decimals, in units of 10^exponent."""

    value: str
    # empty where there is no interval
    low: str
    high: str
    exponent: int = 0
    half: str = field(default="", repr=False)

    def plain(self) -> tuple[str, str]:
        """Value and interval in ASCII, for the terminal: ``("9.02e-5", "8.79e-5 .. 9.25e-5")``."""
        power = f"e{self.exponent}" if self.exponent else ""
        interval = f"{self.low}{power} .. {self.high}{power}" if self.low else ""
        return self.value + power, interval

    def words(self) -> str:
        """Value and interval in ASCII, in one text: ``9.02e-5 (8.79e-5 .. 9.25e-5)``."""
        value, interval = self.plain()
        return f"{value} ({interval})" if interval else value

    def pretty(self) -> str:
        """Value and interval in print: ``9.02 (8.79 … 9.25) × 10⁻⁵``."""
        interval = f" ({self.low} … {self.high})" if self.low else ""
        return (self.value + interval).replace("-", "−") + self.power

    @property
    def power(self) -> str:
        """The power of ten in print, empty where it is 1."""
        return f" × 10{str(self.exponent).translate(RAISED)}" if self.exponent else ""


def upper_limit(value: float) -> Digits:
    """An upper limit with two digits, rounded up: the one that is shown holds, too."""
    if not (math.isfinite(value) and value > 0):
        return digits(value, figures=2)
    last = 10.0 ** (_order(value) - 1)
    return digits(math.ceil(value / last * (1 - FUZZ)) * last, figures=2)


def digits(value: float, low: float = math.nan, high: float = math.nan, *, signed: bool = False,
           figures: int = 4) -> Digits:  # fmt: skip
    """Round a value and its limits alike, to two significant digits of the half width."""
    if not math.isfinite(value):
        return Digits(f"{value}", "", "", 0)
    size = abs(value)
    known = math.isfinite(low) and math.isfinite(high)
    half = (high - low) / 2 if known else 0.0
    if known and low < 0 < high:
        size = max(size, half)  # of a number near zero the size of its interval counts
    exponent = _order(size) if size and not SMALL <= size < LARGE else 0
    wanted = figures - 1 - _order(float(f"{size:.{figures - 1}e}")) if size else 0
    if half > 0:  # two digits of it, rounded first: those of 0.0996 are 0.10; and never fewer than two of the value
        wanted = 1 - _order(float(f"{half:.1e}"))
        wanted = max(wanted, 1 - _order(size)) if size else wanted
    decimals = exponent + wanted
    places = f".{min(max(decimals, 0), 12)}f"
    scaled = [v / 10.0**exponent for v in ((value, low, high) if known else (value,))]
    sign = "+" if signed else ""
    shown = [format(round(v, decimals) + 0.0, sign + places) for v in scaled]  # no negative zero
    least, most = shown[1:] or ("", "")
    return Digits(shown[0], least, most, exponent, format(half / 10.0**exponent, places) if known else "")


def rounded(value: float) -> str:
    """A number without an interval as text, to four digits; empty where there is none."""
    return digits(value).plain()[0] if math.isfinite(value) else ""


def _order(size: float) -> int:
    return max(math.floor(math.log10(size)), -300)  # ten to this power is no zero
