"""A reader: what it reads, in any parts, and what it says of a file that is cut off."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from allanite.core.errors import AllaniteError
from allanite.core.record import Recording
from allanite.readers.formats.registry import FormatReader
from allanite.readers.options import Options
from allanite.readers.parts import opened

PIECES = (4096, 7777)
"""Rows read at a time."""


def check_reader(module: FormatReader, path: str | os.PathLike[str], **choices: Any) -> None:
    """Check that a reader recognizes and reads a file, and refuses what is left of it in words.

    Parameters
    ----------
    module : module or object
        With TITLE, sniff and read.
    path : path
        A file of the format.
    **choices
        What the file does not say: fields of `Options`, such as ``rate=100.0``.

    Raises
    ------
    AssertionError
        It does not; the message says what.
    """
    missing = [name for name in ("TITLE", "sniff", "read") if not hasattr(module, name)]
    assert not missing, f"the reader has no {', '.join(missing)}"
    about, file = f"reader of {module.TITLE!r}:", Path(path)
    data = file.read_bytes()
    assert module.sniff(data[:4096], file.suffix), f"{about} sniff does not recognize {file.name}"
    recording = module.read(str(file), Options(**choices))
    assert isinstance(recording, Recording), f"{about} read returns a {type(recording).__name__}, not a Recording"
    assert len(recording), f"{about} the recording has no channel"
    for record in recording:
        assert record.rate > 0, f"{about} {record.name} has a sampling rate of {record.rate}"
        assert np.isfinite(record.values).any(), f"{about} {record.name} has no finite sample"
    if hasattr(module, "parts"):
        _check_parts(recording, file, choices, about)
    with tempfile.TemporaryDirectory() as folder:
        cut = Path(folder, f"cut{file.suffix}")
        for size in sorted({0, 1, 7, len(data) // 3, len(data) // 2, len(data) - 1}):
            cut.write_bytes(data[:size])
            try:
                module.read(str(cut), Options(**choices))
            except AllaniteError as error:
                if len(str(error)) < 10:
                    raise AssertionError(f"{about} cut off after {size} bytes, it says {str(error)!r}") from error
            except Exception as error:
                raise AssertionError(
                    f"{about} cut off after {size} bytes, it raises {error!r} instead of a DataError"
                ) from error


def _check_parts(whole: Recording, file: Path, choices: Mapping[str, Any], about: str) -> None:
    for rows in PIECES:
        with opened(file, "1B", choices) as reader:
            assert reader is not None, f"{about} it has parts, and is not read in parts"
            found: list[list[Any]] = [[] for _ in whole]
            for lost, columns in reader.pieces(rows):
                for pieces, values in zip(found, columns, strict=True):
                    pieces += [np.full(lost, np.nan), values]
        for record, pieces in zip(whole, found, strict=True):
            same = np.array_equal(np.concatenate(pieces), record.values, equal_nan=True)
            assert same, f"{about} {record.name} read {rows} rows at a time differs from the whole"
