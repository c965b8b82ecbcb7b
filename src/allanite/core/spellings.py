"""Spellings of units: words, signs, and Russian and Chinese names."""

import re

SPELLINGS: dict[str, str] = {
    "°": "deg", "º": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad",
    "sec": "s", "second": "s", "seconds": "s", "hr": "h", "hrs": "h", "hour": "h", "hours": "h",
    "asec": "arcsec", "as": "arcsec", "micro_g": "ug",
    "dps": "(deg/s)", "mdps": "(mdeg/s)", "dph": "(deg/h)", "rps": "(rad/s)", "mps": "(m/s)",
    "°C": "degC", "ºC": "degC", "degc": "degC", "celsius": "degC", "kelvin": "K", "ampere": "A", "volt": "V",
    "tesla": "T",
}  # fmt: skip

SIGNS = {"√(": "sqrt(", "µ": "u", "μ": "u", "·": "*"}
"""Signs of units that are no words."""

RAISED = str.maketrans("-.0123456789", "⁻·⁰¹²³⁴⁵⁶⁷⁸⁹")
"""How the letters of a power are printed."""

_LOWERED = {chr(raised): chr(letter) for letter, raised in RAISED.items()}
_RAISED = re.compile("⁻?[⁰¹²³⁴-⁹]+(?:·[⁰¹²³⁴-⁹]+)?")
_ROOT = re.compile(r"√([A-Za-z]+)")

WORDS: dict[str, str] = {
    "угл. сек": "arcsec", "угл.сек": "arcsec", "угл. с": "arcsec", "угл.с": "arcsec", "рад": "rad", "мрад": "mrad",
    "мкрад": "urad", "град": "deg", "°С": "degC", "с": "s", "сек": "s", "мс": "ms", "мкс": "us", "нс": "ns",
    "мин": "min", "ч": "h", "час": "h", "м": "m", "см": "cm", "мм": "mm", "Гц": "Hz", "мg": "mg", "мкg": "ug",
    "弧度": "rad", "毫弧度": "mrad", "度": "deg", "毫度": "mdeg", "角分": "arcmin", "角秒": "arcsec", "秒": "s",
    "毫秒": "ms", "微秒": "us", "纳秒": "ns", "分钟": "min", "小时": "h", "时": "h", "米": "m", "毫g": "mg",
    "微g": "ug", "赫兹": "Hz", "赫": "Hz", "摄氏度": "degC", "℃": "degC", "每": "/", "平方": "^2",
}  # fmt: skip
"""Russian and Chinese words of units. Grams are not among them: мг is a mass, an acceleration is in мg."""

_LETTER = r"[^\W\d_²³]"
_WORD = re.compile(
    "|".join(
        # Chinese writes words without blanks, and a Cyrillic word ends where its letters end
        re.escape(word) if ord(word[0]) > 0x2E00 or word == "℃" else rf"(?<!{_LETTER}){re.escape(word)}(?!{_LETTER})"
        for word in sorted(WORDS, key=len, reverse=True)
    )
)


def latin(text: str) -> str:
    """A unit with its Russian and Chinese words in their Latin spelling; any other text is unchanged.

    Examples
    --------
    >>> latin("°/ч"), latin("弧度/秒"), latin("м/с²"), latin("deg/s")
    ('°/h', 'rad/s', 'm/s²', 'deg/s')
    """
    return text if text.isascii() else _WORD.sub(lambda found: WORDS[found[0]], text)


def plain_letters(text: str) -> str:
    """A text with the signs of its units in ASCII; the sign of degrees, which is a word, is unchanged.

    Examples
    --------
    >>> plain_letters("µg/√Hz"), plain_letters("rad/s²·⁵"), plain_letters("V·√s"), plain_letters("s⁻¹")
    ('ug/sqrt(Hz)', 'rad/s^2.5', 'V*sqrt(s)', 's^-1')
    """
    if text.isascii():
        return text
    text = _ROOT.sub(r"sqrt(\1)", text)
    text = _RAISED.sub(lambda found: "^" + "".join(_LOWERED[letter] for letter in found[0]), text)
    for sign, word in SIGNS.items():
        text = text.replace(sign, word)
    return text
