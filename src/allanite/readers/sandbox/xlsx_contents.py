"""The sheets of an Excel workbook as CSV, read with openpyxl; started by `worker`."""

import csv
import datetime
import json
import os
import sys
from collections.abc import Callable
from typing import Any

os.environ["OPENPYXL_LXML"] = "False"  # the parser of the standard library limits what entities expand to
from openpyxl import load_workbook

HEAD_LINES = 200  # number of lines of a sheet that are listed
OFTEN = 1000  # rows between two reports of progress


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The sheets with their first lines, and a function that sends the text of one; see `worker.main`."""
    book = load_workbook(path, read_only=True, data_only=True, keep_links=False)
    count = len(book.worksheets)
    sheets = {sheet.title: _lines(sheet, (i, count)) for i, sheet in enumerate(book.worksheets)}
    texts = {title: "\n".join((*lines, "")).encode() for title, lines in sheets.items()}
    listed = [
        {"path": title, "size": len(texts[title]), "rows": len(lines), "head": "\n".join(lines[:HEAD_LINES])[:20_000]}
        for title, lines in sheets.items()
        if lines
    ]
    return {"datasets": listed}, lambda where, fields: (len(texts[where]), [texts[where]])


class _Lines(list[str]):
    """Lines that a `csv.writer` writes."""

    write = list.append


def _lines(sheet: Any, place: tuple[int, int]) -> list[str]:
    """The rows as lines of CSV; rows with numbers have the same number of cells."""
    claimed = sheet.max_row or 0
    sheet.reset_dimensions()  # a claim of the file, to which rows would be filled
    lines, widths = _Lines(), list[int]()
    writer = csv.writer(lines, lineterminator="")
    for number, row in enumerate(sheet.iter_rows(values_only=True)):
        if number % OFTEN == 0:
            share = (place[0] + min(1.0, number / max(claimed, number, 1))) / place[1] if claimed else 0.0
            sys.stdout.write(json.dumps({"share": share}) + "\n")
            sys.stdout.flush()
        cells = list(row)
        while cells and cells[-1] in (None, ""):
            cells.pop()
        if cells:
            writer.writerow([repr(cell) if type(cell) is float else _word(cell) for cell in cells])
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
