"""The sheets of an Excel workbook as CSV, read with openpyxl; started by `worker`."""

import csv
import datetime
import io
import os
from collections.abc import Callable
from typing import Any

os.environ["OPENPYXL_LXML"] = "False"  # the parser of the standard library limits what entities expand to
from openpyxl import load_workbook

HEAD = 200
"""Number of lines of a sheet that are listed."""


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The sheets with their first lines, and a function that sends the text of one; see `worker.main`."""
    book = load_workbook(path, read_only=True, data_only=True, keep_links=False)
    sheets = {sheet.title: _lines(sheet) for sheet in book.worksheets}
    texts = {title: "\n".join((*lines, "")).encode() for title, lines in sheets.items()}
    said = [
        {"path": title, "size": len(texts[title]), "rows": len(lines), "head": "\n".join(lines[:HEAD])[:20_000]}
        for title, lines in sheets.items()
        if lines
    ]
    return {"datasets": said}, lambda where, fields: (len(texts[where]), [texts[where]])


def _lines(sheet: Any) -> list[str]:
    """The rows as lines of CSV; rows with numbers have the same number of cells."""
    sheet.reset_dimensions()  # a claim of the file, to which rows would be filled
    lines, widths = list[str](), list[int]()
    for row in sheet.iter_rows(values_only=True):
        cells = list(row)
        while cells and cells[-1] in (None, ""):
            cells.pop()
        if cells:
            line = io.StringIO()
            csv.writer(line, lineterminator="").writerow([_word(cell) for cell in cells])
            lines.append(line.getvalue())
            # a title or a remark above the table has a width of its own
            widths.append(len(cells) if any(isinstance(cell, (int, float)) for cell in cells) else 0)
    wide = max(widths, default=0)
    return [line + "," * (wide - width if width else 0) for line, width in zip(lines, widths, strict=True)]


def _word(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, datetime.timedelta):
        return repr(cell.total_seconds())
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(" ")
    return repr(cell) if isinstance(cell, float) else " ".join(str(cell).split())
