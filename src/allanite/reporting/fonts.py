"""Fonts for languages whose letters the font of matplotlib does not have."""

import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from .language import ENGLISH

OWN = "DejaVu Sans"  # the font that comes with matplotlib; it has Latin, Greek and Cyrillic letters
ON_PAGE = "'DejaVu Sans',Verdana,sans-serif"  # the fonts of a page; Verdana has the same widths

FURTHER: dict[str, dict[str, str]] = {
    "zh": {
        "Noto Sans CJK SC": "noto *sans *cjk|noto *sans *sc",
        "Noto Sans SC": "noto *sans *sc",
        "Source Han Sans SC": "source *han *sans",
        "Source Han Sans CN": "source *han *sans",
        "Microsoft YaHei": "msyh",
        "PingFang SC": "pingfang",
        "Hiragino Sans GB": "hiragino *sans *gb",
        "SimHei": "simhei",
        "WenQuanYi Zen Hei": "wqy-zenhei",
        "WenQuanYi Micro Hei": "wqy-microhei",
        "Noto Sans CJK JP": "noto *sans *cjk",  # the first of the collection, which old versions of matplotlib read
        "Arial Unicode MS": "arial *unicode",
    }
}
"""By language, families with its letters, best first, and what the names of their files look like."""


class FontWarning(UserWarning):
    """No font of this machine has the letters of a language; the message says which to install."""


def families(lang: str) -> list[str]:
    """The fonts of a figure in this language; letters that the first does not have are taken from the next."""
    return [OWN, *filter(None, [further(lang)])]


@cache
def further(lang: str) -> str:
    """The family with the letters of a language that this machine has; empty if it has none, or needs none."""
    from matplotlib.font_manager import findSystemFonts, fontManager

    wanted = FURTHER.get(lang, {})
    if wanted and not any(font.name in wanted for font in fontManager.ttflist):
        # matplotlib's list is as old as its first use: a font that was installed later is not in it
        for path in sorted(findSystemFonts()):
            if re.search("|".join(wanted.values()), Path(path).stem, re.IGNORECASE):
                fontManager.addfont(path)
    installed = {font.name for font in fontManager.ttflist}
    return next((name for name in wanted if name in installed), "")


def missing(lang: str) -> str:
    """What to install for the letters of a language; empty if nothing is missing."""
    if lang not in FURTHER or further(lang):
        return ""
    first, second, *_ = FURTHER[lang]
    return f"no font of this machine has the letters of {lang!r}: install {first}, {second} or another of its fonts"


def warn_of_page(lang: str) -> None:
    """Warn where the letters on a page are left to the browser alone."""
    lacking = missing(lang)
    if lacking:
        message = f"the words in the figures of the page may overlap: their widths are guessed, because {lacking}"
        warnings.warn(message, FontWarning, stacklevel=3)


def drawn_in(lang: str) -> str:
    """The language of a figure for print: as wanted, or English, with a warning, where its letters would be boxes."""
    lacking = missing(lang)
    if lacking:
        warnings.warn(f"the figure is in English, because {lacking}", FontWarning, stacklevel=3)
    return ENGLISH if lacking else lang


@contextmanager
def quiet(lang: str) -> Iterator[None]:
    """No complaints of matplotlib about a weight that a fallback does not have."""
    log = logging.getLogger("matplotlib.font_manager")
    before = log.level
    if further(lang):
        log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(before)
