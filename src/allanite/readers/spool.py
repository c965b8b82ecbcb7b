"""The lines of a live stream, kept in a text file that is read as any other."""

import math
import os
import tempfile
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.files import demand_writable, draft, reason
from allanite.phrases.phrase import say, spelled

from .live import BreakError
from .sandbox.source import NamedPath

LONGEST_ROW = 1 << 16  # bytes of a line, beyond which it is not one of text
TAIL = 1 << 16  # rows at the end that can be read apart from the others
ENOUGH = 64  # rows below which nothing is looked at, nor kept
HEADINGS = 1000  # lines, at most, that are kept of those that a port sends before its first rows


class Spool:
    """A text file of the lines that came; a line that is not complete waits for the rest of it."""

    # with `sent`, the lines are those of a port, where bytes get lost: what comes before the first two rows of one
    # length is kept as headings only where it is no torn row, and a later line with another number of fields, or words
    # where the others have numbers, is a row of missing samples, as it is of a file that was mended; messages and
    # results call it by `source_name`
    def __init__(self, source_name: str, path: str | None = None, *, sent: bool = True, force: bool = False) -> None:
        self.source_name, self.sent, self._strict = source_name, sent, sent
        suffix = os.path.splitext(source_name)[1].lower() if os.path.isfile(source_name) else ".txt"
        self.own, self.once = path is None, sent  # whether it is removed by `close`, and its lines come only once
        if path is not None:
            demand_writable(path, force=force)
            if os.path.exists(path) and not os.path.isfile(path):
                raise UsageError(f"{path!r} is a device or a pipe; give the name of a new file")
        try:
            if path is None:
                handle, path = tempfile.mkstemp(prefix="allanite-", suffix=suffix)
                os.close(handle)
            # a file that the user names is a new one; without a buffer, what is written is there
            self._file = open(path, "wb" if self.own or force else "xb", buffering=0)  # noqa: SIM115 - closed by close
        except OSError as error:
            raise UsageError(
                f"the lines that come cannot be kept in {path or 'the folder of temporary files'} ({reason(error)}); "
                f"free some space, or keep them elsewhere with {spelled('--record PATH', 'record=')}"
            ) from None
        self.path = path
        self._size = 0
        self._rest, self._head = b"", list[bytes]()
        self._model: list[bool] = []
        self._between: bytes | None = None
        self._last: deque[bytes] = deque(maxlen=TAIL)
        self.rows = self.came = 0  # lines since the first row, and bytes

    def __fspath__(self) -> str:
        return self.path

    @property
    def width(self) -> int:
        """Fields of a row."""
        return len(self._model)

    def keep(self, pieces: Sequence[bytes | BreakError], *, last: bool = False) -> str:
        """Add what came of a source; the words are empty unless the disk takes no more."""
        try:
            for piece in pieces:
                if isinstance(piece, BreakError):
                    self.torn(piece.lost)
                else:
                    self.add(piece)
            if last:
                self.finish()
        except OSError as error:
            return say("{path!r} takes no more lines ({reason}); the stream ends here", path=self.path,
                       reason=reason(error))  # fmt: skip
        return ""

    def add(self, data: bytes) -> None:
        """Add what came."""
        self.came += len(data)
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > LONGEST_ROW:
            if not self._model:
                raise UsageError("what comes has no lines; send lines of numbers, with commas or blanks between them")
            self._rest = self._rest[: LONGEST_ROW + 1]  # what is too long for a row will be one of missing samples
        self._write([kept for line in lines for kept in self._kept(line)])

    def torn(self, lost: int = 0) -> None:
        """The line that will not be completed is a row of missing samples, and so many more were lost."""
        rows, self._rest = lost + bool(self._rest.strip()), b""
        for begin in range(0, rows if self._model else 0, TAIL):
            self._write(self._counted([self._missing()] * min(TAIL, rows - begin)))

    def finish(self) -> None:
        """Take the last line of a file, which may end without a newline, if it is a whole row."""
        if self._rest and not self.sent and self._form(self._rest) == self._model:
            self.add(b"\n")

    @contextmanager
    def mended(self, error: DataError) -> Iterator[NamedPath]:
        """The file with missing samples in place of lines of another form; it is kept if it can be read within."""
        # the error remains if there are no such lines, or if they are not what it is about
        rows, changed = 0, False
        try:
            with draft(self.path, force=True) as part:
                with open(self.path, "rb") as old, part.open("wb") as new:
                    for place, line in enumerate(old):
                        row = line if place < len(self._head) else self._judged(line[:-1]) + b"\n"
                        rows += place >= len(self._head) and self._counts(row)
                        changed |= row != line
                        new.write(row)
                if self._strict or not (self._model and changed):
                    raise error
                yield NamedPath(str(part), self.source_name)
        except AllaniteError:  # of no lines of this kind, of something else, or of a disk that is full
            raise error from None
        self._file.close()
        self._file = open(self.path, "ab", buffering=0)  # noqa: SIM115 - closed by close
        self._strict, self._size, self.rows = True, os.path.getsize(self.path), rows
        self._last = deque(map(self._judged, self._last), TAIL)

    @contextmanager
    def recent(self, rows: int, *, mended: bool = False) -> Iterator[tuple[NamedPath, int]]:
        """A file of the headings and the last rows, empty while there is no row, and how many rows are before them."""
        last = list(self._last)[-rows:]
        text = b"\n".join((*self._head, *(map(self._judged, last) if mended else last), b"")) if last else b""
        with ExitStack() as stack:
            try:
                folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="allanite-"))
                path = Path(folder, f"recent{os.path.splitext(self.path)[1]}")
                path.write_bytes(text)
            except OSError as error:
                raise DataError(say("no temporary file can be written: {reason}", reason=reason(error))) from None
            yield NamedPath(str(path), self.source_name), self.rows - len(last)

    def stays(self) -> str:
        """Where the lines are left, if they come only once and were to be removed; else empty."""
        if not (self.own and self.once and self.rows >= ENOUGH):
            return ""
        self.own = False
        return self.path

    def close(self) -> None:
        """Remove the file, unless it is kept or the user has given its name."""
        self._file.close()
        if self.own:
            Path(self.path).unlink(missing_ok=True)

    def _write(self, lines: list[bytes]) -> None:
        unwritten = memoryview(b"\n".join((*lines, b"")) if lines else b"")
        size = self._size + len(unwritten)
        try:
            while unwritten:
                unwritten = unwritten[self._file.write(unwritten) :]
        except OSError:
            self._file.truncate(self._size)
            self._file.seek(self._size)
            raise
        self._size = size

    def _kept(self, line: bytes) -> list[bytes]:
        """The lines to write when one more has come."""
        if self._model:
            return self._counted([self._judged(line) if self._strict or len(line) > LONGEST_ROW else line])
        form, before = self._form(line), self._head[-1:] and self._form(self._head[-1])
        self._head.append(line)
        if self.sent:
            del self._head[:-HEADINGS]
        if not (any(form) and form == before):
            return []
        # two rows of one form: what is above them are headings, without rows that were torn
        *head, first, second = self._head
        self._head = [line for line in head if not (self.sent and any(self._form(line)))]
        self._model = form
        return self._head + self._counted([first, second])

    def _counted(self, lines: list[bytes]) -> list[bytes]:
        """The lines after the headings, which are rows from now on."""
        self.rows += sum(map(self._counts, lines))
        self._last.extend(lines)
        return lines

    def _judged(self, line: bytes) -> bytes:
        """The line, or a row of missing samples where it is none; a heading that comes again is no line at all."""
        if line in self._head:
            return b""
        empty = not line.strip() and not (self.sent and self.width == 1)
        good = empty or (len(line) <= LONGEST_ROW and b"\0" not in line and self._form(line) == self._model)
        return line if good else self._missing()

    def _counts(self, line: bytes) -> bool:
        """Whether a line is a row: of a single column, an empty one is a missing sample."""
        return bool(line.strip()) or self.width == 1

    def _form(self, line: bytes) -> list[bool]:
        """Which fields of a line are numbers."""
        if not self._model:
            self._between = next((mark for mark in (b";", b"\t", b",") if mark in line), None)
        return [_is_number(field) for field in line.split(self._between)]

    def _missing(self) -> bytes:
        return (self._between or b" ").join([b"nan"] * len(self._model))


def _is_number(field: bytes) -> bool:
    try:
        return not math.isinf(float(field.replace(b",", b".")))
    except ValueError:
        return False
