"""Bags of a million messages: time and memory of reading one, next to decoding with rosbags message by message.

The bags hold one topic of sensor_msgs/Imu at 200 Hz and are written here, or with --keep taken from a folder where an
earlier run has left them. Each is read in a new process of its own; time is that of the processor, of that process and
of those that it starts, without their imports. Memory is the largest resident size of that process less its size
before, and that of the process which opens the file less the same of a small bag; it is known on Linux only. Both give
the same samples, which is checked.
"""

from table import begin, markdown

import argparse
import json
import os
import struct
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import bag_files

INTERVAL, START = 5_000_000, 1_700_000_000_000_000_000
FORMS = {
    "bag": ("bag", ""), "lz4": ("bag", "lz4"), "bz2": ("bag", "bz2"), "db3": ("db3", ""),
    "db3-message": ("db3", "message"), "db3-file": ("db3", "file"), "mcap": ("mcap", ""),
    "mcap-chunk": ("mcap", "storage"),
}  # fmt: skip
COMPRESSED = {"message": "zstd by message", "file": "zstd of the file", "storage": "zstd by chunk"}
HEADINGS = ("bag", "file MB", "rosbags s", "allanite s", "times faster", "record MB", "memory MB", "times the record")


def messages(form: str, count: int):
    """Receive times and bytes of messages that differ in stamps and values."""
    values = np.random.default_rng(1).normal(size=(count, 6))
    data = bytearray(bag_files.packed(form, bag_files.imu(form, START, np.arange(1.0, 7.0))))
    places = [data.index(struct.pack("<d", k)) for k in (2.0, 5.0)]  # 1.0 is the orientation, too
    at = data.index(struct.pack("<I", START // 10**9))
    for k in range(count):
        stamp = START + k * INTERVAL
        struct.pack_into("<II", data, at, stamp // 10**9, stamp % 10**9)
        for place, row in zip(places, (values[k, :3], values[k, 3:]), strict=True):
            struct.pack_into("<3d", data, place - 8, *row)
        yield stamp + 1000, bytes(data)


def theirs(path: Path) -> list[np.ndarray]:
    """The samples, decoded one message at a time."""
    from rosbags.highlevel import AnyReader

    with AnyReader([path]) as reader:
        rows = np.empty((reader.message_count, 6))
        for k, (connection, _, raw) in enumerate(reader.messages()):
            message = reader.deserialize(raw, connection.msgtype)
            w, a = message.angular_velocity, message.linear_acceleration
            rows[k] = w.x, w.y, w.z, a.x, a.y, a.z
    return list(rows.T)


def ours(path: Path) -> list[np.ndarray]:
    """The same from `allanite.read`."""
    import allanite as al

    return [record.values for record in al.read(path)]


def _seconds() -> float:
    return sum(os.times()[:4])


def _bytes(pid: str, what: str) -> int:
    """A size in the status of a process; 0 if it has ended."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    except OSError:
        return 0
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith(what)), 0)


def _children() -> Iterator[str]:
    for thread in Path("/proc/self/task").iterdir():
        yield from (thread / "children").read_text().split()


@contextmanager
def watched() -> Iterator[list[int]]:
    """Growth of this process at its largest, and the largest size of one that it starts, after the block."""
    Path("/proc/self/clear_refs").write_text("5")  # the largest size so far is forgotten
    before, largest, ended, sizes = _bytes("self", "VmRSS"), [0], threading.Event(), list[int]()

    def look() -> None:
        while not ended.wait(0.01):
            largest[0] = max(largest[0], *(_bytes(child, "VmHWM") for child in _children()), 0)

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield sizes
    finally:
        ended.set()
        thread.join()
        sizes += [_bytes("self", "VmHWM") - before, largest[0]]


def measured(reader: str, path: Path) -> dict:
    """Seconds, bytes and sums of a new process; the imports are there before it begins."""
    done = subprocess.run([sys.executable, __file__, reader, str(path)], capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def _serve(reader: str, path: str) -> None:
    read, small = globals()[reader], []
    with tempfile.TemporaryDirectory() as folder:
        for form in ("bag", "db3", "mcap"):
            topic = bag_files.imu_topic(form, np.random.default_rng(1).normal(size=(20, 6)))
            with watched() as sizes:
                read(bag_files.write(Path(folder), form, [topic]))
            small.append(sizes[1])
    start = _seconds()
    with watched() as sizes:
        values = read(Path(path))
    about = {"seconds": _seconds() - start, "peak": sizes[0] + sizes[1] - max(small)}
    about |= {"record": sum(one.nbytes for one in values), "sums": [float(one.sum()) for one in values]}
    print(json.dumps(about))


def bag(folder: Path, how: tuple[str, str], count: int) -> Path:
    """A bag in a folder; one that is there already is taken, which saves minutes."""
    there = [path for path in folder.glob("*") if path.name.startswith("run")]
    topic = bag_files.Topic("/imu/data", bag_files.IMU, messages(how[0], count))
    return there[0] if there else bag_files.write(folder, how[0], [topic], compression=how[1])


def row(form: str, compression: str, asked: argparse.Namespace) -> tuple[str, ...]:
    """The line of a bag."""
    with tempfile.TemporaryDirectory() as temporary:
        kept = f"{form} {compression} {asked.messages}".replace(" ", "_")
        folder = Path(asked.keep, kept) if asked.keep else Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        path = bag(folder, (form, compression), asked.messages)
        size = bag_files.file_of(path).stat().st_size / 1e6
        a, b = measured("theirs", path), measured("ours", path)
    np.testing.assert_allclose(a["sums"], b["sums"], rtol=1e-12)
    name = f"{form} {COMPRESSED.get(compression, compression)}".strip()
    times = (a["seconds"], b["seconds"], a["seconds"] / b["seconds"])
    sizes = (f"{b['record'] / 1e6:.0f}", f"{b['peak'] / 1e6:.0f}", f"{b['peak'] / b['record']:.1f}")
    return (name, f"{size:.0f}", *(f"{x:.1f}" for x in times), *sizes)


def main() -> None:
    run = begin(__doc__, messages=1_000_000, forms=list(FORMS), keep="")
    rows = [row(*FORMS[form], run.asked) for form in run.asked.forms]
    notes = [
        f"{run.asked.messages} messages with seeds 1",
        "seconds do not count imports: bags of 20 messages are read before",
        "memory: largest size of both processes of allanite beyond that before; record: the samples that come out",
    ]
    run.publish("Reading bags", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    if sys.argv[1:2] in (["ours"], ["theirs"]):
        _serve(*sys.argv[1:])
    else:
        main()
