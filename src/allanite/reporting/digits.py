"""How numbers, units and names are written: signs of print, and ASCII for terminals that have none."""

import re

from allanite.core.digits import digits as digits, rounded as rounded, upper_limit as upper_limit  # noqa: PLC0414
from allanite.core.units import ATOMS, RAISED, plain_letters
from allanite.phrases.phrase import visible

_SIGN = re.compile(r"(?<![A-Za-z0-9\])])-(?=[\d.])")
_POWER = re.compile(r"(?<=\d)e([+-]?\d+)")
_ATOM = "|".join(sorted(ATOMS, key=len, reverse=True))
_FACTOR = rf"(?:sqrt\((?:{_ATOM})\)|\([A-Za-z/^\d.]+\)|(?:{_ATOM})(?!\w))(?:\^-?\d+(?:\.\d+)?)?"
_UNIT = re.compile(
    r"(?<!\w)'[^']*'(?!\w)|\"[^\"]*\"|(?<![\w-])--[\w-]+[ =]\S+"  # names, and what can be typed
    rf"|(?<![\w./^-])(?P<unit>(?:1/)?{_FACTOR}(?:[/*]{_FACTOR})*)"
)
_SIGNS = (
    (re.compile(r"sqrt\(([A-Za-z]+)\)"), r"√\1"), (re.compile(r"\bdeg(?=C?\b)"), "°"),
    (re.compile(r"\bu(?=(?:g|rad|A|V|T)\b)"), "µ"),
    (re.compile(r"\^(-?[\d.]+)"), lambda power: power[1].translate(RAISED)),
)  # fmt: skip
_BARE = re.compile(r"[-+\d.,e ()]*")  # numbers, which have no unit
_ANGLE = re.compile(r"(?<=\d) °(?![/*C√²³])")
_ASCII: dict[str, str | int | None] = {"°": "deg", "√": "sqrt", "±": "+-", "≤": "<=", "≥": ">=", "≈": "~", "−": "-",
    "–": "-", "×": "x", "…": "..", "τ": "tau", "↓": "falling"}  # fmt: skip
WRITTEN = "µ²³·⁵" + "".join(_ASCII)  # signs of results: an encoding that lacks one of them has ASCII instead

_ENDLESS = re.compile(r"\S{401,}")


def printable(text: str) -> str:
    """`text` without control characters; of a word of more than 400 characters both ends are left."""
    text = visible(text)
    if len(text) <= 400 or not _ENDLESS.search(text):
        return text
    return _ENDLESS.sub(lambda found: f"{found[0][:60]}…{found[0][-60:]}", text)


def printed_unit(text: str) -> str:
    """A unit as it is shown, which `unit_of` reads as well, or a sentence with all of its units so."""
    return text if _BARE.fullmatch(text) else _ANGLE.sub("°", _UNIT.sub(_with_signs, text))


def _with_signs(found: re.Match[str]) -> str:
    unit = found[0]
    for plain, sign in _SIGNS if found["unit"] else ():
        unit = plain.sub(sign, unit)
    return unit


def in_ascii(text: str) -> str:
    """A text for a terminal that has no signs: the signs of its units and numbers in ASCII."""
    return plain_letters(re.sub(r"(?<=\d)°", " °", text)).translate(str.maketrans(_ASCII))


def printed_number(cell: str) -> str:
    """A number or interval as it is printed."""
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
