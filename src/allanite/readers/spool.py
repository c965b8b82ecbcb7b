"""Spool: what a live source sends, kept in a file that is read as any other."""

import os
import tempfile
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from allanite.core.errors import UsageError
from allanite.core.files import demand_writable

from .sandbox.source import NamedPath

LONGEST = 1 << 16
"""Bytes of a line, beyond which it is not one of text."""

TAIL = 1 << 16
"""Rows at the end that can be read apart from the others."""


class Spool:
    """A text file of the lines that came; a line that is not complete waits for the rest of it.

    With `sent`, the lines are those of a port, where bytes get lost: what comes before the first two rows of one
    length is kept as headings only where it is no torn row, and a later line with another number of fields, or words
    where the others have numbers, is a row of missing samples.

    Attributes
    ----------
    source_name : str
        What messages and results call it.
    rows, came : int
        Lines since the first row, and bytes that came.
    """

    def __init__(self, source_name: str, path: str | None = None, *, sent: bool = True) -> None:
        self.source_name, self.sent = source_name, sent
        suffix = os.path.splitext(source_name)[1].lower() if os.path.isfile(source_name) else ".txt"
        self._own = path is None
        if path is None:
            handle, self.path = tempfile.mkstemp(prefix="allanite-", suffix=suffix)
            os.close(handle)
        else:
            demand_writable(path)
            self.path = path
        # a file that the user names is a new one; without a buffer, what is written is there
        self._file = open(self.path, "wb" if self._own else "xb", buffering=0)  # noqa: SIM115 - closed by close
        self._size = 0
        self._rest, self._head = b"", list[bytes]()
        self._model: list[bool] = []
        self._between: bytes | None = None
        self._last: deque[bytes] = deque(maxlen=TAIL)
        self.rows = self.came = 0

    def __fspath__(self) -> str:
        return self.path

    def add(self, data: bytes) -> None:
        """Add what came."""
        self.came += len(data)
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > LONGEST:
            raise UsageError("what comes has no lines; send lines of numbers, with commas or blanks between them")
        self._write([kept for line in lines for kept in self._kept(line)])

    def torn(self) -> None:
        """Forget the line that will not be completed."""
        self._rest = b""

    def finish(self) -> None:
        """Take the last line of a file, which may end without a newline, if it is a whole row."""
        if self._rest and not self.sent and self._form(self._rest) == self._model:
            self.add(b"\n")

    def skip(self, rows: int) -> None:
        """Add rows of missing samples."""
        if self._model:
            for begin in range(0, rows, TAIL):
                self._write([self._missing()] * min(TAIL, rows - begin))

    def tail(self, rows: int) -> tuple[bytes, int]:
        """The headings and the last rows, and how many rows are before them; no bytes while there is no row."""
        last = list(self._last)[-rows:] if rows < len(self._last) else list(self._last)
        text = b"\n".join((*self._head, *last, b"")) if last else b""
        return text, self.rows - len(last)

    @contextmanager
    def beside(self, text: bytes) -> Iterator[NamedPath]:
        """A file with this text, and the suffix of the spool."""
        with tempfile.TemporaryDirectory(prefix="allanite-") as folder:
            path = Path(folder, f"recent{os.path.splitext(self.path)[1]}")
            path.write_bytes(text)
            yield NamedPath(str(path), self.source_name)

    def keep(self) -> None:
        """Leave the file where it is."""
        self._own = False

    def close(self) -> None:
        """Remove the file, unless it is kept or the user has given its name."""
        self._file.close()
        if self._own:
            Path(self.path).unlink(missing_ok=True)

    def _write(self, lines: list[bytes]) -> None:
        left = memoryview(b"\n".join((*lines, b"")) if lines else b"")
        size = self._size + len(left)
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError:
            self._file.truncate(self._size)
            self._file.seek(self._size)
            raise
        self._size = size

    def _kept(self, line: bytes) -> list[bytes]:
        """The lines to write when one more has come."""
        if self._model:
            good = not self.sent or not line.strip() or self._form(line) == self._model
            self.rows += bool(line.strip())
            self._last.append(line if good else self._missing())
            return [self._last[-1]]
        form, before = self._form(line), self._head[-1:] and self._form(self._head[-1])
        self._head.append(line)
        if not (any(form) and form == before):
            return []
        # two rows of one form: what is above them are headings, without rows that were torn
        *head, first, second = self._head
        self._head = [line for line in head if not (self.sent and any(self._form(line)))]
        self._model, self.rows = form, 2
        self._last.extend((first, second))
        return [*self._head, first, second]

    def _form(self, line: bytes) -> list[bool]:
        """Which fields of a line are numbers."""
        if not self._model:
            self._between = next((mark for mark in (b",", b";", b"\t") if mark in line), None)
        return [_is_number(field) for field in line.split(self._between)]

    def _missing(self) -> bytes:
        return (self._between or b" ").join([b"nan"] * len(self._model))


def _is_number(field: bytes) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True
