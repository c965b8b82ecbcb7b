"""The folder of results: a part for each file that was analyzed, found again by its content and the recipe."""

import hashlib
import json
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError
from allanite.core.files import DRAFTS, draft, reason
from allanite.core.version import __version__
from allanite.phrases.phrase import Phrase
from allanite.phrases.wording import spelled
from allanite.readers.sandbox.source import STDIN, checked, digest_of

from .executor import Plain

PARTS = "parts"
"""Folder of the parts."""

FILES = "files.parquet"
"""The table of files, which makes a folder one of results."""

TEMPLATES, FIELDS = "say", "with"
"""Keys of a phrase."""

LOCK = ".lock"
"""The file that a run locks; it stays, and is empty."""


def identity(file: str, choices: Plain) -> tuple[str, str]:
    """The sha256 of a file, and the key of its result: of the content, the form of the name, the recipe, the version.

    Raises
    ------
    DataError
        The file cannot be read.
    """
    if file == STDIN:
        raise UsageError("a batch reads files, not standard input")
    name, member = checked(file)
    try:
        digest = digest_of(name)
    except OSError as error:
        raise DataError(f"{file}: the file cannot be read ({error.strerror or error})") from None
    whole = [digest, Path(name).suffix.lower(), member, choices, __version__]
    return digest, hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Store:
    """A folder of results.

    Each part is written under another name, flushed to the disk and renamed: it is there as a whole or not at all.
    """

    folder: Path

    @classmethod
    def opened(cls, folder: str | os.PathLike[str], *, new: bool = False) -> "Store":
        """An existing folder of results, or with `new` one that may have to be made.

        Raises
        ------
        UsageError
            It is not a folder of results, or cannot be made.
        """
        path = Path(folder)
        if new:
            try:
                path.mkdir(parents=True, exist_ok=True)
                known = not any(path.iterdir()) or (path / PARTS).is_dir()
                if known:
                    (path / PARTS).mkdir(exist_ok=True)
            except OSError as error:
                why = error.strerror or error
                raise UsageError(f"the folder {str(path)!r} cannot be made or used ({why}); give another one") from None
        else:
            known = (path / FILES).is_file()
        if not known:
            made = spelled(f"allanite batch FOLDER --out {str(path)!r}", f"al.batch(files, {str(path)!r})")
            how = "give a new or an empty folder" if new else f"make one with {made}"
            raise UsageError(f"{str(path)!r} does not hold the results of a batch; {how}")
        return cls(path)

    def part(self, key: str) -> Path:
        """Where the result with this key is."""
        return self.folder / PARTS / f"{key}.parquet"

    def has(self, key: str) -> bool:
        """Whether there is a result with this key; a part that is damaged is none."""
        from pyarrow import ArrowInvalid, parquet

        try:
            return bool(parquet.read_metadata(self.part(key)).num_rows == 1)
        except (OSError, ArrowInvalid):
            return False

    def put(self, key: str, result: Plain) -> None:
        """Store a result at once.

        Raises
        ------
        UsageError
            The disk is full or cannot be written to.
        """
        import pyarrow as pa

        row = {name: dumps(value) for name, value in result.items()}
        self.write(f"{PARTS}/{key}.parquet", pa.table({name: [text] for name, text in sorted(row.items())}))

    def get(self, key: str) -> Plain:
        """A stored result.

        Raises
        ------
        DataError
            The part is missing or damaged.
        """
        from pyarrow import ArrowInvalid, parquet

        try:
            (row,) = parquet.read_table(self.part(key), memory_map=False).to_pylist()
        except (OSError, ArrowInvalid, ValueError) as error:
            raise DataError(
                f"the part {str(self.part(key))!r} cannot be read ({reason(error)}); run the batch again"
            ) from None
        return {name: loads(text) for name, text in row.items()}

    @contextmanager
    def writer(self, name: str, schema: Any) -> Iterator[Any]:
        """A table that is written row group by row group, and is there once all of them are.

        Raises
        ------
        UsageError
            The disk is full or cannot be written to.
        """
        from pyarrow import parquet

        with (
            draft(self.folder / name, force=True) as part,
            parquet.ParquetWriter(part, schema, compression="zstd") as writer,
        ):
            yield writer

    def write(self, name: str, table: Any) -> None:
        """Write a table; see `writer`."""
        with self.writer(name, table.schema) as writer:
            writer.write_table(table)

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Be the only run that writes to this folder, from which drafts of a killed run are removed.

        Raises
        ------
        UsageError
            Another run writes to it, or the disk cannot be written to.
        """
        name = repr(str(self.folder))
        try:
            file = open(self.folder / LOCK, "ab")  # noqa: SIM115 - closed below, as long as it is locked
        except OSError as error:
            raise UsageError(f"{name} cannot be written to ({error.strerror}); give another folder") from None
        with file:
            try:  # the system frees it however the run ends
                if sys.platform == "win32":
                    import msvcrt

                    msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
                else:
                    import fcntl

                    fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
            except (BlockingIOError, PermissionError):  # what Windows says of a file that is locked
                raise UsageError(
                    f"another run writes its results to {name}; wait until it has ended, or give another folder"
                ) from None
            for left in (*self.folder.glob(DRAFTS), *(self.folder / PARTS).glob(DRAFTS)):
                left.unlink()
            yield

    def files(self) -> tuple[list[Plain], Mapping[bytes, bytes]]:
        """The rows of the table of files, and its metadata.

        Raises
        ------
        DataError
            It cannot be read.
        """
        from pyarrow import ArrowInvalid, parquet

        try:
            table = parquet.read_table(self.folder / FILES)
        except (OSError, ArrowInvalid) as error:
            raise DataError(
                f"{str(self.folder / FILES)!r} cannot be read ({reason(error)}); run the batch again"
            ) from None
        return table.to_pylist(), table.schema.metadata or {}


def dumps(data: Any) -> str:
    """Plain data as JSON in which phrases keep how they were made, so that a result is shown in any language.

    Examples
    --------
    >>> from allanite.phrases.phrase import say
    >>> dumps({"what": say("at {f:g} Hz", f=2.5), "name": "gx"})
    '{"name": "gx", "what": {"say": ["at {f:g} Hz"], "with": {"f": 2.5}}}'
    >>> loads(_)["what"]
    'at 2.5 Hz'
    """
    return json.dumps(_taken_apart(data), sort_keys=True)


def loads(text: str) -> Any:
    """The data that `dumps` has written."""

    def phrase(data: dict[str, Any]) -> Any:
        return Phrase(tuple(data[TEMPLATES]), data[FIELDS]) if data.keys() == {TEMPLATES, FIELDS} else data

    return json.loads(text, object_hook=phrase)


def _taken_apart(data: Any) -> Any:
    if isinstance(data, Phrase):
        return {TEMPLATES: list(data.templates), FIELDS: _taken_apart(dict(data.fields))}
    if isinstance(data, dict):
        return {key: _taken_apart(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_taken_apart(value) for value in data]
    return data.item() if hasattr(data, "item") else data
