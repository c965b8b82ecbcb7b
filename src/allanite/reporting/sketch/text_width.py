"""How wide texts are, in the font that matplotlib comes with and browsers show in its place."""

from functools import cache
from pathlib import Path
from typing import Any

ABOVE, BELOW = 0.76, 0.24
"""Height of a line above and below its foot, sizes of the letters."""

FULL = 1.0
"""Width of a letter that the font does not have, sizes: Chinese ones are squares."""


@cache
def wide(text: str, *, bold: bool = False) -> float:
    """Width of a line of text, in sizes of its letters.

    Examples
    --------
    >>> 0.5 < wide("0") < 0.7, wide("00") == 2 * wide("0"), wide("0", bold=True) > wide("0")
    (True, True, True)
    """
    return sum(_letter(letter, bold) for letter in text)


@cache
def _letter(letter: str, bold: bool) -> float:
    font = _font(bold)
    if not font.get_char_index(ord(letter)):
        return FULL
    return float(font.load_char(ord(letter)).linearHoriAdvance) / 65536 / _SIZE


_SIZE = 100.0


@cache
def _font(bold: bool) -> Any:
    from matplotlib import get_data_path
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(Path(get_data_path(), "fonts", "ttf", f"DejaVuSans{'-Bold' if bold else ''}.ttf")))
    font.set_size(_SIZE, 72)
    return font
