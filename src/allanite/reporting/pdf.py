"""A result as PDF, for archives: its text as a terminal shows it, then every figure with its caption, a page each."""

import io
import textwrap
from collections.abc import Iterator

from allanite.phrases.phrase import join, say

from .digits import printable
from .language import tr
from .sheet import Face, drawings

PAPER = (8.27, 11.69)
"""A4, in inches."""

COLUMNS, LINES = 118, 88
"""Characters of a line and lines of a page."""

_MARGIN, _SIZE = 0.075, 6.9
"""Share of the width that stays free at the left, and size of the letters in points."""


def render(face: Face) -> bytes:
    """The document, which depends on the result alone: it has no date."""
    from matplotlib.backends.backend_pdf import PdfPages

    from .style import FORMATS, look, new_figure

    out, lines = io.BytesIO(), list(_lines(face))
    with look(), PdfPages(out, metadata={**FORMATS["pdf"], "Title": printable(tr(face.title))}) as pages:
        for start in range(0, len(lines), LINES):
            page = new_figure(*PAPER)
            page.text(_MARGIN, 0.965, printable(tr(face.title)), size=12, weight="bold", va="top", parse_math=False)
            page.text(1 - _MARGIN, 0.965, f"{start // LINES + 1}", size=8, ha="right", va="top")
            for i, line in enumerate(lines[start : start + LINES]):
                height = 0.935 - i * (0.91 / LINES)
                page.text(_MARGIN, height, line, size=_SIZE, family="DejaVu Sans Mono", va="top", parse_math=False)
            pages.savefig(page)
        sheets = ((sheet.name, sheet.parts) for sheet in face.sheets)
        groups = (("", face.parts), *sheets, ("", face.close), ("", face.how))
        for name, drawing in ((name, drawing) for name, parts in groups for drawing in drawings(parts)):
            # the figure with its title above and its caption below, outside of its own frame
            figure = drawing.draw().printed()
            width = int(14 * figure.get_figwidth())
            above = tr(join(": ", filter(None, (printable(name), drawing.title))))
            below = "\n".join(textwrap.wrap(tr(drawing.caption or drawing.label), width))
            # the layout keeps within the frame: what stands beyond it is taken in when the page is cut
            for text, height, edge in ((above, 1.02, "bottom"), (below, -0.02, "top")):
                figure.text(0.0, height, text, size=9, va=edge, parse_math=False, in_layout=True)
            pages.savefig(figure, bbox_inches="tight", pad_inches=0.4)
    return out.getvalue()


def _lines(face: Face) -> Iterator[str]:
    from .text import render as text

    device = (f"{tr(key)}: {value}" for key, value in face.device.items())
    yield from filter(None, (" · ".join(map(tr, face.facts)), *device))
    yield from ("", *text(face, width=COLUMNS).splitlines())
    for title, body in ((say("Command line"), face.command), (say("Recipe"), face.choices)):
        if body:
            yield from ("", tr(title), "")
            for line in body.splitlines():
                short = textwrap.wrap(printable(line), COLUMNS - 2, break_on_hyphens=False) or [""]
                yield from (f"  {part}" for part in short)
