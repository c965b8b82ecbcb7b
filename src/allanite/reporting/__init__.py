"""What people look at: text for the terminal, figures, the page. Heavy libraries are imported when first used."""

import csv
import io
import math
import os
from collections.abc import Collection, Sequence
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING, Any

from allanite.core.aliases import public
from allanite.core.errors import UndrawnError, UsageError
from allanite.core.files import PathLike, demand_writable, encoded, write
from allanite.core.syntax import uncomputed

from .fonts import drawn_in, warn_of_page
from .language import speaking
from .views import first_of, has_view, level_of, view_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from allanite.core.fit import Fit

    from .first import First
    from .views import Rows

MAX_DATA_BYTES = 300_000  # bytes of compressed JSON that a page carries at most


@public
def plot(
    value: Any, fit: "Fit | None" = None, *, path: PathLike | None = None, level: float | None = None,
    force: bool = False, lang: str = "en",
) -> "Figure":  # fmt: skip
    """Draw a result for print.

    Parameters
    ----------
    value : any result, or a sequence of results of one kind
        Several curves of one unit share a panel. A state space may be followed by a measured curve.
    fit : Fit, optional
        What is drawn over a curve or spectrum, or over several statistics of one channel.
    path : path, optional
        Where the figure is saved; the suffix (.png, .svg, .pdf) says how.
    level : float, optional
        Of the confidence band; that of the result's recipe by default, or 0.95.
    force : bool
        Overwrite an existing file.
    lang : str
        Language of the words, a code of `reporting.language.LANGUAGES` such as "en" or "ru".

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    UsageError
        There is nothing to draw; the file exists, its suffix is unknown, or its folder cannot be written; the language
        is unknown.

    Warns
    -----
    FontWarning
        This machine has no font with the letters of the language; the figure is in English then.
    """
    from .printing import printed, save
    from .style import demand_figure_path

    if path is not None:
        demand_figure_path(path, force=force)
    values = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else [value]
    if not values:
        raise UsageError("there is nothing to draw: the sequence is empty")
    draw = view_of(values[0]).plot
    if draw is None:
        raise UsageError(f"a {type(values[0]).__name__} has no figure; al.report writes its page")
    with speaking(lang), speaking(drawn_in(lang)):
        figure = printed(draw(values, fit, level_of(values[0], level)))
        if path is not None:
            save(figure, path, force=force)
    return figure


@public
def report(value: Any, path: PathLike, *, level: float | None = None, force: bool = False, lang: str = "en") -> None:
    """Write a result as one self-contained file: numbers, figures, how they came about.

    Parameters
    ----------
    value : any result
    path : path
        The file to write: a PDF if it ends in .pdf, otherwise a page of HTML.
    level : float, optional
        Of intervals; that of the result's recipe by default, or 0.95.
    force : bool
        Overwrite an existing file.
    lang : str
        Language of the page, as in `plot`. Names, units, numbers and the stored data are the same in all.

    Raises
    ------
    UsageError
        The file exists, or its folder cannot be written; the language is unknown.
    """
    demand_writable(path, force=force)
    form = document if os.fspath(path).lower().endswith(".pdf") else page
    made = form(value, level=level, lang=lang)
    write(path, encoded(made) if isinstance(made, str) else made, force=force)


def document(value: Any, *, level: float | None = None, command: str = "", lang: str = "en") -> bytes:
    """The PDF that `report` writes to a file that ends in .pdf; `command` is the command line that made it."""
    from .pdf import render

    with speaking(lang), speaking(drawn_in(lang)):
        return render(replace(view_of(value).face(value, level_of(value, level)), command=command))


def page(value: Any, *, level: float | None = None, command: str = "", lang: str = "en") -> str:
    """The page that `report` writes, as text; `command` is the command line that made it."""
    import gzip

    from .html import render
    from .json import to_json

    with speaking(lang):
        warn_of_page(lang)
        face = view_of(value).face(value, level_of(value, level))
        data = gzip.compress(encoded(to_json(value)), compresslevel=6, mtime=0)
        return render(replace(face, command=command, data=data if len(data) < MAX_DATA_BYTES else b""))


def table(value: Any, *, level: float | None = None, lang: str = "en", **form: Any) -> str:
    """The result as text; `form` are the width, color and ASCII of `text.render`."""
    from .text import render

    with speaking(lang):
        return render(view_of(value).face(value, level_of(value, level)), **form)


def first_screen(  # noqa: PLR0913 - each has a default, and is a choice of its own
    value: Any, *, level: float | None = None, width: int = 100, color: bool = False, lang: str = "en",
    ascii: bool = False,  # noqa: A002 - as in repr
    brief: bool = False, first: "First | None" = None, written: Collection[str] = (),
) -> str:  # fmt: skip
    """The answer, or a `brief` one; `first` replaces that of the view, options in `written` do not come next."""
    from .screen import render, render_brief

    with speaking(lang):
        first = first or first_of(value, level_of(value, level))
        first = replace(first, after=[step for step in first.after if step[0].split()[0].lstrip("-") not in written])
        return render_brief(first, ascii=ascii) if brief else render(first, width=width, color=color, ascii=ascii)


def html_of(value: Any) -> str:
    """The result as a fragment of HTML for a notebook: its tables and sentences, and its figure."""
    from .html import fragment

    if not has_view(value):
        return f"<pre>{escape(repr(value))}</pre>"
    view, level = view_of(value), level_of(value)
    drawn = None
    try:
        if view.plot is not None:
            from .printing import printed

            drawn = printed(view.plot([value], None, level))
    except UndrawnError:
        pass
    return fragment(view.face(value, level), drawn)


def numbers(value: Any, *, level: float | None = None, coefficients: bool | None = False) -> "Rows":
    """Headings and rows of a result, unrounded; of a study its curves, or its coefficients (None: if it has any)."""
    view = view_of(value)
    coefficients = view.coefficients is not None if coefficients is None else coefficients
    rows_of = view.coefficients if coefficients else view.rows
    if rows_of is None:
        raise UsageError(f"a {type(value).__name__} has no table of numbers; to_dict() gives its content")
    return rows_of(value, level_of(value, level))


def to_csv(value: Any, *, level: float | None = None, coefficients: bool = False) -> str:
    """The numbers of a result as CSV, unrounded; of a study its curves, or its coefficients and readings."""
    headings, rows = numbers(value, level=level, coefficients=coefficients)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(headings)
    for row in rows:
        cells = ("" if isinstance(cell, float) and math.isnan(cell) else cell for cell in row)
        writer.writerow([uncomputed(cell) if isinstance(cell, str) else cell for cell in cells])
    return out.getvalue()
