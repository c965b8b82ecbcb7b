"""Bags of a million messages: time of reading one, next to decoding with rosbags message by message.

    python benchmarks/bags.py [--messages 1000000] [--forms bag db3 ...] [--write PATH]

The bags hold one topic of sensor_msgs/Imu at 200 Hz and are written here. Each is read in a new process of its own;
time is that of the processor, of that process and of those that it starts, without their imports.
Both give the same samples, which is checked.
"""

from table import begin, markdown

import json
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import bag_files

INTERVAL, START = 5_000_000, 1_700_000_000_000_000_000
FORMS = {
    "bag": ("bag", ""),
    "lz4": ("bag", "lz4"),
    "db3": ("db3", ""),
    "mcap": ("mcap", ""),
    "zstd": ("mcap", "storage"),
}
HEADINGS = ("bag", "file MB", "rosbags s", "allanite s", "times faster")


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


def theirs(path: Path) -> list[float]:
    """Sums of the values, decoded one message at a time."""
    from rosbags.highlevel import AnyReader

    with AnyReader([path]) as reader:
        rows = np.empty((reader.message_count, 6))
        for k, (connection, _, raw) in enumerate(reader.messages()):
            message = reader.deserialize(raw, connection.msgtype)
            w, a = message.angular_velocity, message.linear_acceleration
            rows[k] = w.x, w.y, w.z, a.x, a.y, a.z
    return rows.sum(axis=0).tolist()


def ours(path: Path) -> list[float]:
    """The same sums from `allanite.read`."""
    import allanite as al

    return [float(record.values.sum()) for record in al.read(path)]


def _seconds() -> float:
    return sum(os.times()[:4])


def measured(reader: str, path: Path) -> dict:
    """Seconds and sums of a new process; the imports are there before it begins."""
    done = subprocess.run([sys.executable, __file__, reader, str(path)], capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def _serve(reader: str, path: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for form in ("bag", "db3"):
            small = bag_files.imu_topic(form, np.random.default_rng(1).normal(size=(20, 6)))
            globals()[reader](bag_files.write(Path(folder), form, [small]))
    start = _seconds()
    sums = globals()[reader](Path(path))
    print(json.dumps({"seconds": _seconds() - start, "sums": sums}))


def row(form: str, compression: str, count: int) -> tuple[str, ...]:
    """The line of a bag."""
    with tempfile.TemporaryDirectory() as folder:
        topic = bag_files.Topic("/imu/data", bag_files.IMU, messages(form, count))
        path = bag_files.write(Path(folder), form, [topic], compression=compression)
        size = bag_files.file_of(path).stat().st_size / 1e6
        a, b = measured("theirs", path), measured("ours", path)
    np.testing.assert_allclose(a["sums"], b["sums"], rtol=1e-12)
    name = f"{form} {compression}".replace("storage", "zstd").strip()
    times = (a["seconds"], b["seconds"], a["seconds"] / b["seconds"])
    return (name, f"{size:.0f}", *(f"{x:.1f}" for x in times))


def main() -> None:
    run = begin(__doc__, messages=1_000_000, forms=list(FORMS))
    rows = [row(*FORMS[form], run.asked.messages) for form in run.asked.forms]
    notes = [
        f"{run.asked.messages} messages with seeds 1",
        "seconds do not count imports: a bag of 20 messages is read before",
    ]
    run.publish("Reading bags", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    if sys.argv[1:2] in (["ours"], ["theirs"]):
        _serve(*sys.argv[1:])
    else:
        main()
