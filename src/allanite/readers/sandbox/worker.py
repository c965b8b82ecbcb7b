"""Program that opens one file in a process of its own: on damaged files the libraries crash, hang or exhaust memory.

It prints a line of JSON with the contents of the file, before it perhaps lines with the `share` that has been read;
then, for each line with the JSON of a request, the bytes of a dataset. Memory and processor time are limited, and
nothing in a file is executed or unpickled. The process is independent: it is started by its path and imports nothing
of this package.
"""

import json
import os
import runpy
import sys
from collections.abc import Iterable
from typing import Any

FORMATS = {"hdf5": 1e6, "mat": 2e6, "r": 1e6, "ulog": 2e6, "xlsx": 1e5, "tdms": 2e6, "mdf": 2e6, "bag": 1e6}
"""Formats, opened by ``opened`` of the file ``<format>_contents.py`` beside this one, and the bytes of a file processed
per second at least; of HDF5 those of empty datasets, which are listed without being read.
"""

SECONDS, SPEED = 1, 20e6  # seconds for opening any file, and the bytes of a dataset sent per second at least
ROOM = 48 << 20  # bytes that a library may allocate beyond those of the contents


def main() -> None:
    """Serve one file; the arguments are format, path, bytes that it may unpack to, names to look for, and its size."""
    # `opened(path, most, names)` returns the contents of the file as a dictionary for JSON, and a function that takes
    # the path and the fields of a dataset and returns its size in bytes, by which the time is limited, and an iterator
    # of its blocks.
    form, path, most, names = sys.argv[1], sys.argv[2], int(sys.argv[3]), json.loads(sys.argv[4])
    opened = runpy.run_path(os.path.join(os.path.dirname(__file__), f"{form}_contents.py"))["opened"]
    try:  # limit the memory that the process may use, and what it may write, such as what is unpacked to a file
        import resource

        size = most + ROOM
        with open("/proc/self/statm") as file:
            now = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (now + size, now + size))
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    except (ImportError, OSError, ValueError):
        pass  # the parent limits what it requests and how long it waits, on every system
    _allow(int(sys.argv[5]) / FORMATS[form])
    try:
        contents, load = opened(path, most, names)
        _send([json.dumps(contents).encode() + b"\n"])
        for line in sys.stdin:
            request = json.loads(line)
            size, blocks = load(request["path"], request["fields"])
            _allow(size / SPEED)
            _send(blocks)
    except MemoryError:
        sys.exit(f"it claims more than the {most / 1e6:.3g} MB that a file of this size may unpack to")


def _send(blocks: Iterable[Any]) -> None:
    for block in blocks:
        sys.stdout.buffer.write(block)
    sys.stdout.buffer.flush()


def _allow(seconds: float) -> None:
    """Limit the processor time until the next call, if the system supports it."""
    try:
        import resource
    except ImportError:
        return
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (int(used + SECONDS + seconds), hard))


if __name__ == "__main__":
    main()
