"""Where a live stream comes from, and the file in which it is kept and read as any other."""

import ipaddress
import os
import queue
import select
import socket
import stat
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from allanite.core.errors import DataError, UsageError, demand_extra
from allanite.core.files import demand_writable
from allanite.phrases.phrase import say

from .sandbox.source import NamedPath

PIECE = 1 << 16  # bytes that are taken at a time
WAIT = 0.2  # seconds to wait for data at a time
PIECES_AHEAD = 16  # pieces of a file that are read before they are needed
DATAGRAM_ROOM = 1 << 22  # bytes of datagrams that the system is asked to hold


@dataclass(frozen=True)
class Tap:
    """An open source."""

    # waits so many seconds at most and returns what came, b"" if nothing did; OSError where the source is gone, as a
    # device is that was unplugged
    take: Callable[[float], bytes]
    close: Callable[[], None]
    live: bool = True  # what comes is lost if nobody takes it


class Feed:
    """Takes from a source in a thread of its own, so that nothing is lost while something else is computed."""

    def __init__(self, tap: Tap) -> None:
        self.tap, self.closing = tap, False
        self.pieces: queue.Queue[bytes | Exception] = queue.Queue(0 if tap.live else PIECES_AHEAD)
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def take(self, seconds: float) -> bytes:
        """What came, b"" if nothing does for so long; the error with which it ended."""
        try:
            piece = self.pieces.get(timeout=seconds)
        except queue.Empty:
            return b""
        if isinstance(piece, Exception):
            raise piece
        return piece

    def close(self) -> list[bytes]:
        """Stop taking; what came and was not taken yet."""
        self.closing, rest = True, self._rest()
        while self.thread.is_alive():
            self.thread.join(WAIT)
            rest += self._rest()
        self.tap.close()
        return rest + self._rest()

    def _rest(self) -> list[bytes]:
        pieces = []
        while not self.pieces.empty():
            pieces.append(self.pieces.get_nowait())
        return [piece for piece in pieces if isinstance(piece, bytes)]

    def _run(self) -> None:
        while not self.closing:
            try:
                data = self.tap.take(WAIT)
            except (OSError, DataError) as error:
                self.pieces.put(error)
                return
            if data:
                self.pieces.put(data)


def opened(target: str, baud: int) -> Tap:
    """Open FILE, PORT or udp://127.0.0.1:9000."""
    if "://" in target:
        return _datagrams(target)
    try:
        serial = stat.S_ISCHR(os.stat(target).st_mode)
    except OSError as error:
        if os.name == "nt" and target.upper().startswith("COM"):
            return _line(target, baud)
        raise DataError(say("{target!r} cannot be watched: {reason}", target=target, reason=error.strerror)) from None
    return _line(target, baud) if serial else _file(target)


def _datagrams(target: str) -> Tap:
    parts = urlsplit(target)
    if parts.scheme != "udp" or parts.hostname is None or parts.port is None:
        raise UsageError(f"{target!r} is no address to listen at; give a file, a serial port, or udp://127.0.0.1:9000")
    host = "127.0.0.1" if parts.hostname == "localhost" else parts.hostname
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        address = None
    if address is None or not address.is_loopback:
        raise UsageError(
            f"datagrams are taken from this machine only, not at {parts.hostname!r}; listen at udp://127.0.0.1:"
            f"{parts.port}, and let a program on this machine pass on what comes from others"
        )
    line = socket.socket(socket.AF_INET6 if address.version == 6 else socket.AF_INET, socket.SOCK_DGRAM)
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, DATAGRAM_ROOM)
    try:
        line.bind((host, parts.port))
    except OSError as error:
        line.close()
        raise DataError(say("{target!r} cannot be watched: {reason}", target=target, reason=error.strerror)) from None

    def take(seconds: float) -> bytes:
        line.settimeout(seconds)
        try:
            datagram = line.recv(PIECE)
        except TimeoutError:
            return b""
        return datagram if datagram.endswith(b"\n") else datagram + b"\n"  # a datagram holds whole lines

    return Tap(take, line.close)


def _line(target: str, baud: int) -> Tap:
    demand_extra("live", "serial", what=f"a serial line such as {target!r}")
    import serial

    try:
        port = serial.Serial(target, baud, timeout=0)
    except (OSError, ValueError) as error:
        raise DataError(say("{target!r} cannot be watched: {reason}", target=target, reason=str(error))) from None

    def take(seconds: float) -> bytes:
        if os.name == "nt":
            port.timeout = seconds
            return bytes(port.read(max(port.in_waiting, 1)))
        ready, _, _ = select.select([port.fd], [], [], seconds)
        if not ready:
            return b""
        data = os.read(port.fd, PIECE)
        if not data:
            raise OSError("the device is gone")
        return data

    return Tap(take, port.close)


def _file(target: str) -> Tap:
    file = open(target, "rb")  # noqa: SIM115 - closed by the one who takes from it

    def take(seconds: float) -> bytes:
        data = file.read(PIECE)
        if not data:
            time.sleep(seconds)
            if os.stat(target).st_size < file.tell():
                raise DataError(say("{target!r} became shorter while it was watched", target=target))
        return data

    return Tap(take, file.close, live=False)


LONGEST_ROW = 1 << 16  # bytes of a line, beyond which it is not one of text
TAIL = 1 << 16  # rows at the end that can be read apart from the others


class Spool:
    """A text file of the lines that came; a line that is not complete waits for the rest of it."""

    # with `sent`, the lines are those of a port, where bytes get lost: what comes before the first two rows of one
    # length is kept as headings only where it is no torn row, and a later line with another number of fields, or words
    # where the others have numbers, is a row of missing samples; messages and results call it by `source_name`
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
        self.rows = self.came = 0  # lines since the first row, and bytes

    def __fspath__(self) -> str:
        return self.path

    @property
    def width(self) -> int:
        """Fields of a row."""
        return len(self._model)

    def add(self, data: bytes) -> None:
        """Add what came."""
        self.came += len(data)
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > LONGEST_ROW:
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
            empty = not line.strip() and self.width > 1  # of a single column it is a missing sample
            good = not self.sent or empty or self._form(line) == self._model
            self.rows += not empty
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
