"""ROS bags that are written with the package rosbags, for tests and benchmarks."""

from functools import cache
from heapq import merge
from pathlib import Path
from typing import NamedTuple

import numpy as np

FORMS = ("bag", "db3", "mcap")
IMU = "sensor_msgs/msg/Imu"


class Topic(NamedTuple):
    """A topic: its name, type, and the receive times in ns and bytes of its messages."""

    name: str
    type: str
    messages: object


@cache
def types(form: str):
    """The standard message types of ROS 1 or 2."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS1_NOETIC if form == "bag" else Stores.ROS2_HUMBLE)


def packed(form: str, message, store=None) -> bytes:
    """The bytes of a message."""
    store = store or types(form)
    name = message.__msgtype__
    return bytes(store.serialize_ros1(message, name) if form == "bag" else store.serialize_cdr(message, name))


def header(form: str, stamp: int, *, frame: str = "imu_link", seq: int = 0):
    """A header, stamped in ns."""
    known = types(form).types
    time = known["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    about = {"seq": seq} if form == "bag" else {}
    return known["std_msgs/msg/Header"](stamp=time, frame_id=frame, **about)


def imu(form: str, stamp: int, values, **about):
    """A message of sensor_msgs/Imu with six values, stamped in ns."""
    known, zero = types(form).types, np.zeros(9)
    vector, turn = known["geometry_msgs/msg/Vector3"], known["geometry_msgs/msg/Quaternion"]
    return known[IMU](
        header=header(form, stamp, **about),
        orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=zero,
        angular_velocity=vector(*(float(x) for x in values[:3])),
        angular_velocity_covariance=zero,
        linear_acceleration=vector(*(float(x) for x in values[3:])),
        linear_acceleration_covariance=zero,
    )


def imu_topic(
    form: str, values, interval: int = 10_000_000, *, name: str = "/imu/data", late: int = 0, **about
) -> Topic:
    """A topic of sensor_msgs/Imu at equal intervals in ns, each message received some ns `late`."""
    start = 1_700_000_000_123_456_789
    stamps = [start + k * interval for k in range(len(values))]
    rows = [
        (stamp + late, packed(form, imu(form, stamp, row, seq=k, **about)))
        for k, (stamp, row) in enumerate(zip(stamps, values, strict=True))
    ]
    return Topic(name, IMU, rows)


def write(folder: Path, form: str, topics: list[Topic], *, compression: str = "", store=None) -> Path:
    """A bag in a folder: the file of ROS 1, or the folder that ROS 2 records."""
    path, store = Path(folder) / ("run.bag" if form == "bag" else f"run_{form}"), store or types(form)
    with _writer(path, form, compression) as writer:
        places = {t.name: writer.add_connection(t.name, t.type, typestore=store) for t in topics}
        for time, name, data in merge(*map(_named, topics), key=lambda row: row[0]):
            writer.write(places[name], time, data)
    return path


def _named(topic: Topic):
    for time, data in topic.messages:
        yield time, topic.name, data


def file_of(path: Path) -> Path:
    """The only file of messages of a bag."""
    (file,) = [path] if path.is_file() else [f for f in path.iterdir() if f.name != "metadata.yaml"]
    return file


def _writer(path: Path, form: str, compression: str):
    from rosbags import rosbag1, rosbag2

    if form == "bag":
        writer = rosbag1.Writer(path)
        if compression:
            writer.set_compression(rosbag1.Writer.CompressionFormat[compression.upper()])
        return writer
    plugin = rosbag2.StoragePlugin.SQLITE3 if form == "db3" else rosbag2.StoragePlugin.MCAP
    writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    if compression:
        writer.set_compression(rosbag2.CompressionMode[compression.upper()], rosbag2.CompressionFormat.ZSTD)
    return writer
