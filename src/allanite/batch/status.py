"""What became of the files of a batch, and the tables that say so."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

from .executor import Plain
from .sources import OWN
from .store import Store
from .tables import TABLES, as_table, schema_of

DONE, FAILED, OPEN = "done", "failed", "open"
"""Status of a file: it has a result, it has none and why is known, it was not reached yet."""

AT_ONCE = 64
"""Files whose rows are held in memory together."""


@dataclass(frozen=True)
class FileStatus:
    """A file of a batch, and what became of it."""

    file: str
    facts: dict[str, Any]  # the columns of the manifest
    # key, sha256: the key of its result, and of what content it is; empty if the file cannot be read
    key: str = ""
    sha256: str = ""
    status: str = OPEN  # One of "done", "failed", "open"
    error: str = ""  # why it has failed
    rejected: str = ""  # channels without a result, or whose noise no model explains


@dataclass(frozen=True)
class Resumed:
    """What a run of a batch has done."""

    files: tuple[FileStatus, ...]  # all files, in the order of their names
    analyzed: int  # records that were analyzed now; files with the same content are one
    before: int  # files that were done by an earlier run
    notes: tuple[str, ...] = ()  # what was left out

    @property
    def failed(self) -> tuple[FileStatus, ...]:
        """The files without a result."""
        return tuple(file for file in self.files if file.status != DONE)

    @property
    def rejected(self) -> tuple[str, ...]:
        """File and channel of what has no result, or is not explained by its model."""
        return tuple(f"{file.file}: {file.rejected}" for file in self.files if file.rejected)


def put_files(store: Store, files: Iterable[FileStatus], choices: Plain) -> None:
    """The table of files, with the recipe in its metadata."""
    ordered = sorted(files, key=lambda f: f.file)
    rows = [{"file": f.file, **{name: getattr(f, name) for name in OWN}, **f.facts} for f in ordered]
    store.put_files(rows, choices)


def put_tables(store: Store, files: Iterable[FileStatus]) -> Iterator[FileStatus]:
    """Write the other tables in the order of the files, and yield the files with what their results say of them.

    Each result is read once, and a few are held at a time.
    """
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(store.writer(name, schema_of(columns))) for name, (columns, _) in TABLES.items()
        }
        ordered = sorted(files, key=lambda file: file.file)
        for i in range(0, len(ordered), AT_ONCE):
            group = ordered[i : i + AT_ONCE]
            parts = [store.get(file.key) if file.status == DONE else {} for file in group]
            for name, (_, rows_of) in TABLES.items():
                found = zip(group, parts, strict=True)
                rows = [row for file, part in found if "study" in part for row in rows_of(file.file, part["study"])]
                if rows:
                    writers[name].write_table(as_table(rows, writers[name].schema))
            for file, part in zip(group, parts, strict=True):  # a stored result may be an error
                error, rejected = part.get("error", ""), part.get("rejected", "")
                settled = replace(file, status=FAILED if error else DONE, error=error, rejected=rejected)
                yield settled if file.status == DONE else file
