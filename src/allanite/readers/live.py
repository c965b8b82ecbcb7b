"""Where a live stream comes from: a file that grows, a serial line, datagrams on the loopback interface."""

import ipaddress
import os
import queue
import select
import socket
import stat
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from urllib.parse import urlsplit

from allanite.core.errors import DataError, UsageError
from allanite.core.extras import demand_extra
from allanite.phrases.phrase import say

PIECE = 1 << 16
"""Bytes that are taken at a time."""

WAIT = 0.2
"""Seconds to wait for data at a time."""

AHEAD = 16
"""Pieces of a file that are read before they are needed."""

ROOM = 1 << 22
"""Bytes of datagrams that the system is asked to hold."""


@dataclass(frozen=True)
class Tap:
    """An open source.

    ``take(seconds)`` waits so long at most and returns what came, b"" if nothing did; OSError where the source is gone,
    as a device is that was unplugged. What comes `live` is lost if nobody takes it.
    """

    take: Callable[[float], bytes]
    close: Callable[[], None]
    live: bool = True


class Feed:
    """Takes from a source in a thread of its own, so that nothing is lost while something else is computed."""

    def __init__(self, tap: Tap) -> None:
        self.tap, self.closing = tap, False
        self.pieces: queue.Queue[bytes | Exception] = queue.Queue(0 if tap.live else AHEAD)
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def take(self, seconds: float) -> bytes:
        """What came, b"" if nothing does for so long; the error with which it ended."""
        try:
            found = self.pieces.get(timeout=seconds)
        except queue.Empty:
            return b""
        if isinstance(found, Exception):
            raise found
        return found

    def close(self) -> list[bytes]:
        """Stop taking; what came and was not taken yet."""
        self.closing, rest = True, self._rest()
        while self.thread.is_alive():
            self.thread.join(WAIT)
            rest += self._rest()
        self.tap.close()
        return rest + self._rest()

    def _rest(self) -> list[bytes]:
        found = []
        while not self.pieces.empty():
            found.append(self.pieces.get_nowait())
        return [piece for piece in found if isinstance(piece, bytes)]

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
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM)
    try:
        line.bind((host, parts.port))
    except OSError as error:
        line.close()
        raise DataError(say("{target!r} cannot be watched: {reason}", target=target, reason=error.strerror)) from None

    def take(seconds: float) -> bytes:
        line.settimeout(seconds)
        try:
            found = line.recv(PIECE)
        except TimeoutError:
            return b""
        return found if found.endswith(b"\n") else found + b"\n"  # a datagram holds whole lines

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
        found = os.read(port.fd, PIECE)
        if not found:
            raise OSError("the device is gone")
        return found

    return Tap(take, port.close)


def _file(target: str) -> Tap:
    file = open(target, "rb")  # noqa: SIM115 - closed by the one who takes from it

    def take(seconds: float) -> bytes:
        found = file.read(PIECE)
        if not found:
            time.sleep(seconds)
            if os.stat(target).st_size < file.tell():
                raise DataError(say("{target!r} became shorter while it was watched", target=target))
        return found

    return Tap(take, file.close, live=False)
