"""Tables on small screens: one of words that is too wide is shown cell by cell, each behind its heading."""

from docutils import nodes
from sphinx.application import Sphinx

WIDEST = 40  # characters that fit beside each other on a telephone, with the space between two columns as three


def setup(app: Sphinx) -> dict[str, bool]:
    """After references are resolved."""
    app.connect("doctree-resolved", lambda _app, tree, _name: [_marked(table) for table in tree.findall(nodes.table)])
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _marked(table: nodes.table) -> None:
    rows = [list(row.findall(nodes.entry)) for row in table.findall(nodes.row)]
    head, *body = rows
    if _width(rows) <= WIDEST or not _of_words(body):
        return
    table["classes"].append("stacked")
    for row in body:
        for title, cell in zip(head[1:], row[1:], strict=False):
            if cell.astext() and title.astext():
                label = nodes.inline("", f"{title.astext()}: ", classes=["heading"])
                cell.children[0].insert(0, label)


def _width(rows: list[list[nodes.entry]]) -> int:
    """Of the columns when each is as narrow as its longest part that stays in one line."""
    return sum(max(map(_longest, column)) + 3 for column in zip(*rows, strict=False))


def _longest(cell: nodes.entry) -> int:
    whole = [node.astext() for kind in (nodes.literal, nodes.math) for node in cell.findall(kind)]
    return max(map(len, [*whole, *cell.astext().split()]), default=0)


def _of_words(rows: list[list[nodes.entry]]) -> bool:
    """Whether most cells hold no number; columns of numbers are to be compared, and scroll instead."""
    cells = [text for row in rows for cell in row[1:] if (text := cell.astext())]
    return sum(text.strip(" <>−+-%.0123456789") != "" for text in cells) > 0.7 * len(cells)
