"""A result as PDF, for archives: its text as a terminal shows it, then every figure with its caption, a page each."""

import io
import textwrap
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from allanite.phrases.phrase import say

from .language import tr
from .sheet import Drawing, Face, Fold, Part, printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = (8.27, 11.69)
"""A4, in inches."""

COLUMNS, LINES = 118, 88
"""Characters of a line and lines of a page."""

_MARGIN, _SIZE = 0.075, 6.9
"""Share of the width that stays free at the left, and size of the letters in points."""


def render(face: Face) -> bytes:
    """The document, which depends on the result alone: it has no date."""
    from matplotlib.backends.backend_pdf import PdfPages

    from .style import FORMATS, look

    out, lines = io.BytesIO(), list(_lines(face))
    with look(), PdfPages(out, metadata={**FORMATS["pdf"], "Title": printable(tr(face.title))}) as pages:
        for start in range(0, len(lines), LINES):
            pages.savefig(_page(face, lines[start : start + LINES], f"{start // LINES + 1}"))
        for name, drawing in _drawings(face):
            pages.savefig(_figure(drawing, name), bbox_inches="tight", pad_inches=0.4)
    return out.getvalue()


def _lines(face: Face) -> Iterator[str]:
    from .text import render as text

    device = (f"{tr(key)}: {value}" for key, value in face.device.items())
    yield from filter(None, (" · ".join(map(tr, face.facts)), *device))
    yield from ("", *text(face, width=COLUMNS).splitlines())
    for title, body in ((say("Command line"), face.command), (say("Recipe"), face.choices)):
        if body:
            yield from ("", tr(title), "", *(f"  {line}" for line in _wrapped(body)))


def _wrapped(body: str) -> Iterator[str]:
    for line in body.splitlines():
        yield from textwrap.wrap(printable(line), COLUMNS - 2, break_on_hyphens=False) or [""]


def _page(face: Face, lines: Iterable[str], number: str) -> "Figure":
    from .style import new_figure

    page = new_figure(*PAPER)
    page.text(_MARGIN, 0.965, printable(tr(face.title)), size=12, weight="bold", va="top", parse_math=False)
    page.text(1 - _MARGIN, 0.965, number, size=8, ha="right", va="top")
    step = 0.91 / LINES
    for i, line in enumerate(lines):
        place = (_MARGIN, 0.935 - i * step)
        page.text(*place, line, size=_SIZE, family="DejaVu Sans Mono", va="top", parse_math=False)
    return page


def _drawings(face: Face) -> Iterator[tuple[str, Drawing]]:
    """The figures of all parts, with the name of their channel."""
    for name, parts in (("", face.parts), *((s.name, s.parts) for s in face.sheets), ("", face.close), ("", face.how)):
        yield from ((name, drawing) for drawing in _within(parts))


def _within(parts: Iterable[Part]) -> Iterator[Drawing]:
    for part in parts:
        if isinstance(part, Fold):
            yield from _within(part.parts)
        elif isinstance(part, Drawing) and part.where != "text":
            yield part


def _figure(drawing: Drawing, name: str) -> "Figure":
    """The figure with its title above and its caption below, outside of its own frame."""
    figure = drawing.draw().printed()
    width = int(14 * figure.get_figwidth())
    above = ": ".join(filter(None, (printable(name), tr(drawing.title))))
    below = "\n".join(textwrap.wrap(tr(drawing.caption or drawing.label), width))
    # the layout keeps within the frame: what stands beyond it is taken in when the page is cut
    for text, place, edge in ((above, 1.02, "bottom"), (below, -0.02, "top")):
        figure.text(0.0, place, text, size=9, va=edge, parse_math=False, in_layout=True)
    return figure
