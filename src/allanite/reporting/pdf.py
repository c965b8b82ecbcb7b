"""A result as PDF, for archives: the parts of the page in the same order, text as a terminal shows it, on A4."""

import io
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from allanite.core.errors import UsageError
from allanite.phrases.phrase import join, say

from .digits import printable
from .first import First
from .language import tr
from .printing import look, new_figure, printed
from .sheet import Drawing, Face, Fold, Part, Picture, Table, on_page
from .style import FORMATS
from .text import text_of, wrapped
from .words import capital

PAPER = (8.27, 11.69)  # a4, in inches
PAGE_COLUMNS, PAGE_LINES = 128, 94  # characters of a line and lines of a page
_MARGIN, _SIZE = 0.62, 6.5  # room at both sides in inches, and size of the letters in points

_TOP, _BOTTOM = 10.93, 0.55
_LINE = (_TOP - _BOTTOM) / PAGE_LINES

_ROOM, _FLAT = PAPER[0] - 2 * _MARGIN, 0.72
"""Width of a figure at most, and its height over that on a screen: paper is read from nearer."""

Line = tuple[str, bool]  # a line of text, and whether it is a heading


def render(face: Face) -> bytes:
    """The document, which depends on the result alone: it has no date."""
    out = io.BytesIO()
    with look(), PdfPages(out, metadata={**FORMATS["pdf"], "Title": printable(tr(face.title))}) as pages:
        paper = _Paper(pages, printable(tr(face.title)))
        for block in _blocks(face):
            paper.put(block)
        paper.end()
    return out.getvalue()


class _Paper:
    """Pages that are filled from the top down; a figure that has no room on one begins the next."""

    def __init__(self, pages: PdfPages, title: str) -> None:
        self.pages, self.title, self.count, self.left = pages, title, 0, 0.0
        self.page: Any = None
        self.headings: list[str] = []  # that stand on the page of what follows them

    def put(self, block: Line | Drawing) -> None:
        """Write a line, or draw a figure with its caption."""
        if isinstance(block, Drawing):
            figure, below = _figure(block), wrapped(tr(block.caption), PAGE_COLUMNS, "", "")
            height = figure.get_figheight()
            self._begin(height + _LINE * (len(below) + 1))
            self.left -= height
            self.page.place(figure, self.left)
            for line in (*below, ""):
                self._write(line)
        elif block[1]:
            self.headings.append(block[0])
        else:
            self._begin(_LINE)
            self._write(block[0])

    def end(self) -> None:
        """The last page is full."""
        if self.page is not None:
            self.pages.savefig(self.page)  # type: ignore[no-untyped-call]

    def _begin(self, height: float) -> None:
        """Have so much room on a page, below the headings that wait."""
        headings = [line for heading in self.headings for line in ("", heading)]
        if self.page is None or self.left - _LINE * len(headings) - height < _BOTTOM:
            self.end()
            self.count, self.left, self.page = self.count + 1, _TOP, _Page(figsize=PAPER, facecolor="white")
            self._text(_MARGIN, 11.28, self.title, size=12, weight="bold")
            self._text(PAPER[0] - _MARGIN, 11.28, f"{self.count}", size=8, ha="right")
        self.headings = []
        for line in headings:
            self._write(line, weight="bold")

    def _write(self, line: str, weight: str = "normal") -> None:
        if line or self.left < _TOP:
            self._text(_MARGIN, self.left, line, size=_SIZE, family="DejaVu Sans Mono", weight=weight)
            self.left -= _LINE

    def _text(self, x: float, y: float, text: str, **look: Any) -> None:
        self.page.text(x / PAPER[0], y / PAPER[1], text, va="top", parse_math=False, **look)


class _Page(Figure):
    """Draws the figures that stand on it, too."""

    def place(self, figure: Figure, bottom: float) -> None:
        """Put a figure whose layout is done in the middle, so many inches above the edge of the paper."""
        figure.bbox_inches.bounds = (
            (PAPER[0] - figure.get_figwidth()) / 2, bottom, figure.get_figwidth(), figure.get_figheight()
        )  # fmt: skip
        self.placed = [*getattr(self, "placed", ()), figure]

    def draw(self, renderer: Any) -> None:
        super().draw(renderer)
        for figure in getattr(self, "placed", ()):
            figure.draw(renderer)


def _figure(drawing: Drawing) -> Figure:
    """The figure of a drawing with its layout done, in the width of the text, and not higher than a page."""

    def make(width: float, height: float) -> Figure:
        return new_figure(width, min(_FLAT * height, _TOP - _BOTTOM - 4 * _LINE))

    plot = drawing.draw()
    if isinstance(plot, Picture):
        raise UsageError(
            "a page with figures that other commands have drawn is written as HTML only: end its name in .html"
        )
    figure = printed(plot, _ROOM, make)
    figure.set_dpi(72)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for artist in figure.findobj():
        artist.set_rasterized(False)
    return figure


def _blocks(face: Face) -> Iterator[Line | Drawing]:
    for line in (" · ".join(map(tr, face.facts)), *(f"{tr(key)}: {value}" for key, value in face.device.items())):
        yield from _plain(line)
    if face.summary is not None:
        yield from _summary(face.summary)
    for verdict in (verdict for sheet in face.sheets for verdict in sheet.verdicts):
        yield from _plain(verdict)
    yield from _parts(face.parts)
    for sheet in face.sheets:
        yield from _heading(sheet.name or say("channel"))
        for about in sheet.about:
            yield from _plain(about)
        yield from _parts(sheet.parts)
    yield from _parts(face.close)
    if face.how:
        yield from _heading(say("How this was computed"))
        yield from _parts(face.how)
    yield from _made(face)


def _made(face: Face) -> Iterator[Line]:
    """How it is reproduced."""
    facts = "\n".join(f"{key}: {value}" for key, value in face.provenance.items() if value)
    notes = "\n".join(map(tr, face.notes))
    for title, body in (
        (say("Command line"), face.command), (say("What was assumed when reading"), notes),
        (say("Recipe"), face.choices), (say("Provenance"), facts),
    ):  # fmt: skip
        if body:
            yield from _heading(title)
            for line in body.splitlines():
                yield from _plain(line)


def _summary(first: First) -> Iterator[Line]:
    """The tables of the first screen."""
    yield from _heading(join(": ", filter(None, (say("Summary"), first.verdict))))
    for table in first.tables:
        for line in (*text_of([table.table()], PAGE_COLUMNS).splitlines(), ""):
            yield line, False
    yield from _plain(first.signs)


def _parts(parts: Iterable[Part]) -> Iterator[Line | Drawing]:
    for part in on_page(parts):
        if isinstance(part, Fold):
            yield from _heading(part.title)
            yield from _parts(part.parts)
        elif isinstance(part, Drawing):
            if part.title:
                yield from _heading(part.title)
            yield part
        elif not (isinstance(part, Table) and part.details):  # those are for programs: CSV and JSON have them
            shown = part
            if isinstance(part, Table):
                shown = part.only([i for i, column in enumerate(part.columns) if column.kind != "formula"])
            for line in text_of([replace(shown, where="")], PAGE_COLUMNS).splitlines():
                yield line, False
            if isinstance(part, Table):
                yield from _plain(part.key, "  ")


def _heading(title: str) -> Iterator[Line]:
    yield printable(tr(capital(title))), True


def _plain(text: str, indent: str = "") -> Iterator[Line]:
    for line in wrapped(printable(tr(text)), PAGE_COLUMNS, indent, indent):
        yield line, False
