"""How numbers, units and names are written: two digits of the half width of an interval, and signs of print."""

import math
import re
from dataclasses import dataclass, field

from allanite.core.units import ATOMS, RAISED, plain_letters

LARGE, SMALL = 1e6, 1e-3
"""Sizes from and below which a power of ten is written."""


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

    def pretty(self) -> str:
        """Value and interval in print: ``9.02 (8.79 … 9.25) × 10⁻⁵``."""
        interval = f" ({self.low} … {self.high})" if self.low else ""
        return (self.value + interval).replace("-", "−") + self.power

    @property
    def power(self) -> str:
        """The power of ten in print, empty where it is 1."""
        return f" × 10{str(self.exponent).translate(RAISED)}" if self.exponent else ""


def digits(
    value: float, low: float = math.nan, high: float = math.nan, *, signed: bool = False, figures: int = 4
) -> Digits:
    """Round a value and its limits alike, to two significant digits of the half width.

    >>> digits(0.310213, 0.30217, 0.318712)
    Digits(value='0.3102', low='0.3022', high='0.3187', exponent=0)
    >>> digits(9.0241e-5, 8.79e-5, 9.251e-5).plain()
    ('9.02e-5', '8.79e-5 .. 9.25e-5')
    """
    if not math.isfinite(value):
        return Digits(f"{value}", "", "", 0)
    size = abs(value)
    known = math.isfinite(low) and math.isfinite(high)
    half = (high - low) / 2 if known else 0.0
    if known and low < 0 < high:
        size = max(size, half)  # of a number near zero the size of its interval counts
    exponent = _order(size) if size and not SMALL <= size < LARGE else 0
    decimals = exponent + (_decimals(size, half) if half > 0 else figures - 1 - _order(size) if size else 0)
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
    return math.floor(math.log10(size))


def _decimals(size: float, half: float) -> int:
    """Decimals that show two digits of the half width, and never fewer than two of the value itself."""
    # rounded first: a half width of 0.0996 is 0.10, and its two digits are hundredths
    wanted = 1 - _order(float(f"{half:.1e}"))
    return max(wanted, 1 - _order(size)) if size else wanted


_SIGN = re.compile(r"(?<![A-Za-z0-9\])])-(?=[\d.])")
_POWER = re.compile(r"(?<=\d)e([+-]?\d+)")
_ATOM = "|".join(sorted(ATOMS, key=len, reverse=True))
_FACTOR = (
    rf"(?:sqrt\((?:{_ATOM})\)|\([A-Za-z/^\d.]+\)|(?:{_ATOM})(?!\w))"
    r"(?:\^-?\d+(?:\.\d+)?)?"
)
_UNIT = re.compile(
    r"(?<!\w)'[^']*'(?!\w)|\"[^\"]*\"|(?<![\w-])--[\w-]+[ =]\S+"  # names, and what can be typed
    rf"|(?<![\w./^-])(?P<unit>(?:1/)?{_FACTOR}(?:[/*]{_FACTOR})*)"
)
_SIGNS = (
    (re.compile(r"sqrt\(([A-Za-z]+)\)"), r"√\1"),
    (re.compile(r"\bdeg(?=C?\b)"), "°"),
    (re.compile(r"\bu(?=(?:g|rad|A|V|T)\b)"), "µ"),
    (re.compile(r"\^(-?[\d.]+)"), lambda power: power[1].translate(RAISED)),
)
_ANGLE = re.compile(r"(?<=\d) °(?![/*C√²³])")
_ASCII: dict[str, str | int | None] = {
    "°": "deg", "√": "sqrt", "±": "+-", "≤": "<=", "≥": ">=", "≈": "~", "−": "-", "–": "-", "×": "x", "…": "..",
    "τ": "tau",
}  # fmt: skip
WRITTEN = "µ²³·⁵" + "".join(_ASCII)
"""Signs of results: an encoding that lacks one of them has ASCII instead."""


_ENDLESS = re.compile(r"\S{401,}")


def printable(text: str) -> str:
    """`text` without control characters; of a word of more than 400 characters both ends are left."""
    if not text.isprintable():  # otherwise a phrase stays one
        text = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    if len(text) <= 400 or not _ENDLESS.search(text):
        return text
    return _ENDLESS.sub(lambda found: f"{found[0][:60]}…{found[0][-60:]}", text)


def printed_unit(text: str) -> str:
    """A unit as it is shown, which `unit_of` reads as well, or a sentence with all of its units so.

    >>> printed_unit("deg/h/sqrt(h)"), printed_unit("ug"), printed_unit("rad/s^2.5"), printed_unit("(deg/h)^2/Hz")
    ('°/h/√h', 'µg', 'rad/s²·⁵', '(°/h)²/Hz')
    >>> printed_unit("below 0.1 deg at 3 deg/h; to change it, --unit deg/s")
    'below 0.1° at 3 °/h; to change it, --unit deg/s'
    """
    return _ANGLE.sub("°", _UNIT.sub(_with_signs, text))


def _with_signs(found: re.Match[str]) -> str:
    unit = found[0]
    for plain, sign in _SIGNS if found["unit"] else ():
        unit = plain.sub(sign, unit)
    return unit


def in_ascii(text: str) -> str:
    """A text for a terminal that has no signs: the signs of its units and numbers in ASCII.

    >>> in_ascii("±0.3° at 3 °/√h"), in_ascii("≤ 1.2 µg")
    ('+-0.3 deg at 3 deg/sqrt(h)', '<= 1.2 ug')
    """
    return plain_letters(re.sub(r"(?<=\d)°", " °", text)).translate(str.maketrans(_ASCII))


def printed_number(cell: str) -> str:
    """A number or interval as it is printed.

    >>> printed_number("-9.02e-5"), printed_number("-1 .. 2"), printed_number("+-5 V")
    ('−9.02 × 10⁻⁵', '−1 … 2', '±5 V')
    """
    cell = cell.replace("+-", "±").replace(" .. ", " … ")
    cell = _POWER.sub(lambda found: f" × 10{str(int(found[1])).translate(RAISED)}", cell)
    return _SIGN.sub("−", cell)


def printed(cell: str, kind: str) -> str:
    """A cell as it is printed, by the kind of its column; names are left as they are."""
    shown = with_units(printable(cell), kind)
    return printed_number(shown) if kind in ("number", "interval") else shown.replace(" .. ", " … ")


def with_units(cell: str, kind: str) -> str:
    """A cell with its units as they are printed; names are left as they are."""
    return printed_unit(cell) if kind in ("unit", "number", "interval") else cell


def printed_heading(heading: str) -> str:
    """A heading: the unit in its brackets as it is printed."""
    return re.sub(r"\[([^\[\]]*)\]", lambda found: f"[{printed_unit(found[1])}]", printable(heading))
