"""Which files are meant, and what is known of each: paths, folders, patterns and manifests become a list of files."""

import csv
import glob
import math
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError, given
from allanite.core.files import reason
from allanite.phrases.phrase import say
from allanite.readers.sandbox.packing import PROSE
from allanite.readers.sandbox.source import STDIN, is_recording

PathLike = str | os.PathLike[str]

TEMPERATURE, DATE, UNIT = "temperature", "date", "unit_id"  # columns of a manifest with a meaning of their own
OWN = ("key", "sha256", "status", "error", "rejected")  # columns of the table of files that a manifest must not have

FORM = "a manifest has a path in each line, or is a CSV file with a column 'file'"


@dataclass(frozen=True)
class Sources:
    """Files, what was left out of folders, in `notes`, and what a manifest says of each."""

    files: tuple[str, ...]
    notes: tuple[str, ...] = ()
    # columns of the manifest: text, but a number for `TEMPERATURE` and a time (UTC) for `DATE`
    facts: dict[str, dict[str, Any]] = field(default_factory=dict)


def several(named: Sequence[PathLike]) -> bool:
    """Whether these names ask for many units: more than one, a folder that is not a ROS bag, or a pattern."""
    some = len(named) == 1 and not is_recording(named[0])
    return len(named) != 1 or (some and (os.path.isdir(named[0]) or _is_pattern(os.fspath(named[0]))))


def expand(named: Sequence[PathLike], besides: Iterable[str | None] = ()) -> Sources:
    """The files that are meant by these names, in the order in which they were named."""
    outputs = {os.path.realpath(path) for path in besides if path is not None}
    files_by_path: dict[str, str] = {}
    notes: list[str] = []
    for name in [os.fspath(path) for path in named]:
        files: Sequence[str] = [name]
        if os.path.isdir(name) and not is_recording(name):
            files = _in_folder(name, outputs, notes)
        elif name != STDIN and _is_pattern(name):
            every = [file for file in sorted(glob.glob(name, recursive=True)) if is_recording(file)]
            files = [file for file in every if os.path.realpath(file) not in outputs]
            if not files:
                raise DataError(f"no file matches {name!r}; check the folder, and the pattern")
        for file in files:
            files_by_path.setdefault(file if file == STDIN else os.path.realpath(file), file)
    return Sources(tuple(files_by_path.values()), tuple(notes))


def _in_folder(folder: str, left: set[str], notes: list[str]) -> Sequence[str]:
    try:
        inside = sorted(str(path) for path in Path(folder).iterdir() if is_recording(path) and path.name[0] != ".")
    except OSError as error:
        raise DataError(f"the directory {folder!r} cannot be read ({error.strerror or error})") from None
    prose = {file for file in inside if PROSE.search(os.path.basename(file))}
    files = [file for file in inside if file not in prose and os.path.realpath(file) not in left]
    if not files:
        raise DataError(f"the directory {folder!r} holds no recording; name its files, or a pattern such as '**/*.csv'")
    other = [os.path.basename(file) for file in inside if file not in files]
    if other:
        shown = ", ".join(other[:5]) + (" ..." if len(other) > 5 else "")
        notes.append(say("left out of {folder}, by their names not recordings: {files}", folder=folder, files=shown))
    return files


def _is_pattern(name: str) -> bool:
    """Whether a name is a pattern, and not that of a file which happens to have such letters."""
    return glob.has_magic(name) and not os.path.exists(name)


def manifest_of(source: PathLike, besides: Iterable[str | None] = ()) -> Sources:
    """The files of a batch, in the order of their names."""
    if several([source]):
        sources = expand([source], besides)
        return Sources(tuple(sorted(sources.files)), sources.notes)
    path = Path(source)
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{str(path)!r} cannot be read as a folder or a manifest ({reason(error)}); {FORM}") from None
    listed = ((i, {"file": line.strip()}) for i, line in enumerate(lines, 1) if line.strip() and line[0] != "#")
    rows = _csv(lines, path) if path.suffix.lower() == ".csv" else listed
    facts: dict[str, dict[str, Any]] = {}
    for number, row in rows:
        where = f"{path}, line {number}"
        if not row["file"]:
            raise UsageError(f"{where}: no file is given")
        file = os.path.normpath(path.parent / row["file"])
        known = {name: _fact(name, cell, where) for name, cell in row.items() if name != "file"}
        if file in facts:
            raise UsageError(f"{where}: {file!r} is listed twice; keep one of the lines")
        facts[file] = known
    if not facts:
        raise UsageError(f"the manifest {str(path)!r} lists no file; {FORM}")
    return Sources(tuple(sorted(facts)), (), facts)


def _cells(lines: list[str], path: Path) -> Iterator[tuple[int, list[str]]]:
    """The rows of a table, each with the line in which it begins."""
    reader, begin = csv.reader(lines, strict=True), 1
    try:
        for cells in reader:
            yield begin, cells
            begin = reader.line_num + 1
    except csv.Error as error:
        raise UsageError(f"{path}, line {begin}: {error}; is a quotation mark missing?") from None


def _csv(lines: list[str], path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    rows = _cells(lines, path)
    heads = [head.strip() for head in next(rows, (1, []))[1]]
    if "file" not in heads:
        raise UsageError(f"the manifest {str(path)!r} has no column 'file' but {heads[:8]}; {FORM}")
    wrong = sorted({head for head in heads if head in OWN or not head or heads.count(head) > 1})
    if wrong:
        raise UsageError(f"the manifest {str(path)!r} has columns named {wrong}: empty, twice, or reserved; rename "
                         "them")  # fmt: skip
    for begin, cells in rows:
        if not any(cells):
            continue
        if len(cells) != len(heads):
            raise UsageError(f"{path}, line {begin}: {len(cells)} cells, expected {len(heads)} as in line 1")
        yield begin, {head: cell.strip() for head, cell in zip(heads, cells, strict=True)}


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
            raise UsageError(f"{where}: the temperature is a number, not {given(cell)}")
        return number
    if name == DATE:
        try:
            time = datetime.fromisoformat(cell)
            return time.astimezone(UTC).replace(tzinfo=None) if time.tzinfo else time
        except ValueError:
            form = "2024-05-31 or 2024-05-31T12:00"
            raise UsageError(f"{where}: the date is written as {form}, not {given(cell)}") from None
        except OverflowError:
            raise UsageError(f"{where}: the date {cell!r} is outside the years 1 to 9999 of UTC") from None
    return cell
