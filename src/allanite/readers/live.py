"""Where a live stream comes from: a port, a file that grows, a pipe, or datagrams."""

import ipaddress
import os
import queue
import select
import socket
import stat
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from urllib.parse import urlsplit

from allanite.core.errors import DataError, UsageError, demand_extra, given
from allanite.core.files import reason
from allanite.phrases.phrase import say

PIECE = 1 << 16  # bytes that are taken at a time
WAIT = 0.2  # seconds to wait for data at a time
PIECES_AHEAD = 512  # pieces of a file or a pipe that are read before they are needed: minutes of six axes at 1 kHz
DATAGRAM_ROOM = 1 << 22  # bytes of datagrams that the system is asked to hold
TRACE = 64  # bytes before a place in a file, by which it is recognized
LATEST_END = 25  # times `WAIT` after which a source that does not answer is left to itself


@dataclass(frozen=True)
class Tap:
    """An open source."""

    # waits so many seconds at most and returns what came, b"" if nothing did; OSError where the source is gone, as a
    # device is that was unplugged
    take: Callable[[float], bytes]
    close: Callable[[], None]
    live: bool = True  # what comes is lost if nobody takes it
    ahead: int = 0  # pieces, at most, that are taken before they are needed, where whoever sends can wait


class BreakError(OSError):
    """A source goes on after this, but a line may be torn: it is `gone`, `back`, or another file (`rotated`)."""

    def __init__(self, kind: str, why: str = "") -> None:
        super().__init__(why)
        self.kind, self.lost = kind, 0  # rows that were not taken meanwhile

    def words(self, target: str) -> str:
        """What happened to this source; empty if only a line is torn."""
        if self.kind == "gone":
            return say("{target!r} is gone ({reason}); waiting for it", target=target, reason=str(self))
        if self.kind == "rotated":
            return say("{target!r} became shorter or was replaced; it is read from its beginning, and rows without "
                       "time stamps are joined without a gap", target=target)  # fmt: skip
        if self.kind == "back" and self.lost:
            return say("{target!r} is back; {lost} samples are missing", target=target, lost=self.lost)
        return say("{target!r} is back", target=target) if self.kind == "back" else ""


class ReturningSource:
    """A source that is opened again when it is gone, and is back when something comes of it."""

    def __init__(self, again: Callable[[], Tap]) -> None:
        self.again, self.gone, self.held = again, False, b""
        self.tap: Tap | None = again()

    def take(self, seconds: float) -> bytes:
        """What a tap takes; a `BreakError` where it is gone, and where it is back."""
        data, self.held = self.held, b""
        if data:
            return data
        try:
            self.tap = self.tap or self.again()
            data = self.tap.take(seconds)
        except BreakError:
            raise
        except (OSError, ValueError) as error:  # the second one of a descriptor that is closed, and of data
            self.close()
            if self.gone:
                time.sleep(seconds)
                return b""
            self.gone = True
            raise BreakError("gone", reason(error)) from None
        if data and self.gone:
            self.gone, self.held = False, data
            raise BreakError("back")
        return data

    def close(self) -> None:
        """Close it."""
        tap, self.tap = self.tap, None
        if tap is not None:
            with suppress(OSError):
                tap.close()


class Feed:
    """Takes from a source in a thread of its own, so that nothing is lost while something else is computed."""

    def __init__(self, tap: Tap) -> None:
        self.tap, self.closing = tap, False
        self.pieces: queue.Queue[bytes | Exception] = queue.Queue(tap.ahead)
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def take(self, seconds: float) -> bytes:
        """What came, b"" if nothing does; a `BreakError`, after which it goes on, or the error that ends it."""
        try:
            piece = self.pieces.get(timeout=seconds)
        except queue.Empty:
            return b""
        if isinstance(piece, Exception):
            raise piece
        return piece

    def close(self) -> list[bytes | BreakError]:
        """Stop taking; what came and was not taken yet."""
        self.closing, rest = True, self._rest()
        for _ in range(LATEST_END):  # a file of a network that is gone may never answer
            self.thread.join(WAIT)
            rest += self._rest()
            if not self.thread.is_alive():
                self.tap.close()
                break
        return rest + self._rest()

    def _rest(self) -> list[bytes | BreakError]:
        pieces = [self.pieces.get_nowait() for _ in range(self.pieces.qsize())]
        return [piece for piece in pieces if isinstance(piece, (bytes, BreakError))]

    def _run(self) -> None:
        while not self.closing:
            try:
                data = self.tap.take(WAIT)
            except BreakError as what:
                self.pieces.put(what)
                continue
            except Exception as error:  # whoever takes from it hears of it, and does not wait for ever
                self.pieces.put(error)
                return
            if data:
                self.pieces.put(data)


def arrivals(feed: Feed, duration: float, idle: float,
             stopped: Callable[[], bool]) -> Iterator[tuple[list[bytes | BreakError], bool]]:  # fmt: skip
    """What comes of a source, and whether this is the end: it is stopped, or `duration` or `idle`, s, are over."""
    begun = last = time.monotonic()
    over = False
    while not over:
        pieces = list[bytes | BreakError]()
        try:
            pieces.append(feed.take(WAIT))
        except BreakError as what:
            pieces.append(what)
        now = time.monotonic()
        last = now if any(piece if isinstance(piece, bytes) else piece.kind == "back" for piece in pieces) else last
        over = stopped() or now - begun >= duration or now - last >= idle
        yield pieces + (feed.close() if over else []), over


def opened(target: str, baud: int) -> Tap:
    """Open FILE, PORT or udp://127.0.0.1:9000; what is gone later is opened again."""
    again, live, ahead = _kind(target, baud)
    source = ReturningSource(again)
    return Tap(source.take, source.close, live, ahead)


def _kind(target: str, baud: int) -> tuple[Callable[[], Tap], bool, int]:
    """What opens this target, and what the tap of it says of it."""
    if "://" in target:
        return (lambda: _datagrams(target)), True, 0
    try:
        mode = os.stat(target).st_mode
    except (OSError, ValueError) as error:
        if not (os.name == "nt" and target.upper().startswith("COM")):
            raise _unwatched(target, error) from None
        mode = stat.S_IFCHR
    if stat.S_ISCHR(mode):
        return (lambda: _line(target, baud)), True, 0
    if stat.S_ISFIFO(mode):
        return (lambda: _pipe(target)), True, PIECES_AHEAD
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a socket or a disk"
        raise UsageError(f"{given(target)} is {what}; give a file, a serial port, a pipe, or udp://127.0.0.1:9000")
    return GrowingFile(target).tap, False, PIECES_AHEAD


def _unwatched(target: str, error: OSError | ValueError) -> DataError:
    return DataError(say("{target!r} cannot be watched: {reason}", target=target, reason=reason(error)))


def _datagrams(target: str) -> Tap:
    try:
        parts = urlsplit(target)
        name = (parts.scheme == "udp" and parts.port and parts.hostname) or ""
    except ValueError:  # a port beyond 65535, or half an address of version 6
        name = ""
    if not name:
        raise UsageError(f"{given(target)} is no address to listen at; give a file, a serial port, or "
                         "udp://127.0.0.1:9000, with a port from 1 to 65535")  # fmt: skip
    host = "127.0.0.1" if name == "localhost" else name
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        address = None
    if address is None or not address.is_loopback:
        raise UsageError(
            f"datagrams are taken from this machine only, not at {name!r}; listen at udp://127.0.0.1:"
            f"{parts.port}, and let a program on this machine pass on what comes from others"
        )
    line = socket.socket(socket.AF_INET6 if address.version == 6 else socket.AF_INET, socket.SOCK_DGRAM)
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, DATAGRAM_ROOM)
    try:
        line.bind((host, parts.port))
    except OSError as error:
        line.close()
        raise _unwatched(target, error) from None

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
        raise _unwatched(target, error) from None

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


def _pipe(target: str) -> Tap:
    line, came = _handle(target), False

    def take(seconds: float) -> bytes:
        nonlocal came
        data = os.read(line, PIECE) if select.select([line], [], [], seconds)[0] else None
        torn, came = came and data == b"", bool(data) or (came and data is None)
        if data == b"":  # no program writes to it
            time.sleep(seconds)
        if torn:
            raise BreakError("torn")
        return data or b""

    return Tap(take, lambda: os.close(line))


def _handle(target: str) -> int:
    """A file that is open to be read, without waiting for whoever writes to it."""
    try:
        return os.open(target, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except OSError as error:
        raise _unwatched(target, error) from None


class GrowingFile:
    """A file that grows, followed by its name: where it becomes shorter or is replaced, it is read from its begin."""

    def __init__(self, target: str) -> None:
        self.target, self.file = target, -1
        self.key: tuple[int, int] | None = None
        self.place, self.trace = 0, b""

    def tap(self) -> Tap:
        """Open it, where it was read to if it is the same."""
        self._open()
        return Tap(self.take, lambda: os.close(self.file))

    def take(self, seconds: float) -> bytes:
        """The bytes that were added; a `BreakError` where they are those of another file."""
        if self._other():  # it became shorter, and may have grown again
            self._from_begin()
            raise BreakError("rotated")
        data = os.read(self.file, PIECE)
        self.place, self.trace = self.place + len(data), (self.trace + data)[-TRACE:]
        if data:
            return data
        time.sleep(seconds)
        status = os.fstat(self.file)
        try:
            named = os.stat(self.target)
        except FileNotFoundError:
            if status.st_nlink:  # it was renamed, and whoever writes to it may go on
                return b""
            raise
        # another file takes its place when something is in it, and this one was read to its end
        if (named.st_dev, named.st_ino) != self.key and named.st_size and status.st_size == self.place:
            file = self.file
            self._open()
            os.close(file)
            raise BreakError("rotated")
        return b""

    def _open(self) -> None:
        file = _handle(self.target)
        if not stat.S_ISREG((status := os.fstat(file)).st_mode):
            os.close(file)
            raise OSError(f"{self.target!r} is no file any more")
        key, self.key, self.file = self.key, (status.st_dev, status.st_ino), file
        if key != self.key or self._other():
            self._from_begin()

    def _other(self) -> bool:
        """Whether what is before the place is not what was read."""
        os.lseek(self.file, self.place - len(self.trace), os.SEEK_SET)
        return os.read(self.file, len(self.trace)) != self.trace

    def _from_begin(self) -> None:
        os.lseek(self.file, 0, os.SEEK_SET)
        self.place, self.trace = 0, b""
