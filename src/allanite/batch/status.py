"""What became of the files of a batch, and the tables that say so."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from allanite.core.version import __version__

from .executor import Plain
from .manifest import DATE, OWN, TEMPERATURE
from .store import FILES, Store
from .tables import TABLES, as_table, schema_of

DONE, FAILED, OPEN = "done", "failed", "open"
"""Status of a file: it has a result, it has none and why is known, it was not reached yet."""

AT_ONCE = 256
"""Files whose rows are held in memory together."""


@dataclass(frozen=True)
class FileStatus:
    """A file of a batch, and what became of it.

    Attributes
    ----------
    file : str
    facts : dict
        The columns of the manifest.
    key, sha256 : str
        The key of its result, and of what content it is; empty if the file cannot be read.
    status : {"done", "failed", "open"}
    error : str
        Why it has failed.
    rejected : str
        Channels without a result, or whose noise no model explains.
    """

    file: str
    facts: dict[str, Any]
    key: str = ""
    sha256: str = ""
    status: str = OPEN
    error: str = ""
    rejected: str = ""


@dataclass(frozen=True)
class Resumed:
    """What a run of a batch has done.

    Attributes
    ----------
    files : tuple of FileStatus
        All files, in the order of their names.
    analyzed : int
        Records that were analyzed now; files with the same content are one.
    before : int
        Files that were done by an earlier run.
    notes : tuple of str
        What was left out.
    """

    files: tuple[FileStatus, ...]
    analyzed: int
    before: int
    notes: tuple[str, ...] = ()

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
    import pyarrow as pa

    rows = [
        {"file": f.file, **{name: getattr(f, name) for name in OWN}, **f.facts}
        for f in sorted(files, key=lambda f: f.file)
    ]
    special = {TEMPERATURE: pa.float64(), DATE: pa.timestamp("us")}
    fields = [(name, special.get(name, pa.string())) for name in dict.fromkeys(name for row in rows for name in row)]
    about = {"allanite": __version__, "recipe": json.dumps(choices, sort_keys=True)}
    table = pa.Table.from_pylist(rows, schema=pa.schema(fields, about))
    store.table(FILES, [table], table.schema)


def put_tables(store: Store, files: Iterable[FileStatus]) -> None:
    """The other tables, in the order of the files."""
    done = sorted((file for file in files if file.status == DONE), key=lambda file: file.file)
    for name, (columns, rows_of) in TABLES.items():
        schema = schema_of(columns)
        groups = (done[i : i + AT_ONCE] for i in range(0, len(done), AT_ONCE))
        rows = ([row for f in group for row in rows_of(f.file, store.get(f.key)["study"])] for group in groups)
        store.table(name, (as_table(group, schema) for group in rows), schema)
