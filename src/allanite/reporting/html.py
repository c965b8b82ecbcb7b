"""Sheets as one HTML page that needs nothing else: no font, no request; a script of its own copies text."""

import base64
import hashlib
import re
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from allanite.parallel.processors import how_many, shared
from allanite.phrases.phrase import join, say, say_count
from allanite.terms import TERMS

from .digits import printable, printed, printed_heading, printed_unit
from .language import spoken, tr
from .matplotlib_svg import drawer, picture, variable, within
from .sheet import Code, Column, Drawing, Face, Fold, Note, Table, on_page
from .style import DARK, Figure
from .words import capital

MADE = {"source": say("source"), "applied to": say("applied to"), "sha256 applied to": say("sha256 applied to")}
"""What keys of the provenance are called; the others are names."""

_NOTEBOOK = count()  # numbers of the figures of a notebook, whose cells are one page


def render(face: Face) -> str:
    """The page as text, in the language that is spoken."""
    grounds = [{variable(c): c for c in DARK}, {variable(c): dark for c, dark in DARK.items()}]
    template, mould = (_environment().get_template(f"{name}.html.j2") for name in ("page", "parts"))

    def drawn(i: int) -> str:
        macros: Any = mould.module
        draw = drawer(f"s{i}-")
        return str(macros.sheet(face.sheets[i - 1], draw, f"s{i}") if i else macros.parts(face.parts, draw))

    parts = shared(drawn, range(len(face.sheets) + 1), count=how_many(len(face.sheets)))
    return template.render(face=face, parts=parts, draw=drawer(), grounds=grounds, lang=spoken(), copy=_script())


@cache
def _script() -> tuple[Markup, str]:
    """The script of the page, and its digest, by which a browser knows it."""
    text = Path(__file__).with_name("copy.js").read_text("utf-8")
    return Markup(text), base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()  # noqa: S704 - our own


def fragment(face: Face, figure: Figure | None = None) -> str:
    """The sheets alone, for a notebook, and one figure above them."""
    drawn = None if figure is None else within(picture(figure), f"n{next(_NOTEBOOK)}", tr(face.title))
    return _environment().get_template("fragment.html.j2").render(face=face, figure=drawn, draw=None)


def pieces(face: Face) -> tuple[str, list[str]]:
    """What a face has besides its sheets, and each of these, without figures; colors of terms as ``data-color``."""
    template = _environment().get_template("sheet.html.j2")
    rest = template.render(face=face, one=None, items=(*face.parts, *face.close))
    made = [rest, *(template.render(face=face, one=sheet, items=()) for sheet in face.sheets)]
    plain = [_STYLE.sub(lambda found: f' data-color="{found[1]}"', text) for text in made]
    return plain[0], plain[1:]


_STYLE = re.compile(r' style="color: var\([^,"]*, (#[0-9A-Fa-f]{6})\)"')

_BREAK = re.compile(r"(?<!,) (?!\()")
"""Where a cell of the summary is not broken: anywhere but before an interval and after a comma."""

_NAME = re.compile(r"--[a-z][a-z-]*(?: [\w./^-]+)?")
"""An option in a sentence with its value, which are not to be broken."""


def _clean(text: str) -> str:
    return printable(tr(text)).replace(" .. ", " … ")


def _prose(text: str) -> Markup:
    return Markup(_NAME.sub(r'<span class="option">\g<0></span>', str(escape(_clean(text)))))  # noqa: S704 - escaped


@cache
def _environment() -> Environment:
    env = Environment(
        loader=PackageLoader("allanite", "reporting"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=tr,  # whatever a template shows is translated, here or by a filter
    )  # fmt: skip
    env.filters.update(
        clean=_clean, prose=_prose, unit=printed_unit, made=_made, capital=capital,
        heading=_heading, base64=lambda data: base64.b64encode(data).decode(),
        firm=lambda text: _BREAK.sub("\N{NO-BREAK SPACE}", _clean(text)),
    )  # fmt: skip
    env.globals.update(
        say=say, say_count=say_count, body=_body,
        kind_of=lambda part: {Table: "table", Note: "note", Drawing: "drawing", Code: "code", Fold: "fold"}[type(part)],
        css=_css, numeric=lambda column: column.kind in NUMERIC, shown=on_page, color_of=_color_of,
    )  # fmt: skip
    return env


def _made(key: str) -> str:
    name, _, number = key.rpartition(" ")
    return join(" ", (_made(name), number)) if number.isdigit() else MADE.get(key, key)


def _color_of(symbol: str) -> str:
    """The color of a term: that of the page's ground, or of white paper in a notebook."""
    name = symbol.strip("|")
    return f"var({variable(TERMS[name].color)}, {TERMS[name].color})" if name in TERMS else ""


def _heading(text: str) -> str:
    return printed_heading(tr(text))


NUMERIC = ("number", "interval", "unit")  # kinds of columns whose cells are at the right


def _body(table: Table) -> Markup:
    """The rows of a table; where it is no list of numbers, a narrow screen has the heading beside each cell."""
    labels = [f' data-label="{escape(_heading(column.heading))}"' if column.heading else "" for column in table.columns]
    made = []
    for i, row in enumerate(table.rows):
        mark, cells = table.mark(i), []
        for j, (column, text) in enumerate(zip(table.columns, row, strict=True)):
            start = 'th scope="row"' if not j and text and column.kind in ("name", "symbol") else "td"
            named = _css(column, text, mark) if not table.details else "" if column.kind in NUMERIC else "left"
            label = labels[j] if text and not table.details else ""
            color = _color_of(text) if column.kind == "symbol" else ""
            look = (f' class="{named}"' if named else "") + label + (f' style="color: {color}"' if color else "")
            cells.append(f"<{start}{look}>{escape(_cell(column, text))}</{start[:2]}>")
        made.append(f"<tr>{''.join(cells)}</tr>")
    return Markup("\n".join(made))  # noqa: S704 - escaped


def _cell(column: Column, text: str) -> Markup | str:
    if column.kind == "formula":
        from latex2mathml.converter import convert

        # a long one is scrolled where the screen is narrow: by keys, too
        return Markup(convert(text).replace("<math ", '<math tabindex="0" ', 1))  # noqa: S704 - our own tables' formulas
    return printed(tr(text), column.kind)


def _css(column: Column, text: str, mark: str) -> str:
    """Classes of a cell; the status is its own class."""
    names = {"number": "number", "name": "name", "symbol": "symbol", "text": "wrap", "formula": "formula"}
    own = text.split(",", maxsplit=1)[0].replace(" ", "-") if column.kind == "status" else names.get(column.kind, "")
    own_only = {"strong": column.kind == "number" and not column.aside, "struck": column.kind != "status"}
    shown = mark if own_only.get(mark, True) else ""
    return " ".join(filter(None, (own, "quiet" if column.aside else "", shown)))
