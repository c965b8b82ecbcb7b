"""Which files a batch has, and what is known of each: a folder, a pattern, or a manifest that lists them."""

import csv
import math
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from allanite.core.errors import UsageError

from .sources import PathLike, expand, several

TEMPERATURE, DATE, UNIT = "temperature", "date", "unit_id"
"""Columns of a manifest with a meaning of their own."""

OWN = ("key", "sha256", "status", "error", "rejected")
"""Columns of the table of files that a manifest must not have."""

FORM = "a manifest has a path in each line, or is a CSV file with a column 'file'"


@dataclass(frozen=True)
class Entry:
    """A file, and the columns of the manifest: text, but a number for `TEMPERATURE` and a time (UTC) for `DATE`."""

    file: str
    facts: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Manifest:
    """The files in the order of their names, and what was left out of a folder, in `notes`."""

    entries: tuple[Entry, ...]
    notes: tuple[str, ...] = ()


def manifest_of(source: PathLike, besides: Iterable[str | None] = ()) -> Manifest:
    """The files of a batch.

    Parameters
    ----------
    source : path
        A folder, a pattern such as ``"units/*.csv"``, or a manifest: a text file with a path in each line, or a CSV
        file with the columns ``file``, ``unit_id``, ``temperature`` (a number), ``date`` (ISO 8601) and others, of
        which only the first is required. Paths are relative to the folder of the manifest.
    besides : iterable of path or None
        Files of a folder that are not recordings.

    Raises
    ------
    DataError
        A folder cannot be read or holds no recording, or no file matches a pattern.
    UsageError
        A manifest cannot be read, or is wrong in a line that the message names.
    """
    if several([source]):
        found = expand([source], besides)
        return Manifest(tuple(map(Entry, sorted(found.files))), found.notes)
    path = Path(source)
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{str(path)!r} cannot be read as a folder or a manifest ({error}); {FORM}") from None
    listed = ((i, {"file": line.strip()}) for i, line in enumerate(lines, 1) if line.strip() and line[0] != "#")
    rows = _csv(lines, path) if path.suffix.lower() == ".csv" else listed
    entries: dict[str, Entry] = {}
    for number, row in rows:
        where = f"{path}, line {number}"
        if not row["file"]:
            raise UsageError(f"{where}: no file is given")
        file = os.path.normpath(path.parent / row["file"])
        facts = {name: _fact(name, cell, where) for name, cell in row.items() if name != "file"}
        if file in entries:
            raise UsageError(f"{where}: {file!r} is listed twice; keep one of the lines")
        entries[file] = Entry(file, facts)
    if not entries:
        raise UsageError(f"the manifest {str(path)!r} lists no file; {FORM}")
    return Manifest(tuple(entries[file] for file in sorted(entries)))


def _csv(lines: list[str], path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    reader = csv.reader(lines)
    heads = [head.strip() for head in next(reader, [])]
    if "file" not in heads:
        raise UsageError(f"the manifest {str(path)!r} has no column 'file' but {heads[:8]}; {FORM}")
    wrong = sorted({head for head in heads if head in OWN or not head or heads.count(head) > 1})
    if wrong:
        raise UsageError(
            f"the manifest {str(path)!r} has columns named {wrong}: empty, twice, or reserved; rename them"
        )
    for cells in reader:
        if not any(cells):
            continue
        if len(cells) != len(heads):
            raise UsageError(f"{path}, line {reader.line_num}: {len(cells)} cells, expected {len(heads)} as in line 1")
        yield reader.line_num, {head: cell.strip() for head, cell in zip(heads, cells, strict=True)}


def _fact(name: str, cell: str, where: str) -> str | float | datetime | None:
    """What a cell says of a file: None if it is empty."""
    if not cell:
        return None
    if name == TEMPERATURE:
        try:
            number = float(cell)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise UsageError(f"{where}: the temperature is a number, not {cell!r}")
        return number
    if name == DATE:
        try:
            time = datetime.fromisoformat(cell)
        except ValueError:
            raise UsageError(f"{where}: the date is written as 2024-05-31 or 2024-05-31T12:00, not {cell!r}") from None
        return time.astimezone(UTC).replace(tzinfo=None) if time.tzinfo else time
    return cell
