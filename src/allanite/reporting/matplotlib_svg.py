"""Figures for the middle of a page: small, with names of their own, in colors that follow the ground of the page."""

import re
import warnings
from collections.abc import Callable
from functools import cache
from itertools import count
from pathlib import Path

from markupsafe import Markup

from .digits import printable
from .fonts import ON_PAGE
from .language import tr
from .sheet import Drawing, Picture
from .sketch.axis import Unsketched
from .style import DARK, Figure


def variable(color: str) -> str:
    """The name of a color in the style sheet of a page."""
    return f"--{color.lower().lstrip('#')}"


PHONE_INCHES = 3.9  # inches of a figure on a phone: 8 points are 10 pixels where it is 357 pixels wide


def within(shown: Picture, prefix: str, label: str) -> Markup:
    """A figure whose names begin with `prefix`, so that figures do not share parts by mistake, with words for it."""
    text = shown.text
    for before in (' id="', 'href="#', "url(#"):
        text = text.replace(before, f"{before}{prefix}-")
    label = str(Markup.escape(printable(tr(label))))
    start = f'<svg role="img" aria-label="{label}" style="--wide: {shown.wide:.0f}" stroke-linejoin="round" '
    # matplotlib escapes the text in a figure
    return Markup(text.replace("<svg ", start, 1))  # noqa: S704


def drawn(drawing: Drawing) -> Picture:
    """The figure of a page, by `sketch` or else by matplotlib."""
    plot = drawing.draw()
    if isinstance(plot, Picture):
        return plot
    try:
        broad, narrow = plot.sketched(), plot.sketched(PHONE_INCHES)
        return Picture(broad.svg(), broad.width, Picture(narrow.svg(), narrow.width))
    except Unsketched:
        from .printing import printed

        return picture(printed(plot))


def picture(figure: Figure) -> Picture:
    """A figure with its letters as text and without what nobody sees."""
    from .printing import encode

    with warnings.catch_warnings():
        # the browser has the letters that are missing here
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        text = encode(figure, "svg", text=True).decode()
    return trimmed(text, figure.get_figwidth() * 72)


def stored(path: Path) -> Picture:
    """A figure that a command has written as SVG."""
    text = path.read_text("utf-8")
    return trimmed(text, float(re.search(r'width="([\d.]+)pt"', text)[1]))  # type: ignore[index]  # as we write it


def trimmed(text: str, wide: float) -> Picture:
    """A figure without what nobody sees."""
    text = text[text.index("<svg") :].rstrip()
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->|<style.*?</style>", "", text, flags=re.DOTALL)
    text = text.replace("xlink:href", "href")
    text = re.sub(r"'DejaVu Sans'(?:, '[^']*')?", ON_PAGE, text)  # of further fonts the reader's browser knows better
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", text)
    return Picture(text, wide)


_STYLE_ATTRIBUTE = re.compile(r'style="([^"]*)"')
_SCROLLED = ' tabindex="0"'  # a figure without a narrow form is scrolled on a narrow screen, by keys too


def drawer(place: str = "") -> Callable[[Drawing], Markup]:
    """Gives the figures of a place of a page: each with a prefix of its own, the styles of all as common classes."""
    numbers, classes = count(), dict[str, str]()

    @cache
    def named(style: str) -> str:
        style = re.sub(r"#[0-9a-f]{6}\b", lambda c: f"var({variable(c[0])})" if c[0] in DARK else c[0], style)
        return f'class="{classes.setdefault(style, f"{place}k{len(classes)}")}"'

    def draw(drawing: Drawing) -> Markup:
        known = len(classes)
        broad = drawn(drawing)
        forms = {"broad": broad, "narrow": broad.narrow} if broad.narrow else {"only": broad}
        texts = {width: within(form, f"{place}f{next(numbers)}", drawing.label) for width, form in forms.items()}
        classed = {width: _STYLE_ATTRIBUTE.sub(lambda found: named(found[1]), text) for width, text in texts.items()}
        made = "".join(f'<div class="{width}"{_SCROLLED if width == "only" else ""}>{text}</div>'
            for width, text in classed.items())  # fmt: skip
        new = "".join(f".{name}{{{style}}}" for style, name in list(classes.items())[known:])
        return Markup(f"<style>{new}</style>{made}" if new else made)  # noqa: S704 - as `within` has made it

    return draw
