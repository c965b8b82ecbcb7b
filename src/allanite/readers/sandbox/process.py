"""The process that opens a file of a fragile format, what it may not do, and how it may end."""

import errno
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import threading
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import AllaniteError, DataError, demand_extra
from allanite.phrases.phrase import say

from .source import demand_directory, size_of

RATIO = 100  # bytes of samples per byte of a file: coarse samples compress 30-fold, a decompression bomb 1000-fold
UNPACKED_ROOM = 32 << 20  # bytes that any file may unpack to, whatever its size


class UnpackedPath(str):
    """The path of a file that was unpacked: its contents may not exceed the limit of the packing, or bombs multiply."""

    limit: int

    def __new__(cls, path: str, limit: int) -> "UnpackedPath":
        """The path, and the limit in bytes."""
        made = super().__new__(cls, path)
        made.limit = limit
        return made


def most(path: str) -> int:
    """Maximum size in bytes of the contents of a file, and of what is unpacked from it."""
    here = RATIO * size_of(path) + UNPACKED_ROOM
    return min(here, path.limit) if isinstance(path, UnpackedPath) else here


def demand_size(size: int, path: str, what: str) -> None:
    """Refuse a claimed size larger than the file can hold (`most`), before memory is allocated."""
    if size > most(path):
        raise DataError(f"{what} claims {size / 1e6:.6g} MB, over the {most(path) / 1e6:.3g} MB that a file of this "
                        f"size may unpack to ({RATIO} times its size): it is damaged or a decompression bomb; if it is "
                        "neither, write it again without compression")  # fmt: skip


def demand_members(path: str, what: str) -> list[zipfile.ZipInfo]:
    """The members of an archive, whose directory may not claim more than the file can hold."""
    demand_directory(path)
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    demand_size(sum(member.file_size for member in members), path, what)
    return members


DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # errors of a disk that is full, or of a limit that was set


@contextmanager
def worded(what: str = "the file") -> Iterator[None]:
    """Any exception of a library about a damaged file becomes a `DataError`."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # odd but harmless properties of the file
            yield
    except (AllaniteError, MemoryError, NameError):  # the last one is a bug of ours, whatever the file
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno in DISK:
            reason = error.strerror or str(error)
            raise DataError(f"there is no room for {what} in the folder {tempfile.gettempdir()!r} ({reason}): free "
                            "some, or set TMPDIR to another folder") from None  # fmt: skip
        raise DataError(f"{what} is damaged or was cut off; copy or download it again") from None


def demand_start(head: bytes, starts: tuple[bytes, ...], what: str) -> None:
    """Refuse a file whose first bytes are none of `starts`, which files of a format begin with."""
    if not head.startswith(starts):
        raise DataError(say("the file does not begin like {what} (it begins with {head!r}); check that it is complete",
                            what=what, head=head[:8]))  # fmt: skip


Progress = Callable[[float], None]

ANSWER_TIME, DISK_SPEED = 20.0, 5e5
"""Seconds that an answer may take, and bytes per second of a slow disk; the processor time is limited separately."""


RECEIVED_BYTES = 1 << 20  # bytes of a dataset that are received at a time

SHARE_KEY = "share"
"""Key of a line in which a worker only tells which share of the structure it has read; see `worker.main`."""


class Library(NamedTuple):
    """What opens a format: the package, the extra that installs it, and advice for a file that it cannot open."""

    package: str
    extra: str
    remedy: str
    speed: float = DISK_SPEED  # of opening a file, bytes per second at least, on a slow disk


LIBRARIES = {
    "hdf5": Library("h5py", "hdf5", "rewrite it with h5repack"),
    "mat": Library("scipy", "", "save it again in MATLAB: save('again.mat', '-v7')"),
    "ulog": Library("pyulog", "ulog", "write its topics as CSV with ulog2csv and read that"),
    "xlsx": Library("openpyxl", "xlsx", "save the sheet with the samples as CSV and read that", 5e4),
    "tdms": Library("nptdms", "tdms", "write it again with LabVIEW or DIAdem, as one segment"),
    "mdf": Library("asammdf", "mdf", "export the signals as CSV"),
    "bag": Library("rosbags", "ros", "make its index again: rosbag reindex, ros2 bag reindex or mcap recover"),
    "r": Library("rdata", "r", "save only its numbers, for example saveRDS(as.matrix(x), 'again.rds')"),
}
"""One entry for each of `worker.FORMATS`."""

LIMIT = "too many "  # beginning of what a worker says of a sound file beyond its limits, with what to do

WORKER = Path(__file__).with_name("worker.py")

_TIMEOUTS = (9, 24)  # signals by which we stop a process, and by which the system stops one that has used its time


class Process:
    """A running worker that looks for `names`; in a ``with`` statement, `contents` are those of the file."""

    # `progress` is called with the share, 0 to 1, that has been read.
    def __init__(
        self, form: str, path: str, progress: Progress | None = None, names: Mapping[str, Any] | None = None
    ) -> None:
        self.path, self._library = path, LIBRARIES[form]
        self._tell = progress or (lambda share: None)
        demand_extra(self._library.extra, self._library.package)
        self._wait = ANSWER_TIME + size_of(path) / self._library.speed
        # what a library leaves when the process is ended, and what it says; both are removed by __exit__
        self._folder = tempfile.TemporaryDirectory(prefix="allanite-", ignore_cleanup_errors=True)
        self._errors = tempfile.TemporaryFile(dir=self._folder.name)  # noqa: SIM115
        # -P: modules in the folder of the worker have names of standard modules
        self._process = subprocess.Popen(  # noqa: S603  our own program, and no shell
            [
                sys.executable, "-P", str(WORKER), form,
                str(Path(path).absolute()), str(most(path)), json.dumps(names or {}), str(size_of(path)),
            ],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
            env=os.environ | dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self._folder.name),
        )  # fmt: skip
        self._stdout: Any = self._process.stdout

    def __enter__(self) -> "Process":
        try:
            self.contents: dict[str, Any] = {SHARE_KEY: 0.0}
            with self._deadline(self._wait):
                while SHARE_KEY in self.contents:
                    self._tell(self.contents[SHARE_KEY])
                    line = self._stdout.readline(1 << 24)
                    if not line.endswith(b"\n"):
                        raise self._broken("while reading its structure")
                    self.contents = dict(json.loads(line))
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()
        self._errors.close()
        self._folder.cleanup()

    def load(self, path: str, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
        """A dataset, or those of its fields that are in `dtype`."""
        array = np.empty(shape, dtype)
        data = array.reshape(-1).view(np.uint8)
        with self._sending(path, dtype, data.size):
            for begin in range(0, data.size, RECEIVED_BYTES):
                self._fill(data[begin : begin + RECEIVED_BYTES], path)
                self._tell(min(1.0, (begin + RECEIVED_BYTES) / data.size))
        return array

    def fields(self, path: str, count: int, dtype: np.dtype[Any]) -> dict[str, NDArray[Any]]:
        """Each field of a dataset of `count` rows; only a block of whole rows is in memory at a time."""
        columns = {name: np.empty(count, dtype[name]) for name in dtype.names or ()}
        rows = np.empty(min(count, max(1, RECEIVED_BYTES // dtype.itemsize)), dtype)
        with self._sending(path, dtype, count * dtype.itemsize):
            for begin in range(0, count, max(1, rows.size)):
                part = rows[: count - begin]
                self._fill(part.view(np.uint8), path)
                for name, values in columns.items():
                    values[begin : begin + part.size] = part[name]
                self._tell((begin + part.size) / count)
        return columns

    def parts(self, path: str, shape: tuple[int, ...], dtype: np.dtype[Any], rows: int) -> Iterator[NDArray[Any]]:
        """A dataset, or those of its fields that are in `dtype`, so many rows at a time."""
        with self._sending(path, dtype, math.prod(shape) * dtype.itemsize):
            for begin in range(0, shape[0], rows):
                part = np.empty((min(rows, shape[0] - begin), *shape[1:]), dtype)
                self._fill(part.reshape(-1).view(np.uint8), path)
                yield part

    @contextmanager
    def _sending(self, path: str, dtype: np.dtype[Any], size: int) -> Iterator[None]:
        """Ask for a dataset of `size` bytes, which must be here in time."""
        with self._deadline(self._wait + size / DISK_SPEED):
            stdin: Any = self._process.stdin
            try:
                stdin.write(json.dumps({"path": path, "fields": list(dtype.names or ())}).encode() + b"\n")
                stdin.flush()
            except OSError:
                pass  # it has ended already, which the answer shows
            yield

    def _fill(self, array: NDArray[np.uint8], path: str) -> None:
        """Fill an array with the next bytes of a dataset."""
        filled = 0
        while filled < array.size and (count := self._stdout.readinto(array.data[filled:])):
            filled += count
        if filled < array.size:
            raise self._broken(f"while reading {path!r}")

    @contextmanager
    def _deadline(self, seconds: float) -> Iterator[None]:
        """Kill a process that has not answered in time."""
        timer = threading.Timer(seconds, self._process.kill)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def _broken(self, where: str) -> DataError:
        """Why the worker ended, as text: its last message, or how it died."""
        code = self._process.wait()
        self._errors.seek(0)
        lines = self._errors.read()[-4000:].decode("utf-8", "replace").strip().splitlines()
        late = not lines and -code in _TIMEOUTS
        died = "it took too long" if late else "it ended early" if code >= 0 else f"signal {-code}"
        reason = re.sub(r"^[\w.]+(Error|Exception): ", "", lines[-1])[:200] if lines else died
        if reason.startswith(LIMIT):
            return DataError(reason)
        cause = "the file is damaged or incomplete" + (", or this computer is busy" if late else "")
        return DataError(f"{cause}: {self._library.package} failed {where}: {reason}; if other programs can read it, "
                         f"{self._library.remedy}")  # fmt: skip
