"""A reader: what it reads, and what it says of a file that is cut off."""

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.errors import AllaniteError
from allanite.core.record import Recording
from allanite.readers.formats.registry import FormatReader
from allanite.readers.options import Options


@public
def check_reader(module: FormatReader, path: str | os.PathLike[str], **choices: Any) -> None:
    r"""Check that a reader recognizes and reads a file, and says what is wrong with one that is cut off.

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
        It does not: ``reader of 'tones of a recorder': cut off after 7 bytes, it raises ValueError() instead of a
        DataError``.

    Examples
    --------
    >>> from allanite.readers.formats import text
    >>> path = Path(tempfile.mkdtemp(), "gyro.csv")
    >>> size = path.write_text("gz [deg/s]\n" + "0.5\n0.25\n" * 20)
    >>> check_reader(text, path, rate=100.0)
    """
    missing = [name for name in ("TITLE", "sniff", "read") if not hasattr(module, name)]
    assert not missing, f"the reader has no {', '.join(missing)}"
    about, file = f"reader of {module.TITLE!r}:", Path(path)
    data = file.read_bytes()
    known = "dtype" in choices or module.sniff(data[:4096], file.suffix)
    assert known, f"{about} sniff does not recognize {file.name}"
    recording = module.read(str(file), Options(**choices))
    assert isinstance(recording, Recording), f"{about} read returns a {type(recording).__name__}, not a Recording"
    assert len(recording), f"{about} the recording has no channel"
    for record in recording:
        assert record.rate > 0, f"{about} {record.name} has a sampling rate of {record.rate}"
        assert np.isfinite(record.values).any(), f"{about} {record.name} has no finite sample"
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
