"""The process that opens an HDF5 file for us, and what may become of it."""

import json
import math
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.readers.columns.arrays import RATE_NAMES
from allanite.readers.columns.description import KEY

from .guard import library, most

WAIT, SPEED = 20.0, 5e6
"""Seconds that an answer may take, and the bytes that a slow disk gives in one: the processor time is bound below."""


_TIMEOUTS = (9, 24)
"""Signals by which we stop a process, and by which the system stops one that has used its time."""


class Process:
    """A running worker; use it in a ``with`` statement. `said` is what the file holds."""

    def __init__(self, path: str) -> None:
        library("h5py", "hdf5")
        worker = str(Path(__file__).with_name("hdf5_worker.py"))
        arguments = [str(Path(path).absolute()), str(most(path)), ",".join(RATE_NAMES), KEY]
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  closed by __exit__
        # -P: the folder of the worker has modules whose names are those of others
        self._process = subprocess.Popen(  # noqa: S603  our own program, and no shell
            [sys.executable, "-P", worker, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
        )

    def __enter__(self) -> "Process":
        try:
            self.said: dict[str, Any] = self._listing()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()
        self._errors.close()

    def load(self, path: str, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
        """A dataset, or those fields of it that are in `dtype`.

        Raises
        ------
        DataError
            The library broke down over it.
        """
        size = math.prod(shape) * dtype.itemsize
        array = np.empty(size, np.uint8)
        request = json.dumps({"path": path, "fields": list(dtype.names or ())})
        with self._deadline(WAIT + size / SPEED):
            self._ask(request)
            filled, view = 0, array.data
            while filled < size and (count := self._read_into(view[filled:])):
                filled += count
        if filled < size:
            raise self._broken(f"over {path!r}")
        return array.view(dtype).reshape(shape)

    def _ask(self, request: str) -> None:
        try:
            self._stdin.write(request.encode() + b"\n")
            self._stdin.flush()
        except OSError:
            pass  # it is gone already, which the answer shows

    def _read_into(self, view: memoryview) -> int:
        return int(self._stdout.readinto(view) or 0)

    @property
    def _stdin(self) -> Any:
        return self._process.stdin

    @property
    def _stdout(self) -> Any:
        return self._process.stdout

    def _listing(self) -> dict[str, Any]:
        with self._deadline(WAIT):
            line = self._stdout.readline(1 << 24)
        if not line.endswith(b"\n"):
            raise self._broken("over its structure")
        return dict(json.loads(line))

    def _deadline(self, seconds: float) -> "_Deadline":
        return _Deadline(self._process, seconds)

    def _broken(self, where: str) -> DataError:
        """Why the worker ended, in words: what it said last, or how it died."""
        code = self._process.wait()
        self._errors.seek(0)
        said = self._errors.read()[-4000:].decode("utf-8", "replace").strip().splitlines()
        died = "it ended early" if code >= 0 else "it took too long" if -code in _TIMEOUTS else f"signal {-code}"
        reason = said[-1][:200] if said else died
        return DataError(
            f"the file is damaged or was cut off: the HDF5 library gave up {where}: {reason}; if other programs read "
            "it, write it again with h5repack"
        )


class _Deadline:
    """Kills a process that has not answered in time."""

    def __init__(self, process: "subprocess.Popen[bytes]", seconds: float) -> None:
        self._timer = threading.Timer(seconds, process.kill)
        self._timer.daemon = True

    def __enter__(self) -> None:
        self._timer.start()

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()
