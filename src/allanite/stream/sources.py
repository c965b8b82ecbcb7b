"""Where a live stream comes from: a file that grows, a serial line, datagrams on the loopback interface."""

import ipaddress
import os
import select
import socket
import stat
from collections.abc import Callable
from dataclasses import dataclass
from urllib.parse import urlsplit

from allanite.core.errors import DataError, UsageError
from allanite.core.language import say

PIECE = 1 << 16
"""Bytes that are taken at a time."""


@dataclass(frozen=True)
class Tap:
    """An open source.

    ``take(seconds)`` waits so long at most and returns what came, b"" if nothing did; OSError where the source is gone,
    as a device is that was unplugged. `live` says whether what comes is new, so that time that passes without data is
    time without samples.
    """

    take: Callable[[float], bytes]
    close: Callable[[], None]
    live: bool = True


def opened(target: str, baud: int) -> Tap:
    """Open FILE, PORT or udp://127.0.0.1:9000.

    Raises
    ------
    UsageError
        The address is not one of this machine, or not complete.
    DataError
        The file or port cannot be opened.
    """
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
    try:
        import serial
    except ImportError:
        raise UsageError(f"a serial line such as {target!r} needs pyserial: pip install 'allanite[live]'") from None
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
        import time

        found = file.read(PIECE)
        if not found:
            time.sleep(seconds)
            if os.stat(target).st_size < file.tell():
                raise DataError(say("{target!r} became shorter while it was watched", target=target))
        return found

    return Tap(take, file.close, live=False)
