"""The folder of results: a part for each file that was analyzed, found again by its content and the recipe."""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError
from allanite.core.files import DRAFTS, draft, encoded, in_utf8, locked, reason
from allanite.core.version import __version__
from allanite.phrases.phrase import Phrase, spelled
from allanite.readers.arrow import pa, parquet
from allanite.readers.sandbox.source import STDIN, checked, digest_of
from allanite.study.recipe import Recipe

from .executor import Plain
from .sources import DATE, OWN, TEMPERATURE

PARTS = "parts"  # folder of the parts
FILES = "files.parquet"  # the table of files, which makes a folder one of results
DIGEST = b"sha256"  # metadata of a part: the digest of its columns
TEMPLATES, FIELDS = "say", "with"  # keys of a phrase
LOCK = ".lock"  # the file that a run locks; it stays, and is empty


def identity(file: str, choices: Plain) -> tuple[str, str]:
    """The sha256 of a file, and the key of its result: of content, form of the name, recipe, version."""
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
    """A folder of results; a part is there as a whole or not at all: it is written under another name and renamed."""

    folder: Path

    @classmethod
    def opened(cls, folder: str | os.PathLike[str], *, new: bool = False) -> "Store":
        """An existing folder of results, or with `new` one that may have to be made."""
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
        try:
            return bool(self._texts(key))
        except DataError:
            return False

    def put(self, key: str, result: Plain) -> None:
        """Store a result at once."""
        row = {name: dumps(value) for name, value in sorted(result.items())}
        table = pa.table({name: [text] for name, text in row.items()})
        self.write(f"{PARTS}/{key}.parquet", table.replace_schema_metadata({DIGEST: _digest(row)}))

    def get(self, key: str) -> Plain:
        """A stored result."""
        return {name: loads(text) for name, text in self._texts(key).items()}

    def _texts(self, key: str) -> dict[str, str]:
        """The columns of a part, which have to be those that `put` has written."""
        try:
            with in_utf8(self.part(key)) as part:
                table = parquet.read_table(part, memory_map=False)
            row: dict[str, str]
            (row,) = table.to_pylist()
            if (table.schema.metadata or {}).get(DIGEST) != _digest(row):
                raise ValueError("its content is not what was stored")
        except (OSError, pa.ArrowInvalid, ValueError) as error:
            raise DataError(f"the part {str(self.part(key))!r} cannot be read ({reason(error)}); run the batch "
                            "again") from None  # fmt: skip
        return row

    @contextmanager
    def writer(self, name: str, schema: Any) -> Iterator[Any]:
        """A table that is written row group by row group, and is there once all of them are."""
        with (
            draft(self.folder / name, force=True) as part,
            in_utf8(part, "wb") as file,
            parquet.ParquetWriter(file, schema, compression="zstd") as writer,
        ):
            yield writer

    def write(self, name: str, table: Any) -> None:
        """Write a table; see `writer`."""
        with self.writer(name, table.schema) as writer:
            writer.write_table(table)

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Be the only run that writes to this folder, from which drafts of a killed run are removed."""
        name = repr(str(self.folder))
        try:
            file = locked(self.folder / LOCK)
        except OSError as error:
            raise UsageError(f"{name} cannot be written to ({error.strerror}); give another folder") from None
        if file is None:
            raise UsageError(f"another run writes its results to {name}; wait until it has ended, or give another "
                             "folder")  # fmt: skip
        with file:
            for draft in (*self.folder.glob(DRAFTS), *(self.folder / PARTS).glob(DRAFTS)):
                draft.unlink()
            yield

    def put_files(self, rows: list[Plain], choices: Plain) -> None:
        """Write the table of files, with the recipe and the version in its metadata."""
        names = dict.fromkeys(name for row in rows for name in row)
        about = {"allanite": __version__, "recipe": json.dumps(choices, sort_keys=True)}
        self.write(FILES, pa.Table.from_pylist(shown(rows), schema=_schema(names).with_metadata(about)))

    def files(self) -> tuple[list[Plain], Plain, str]:
        """The rows of the table of files, the recipe, and the version."""
        try:
            with in_utf8(self.folder / FILES) as file:
                table = parquet.read_table(file)
            if not len(table) or not {"file", *OWN} <= set(table.column_names):
                raise KeyError("file")
            if not table.schema.equals(_schema(table.column_names)):
                raise TypeError(table.schema)
            about = table.schema.metadata
            choices = Recipe.from_dict(json.loads(about[b"recipe"])).to_dict()
            return table.to_pylist(), choices, about[b"allanite"].decode()
        except (OSError, pa.ArrowInvalid) as error:
            why = reason(error)
        except (KeyError, TypeError, ValueError, RecursionError, UsageError):
            why = "it is not the table of a batch"
        raise DataError(f"{str(self.folder / FILES)!r} cannot be read ({why}); run the batch again")


def shown(rows: Iterable[Plain]) -> list[Plain]:
    """Rows of a table, whose names that are not UTF-8 are as they are shown."""
    return [{k: encoded(v).decode() if isinstance(v, str) else v for k, v in row.items()} for row in rows]


def _schema(names: Iterable[str]) -> Any:
    """Names and types of the table of files."""
    special = {TEMPERATURE: pa.float64(), DATE: pa.timestamp("us")}
    return pa.schema([(name, special.get(name, pa.string())) for name in names])


def _digest(row: Mapping[str, Any]) -> bytes:
    return hashlib.sha256(repr(sorted(row.items())).encode()).hexdigest().encode()


def dumps(data: Any) -> str:
    """Plain data as JSON in which phrases keep how they were made, so that a result is shown in any language."""
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
