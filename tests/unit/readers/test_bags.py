"""ROS bags: against rosbags sample by sample, which topic and clock are taken, what is said of damaged ones."""

import gzip
import re
import shutil
import sqlite3

import numpy as np
import pytest
from tests import bag_files, thinned

pytest.importorskip("rosbags", reason="pip install 'allanite[ros]'")

from tests.bag_files import FORMS, IMU, Topic, file_of, imu, imu_topic, packed, types, write
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.errors import DataError, UsageError
from allanite.readers.sandbox.bag_messages import Definition
from allanite.study.channels import open_recording

RNG = np.random.default_rng(8)
VALUES = RNG.normal(size=(400, 6))
SIX = ("gx", "gy", "gz", "ax", "ay", "az")
EVERY = [
    ("bag", ""), ("bag", "bz2"), ("bag", "lz4"), ("db3", ""), ("db3", "message"), ("db3", "file"),
    ("mcap", ""), ("mcap", "message"), ("mcap", "file"), ("mcap", "storage"),
]  # fmt: skip


def samples(recording):
    return np.array([record.values for record in recording]).T


def at_intervals(form, messages, interval=10**7, store=None):
    """Packed messages that are received at equal intervals in ns."""
    return [(k * interval, packed(form, message, store)) for k, message in enumerate(messages)]


def theirs(path):
    """Receive times, header stamps in ns and values, as rosbags decodes them."""
    from rosbags.highlevel import AnyReader

    rows = []
    with AnyReader([path]) as reader:
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp
            w, a = message.angular_velocity, message.linear_acceleration
            rows.append((time, stamp.sec * 10**9 + stamp.nanosec, w.x, w.y, w.z, a.x, a.y, a.z))
    return np.array([row[:2] for row in rows]), np.array([row[2:] for row in rows])


@pytest.mark.slow("takes more than half a second")
@rows(("form", "compression"), thinned(EVERY, 4))
def test_samples_are_those_of_rosbags(tmp_path, form, compression):
    frames = ["imu", "imu_link", "a", "", "base"]
    start = 1_700_000_000_999_999_990
    rows = [
        (stamp + int(RNG.integers(10_000, 50_000)), packed(form, imu(form, stamp, row, frame=frames[k % 5], seq=k)))
        for k, row in enumerate(VALUES)
        for stamp in [start + 10_000_000 * k]
    ]
    path = write(tmp_path, form, [Topic("/imu", IMU, rows)], compression=compression)
    recording = al.read(path)
    times, values = theirs(path)
    assert recording.channels == SIX
    np.testing.assert_array_equal(samples(recording), values)
    assert [(r.unit, r.kind) for r in recording] == [("rad/s", "rate")] * 3 + [("m/s^2", "rate")] * 3
    assert {r.rate for r in recording} == {100.0}
    assert recording[0].start == pytest.approx(times[0, 1] / 1e9, abs=1e-6)
    received = al.read(path, time="receive time")
    assert received[0].start == pytest.approx(times[0, 0] / 1e9, abs=1e-6)
    np.testing.assert_array_equal(samples(received), values)


@rows("form", ["bag", "mcap"])
def test_messages_are_in_the_order_in_which_they_were_received(tmp_path, form):
    topic = imu_topic(form, VALUES)
    rows = topic.messages
    rows[7], rows[8] = (rows[8][0], rows[7][1]), (rows[7][0], rows[8][1])
    path = write(tmp_path, form, [topic])
    np.testing.assert_array_equal(theirs(path)[1][7:9], VALUES[[8, 7]])
    recording = al.read(path)
    np.testing.assert_array_equal(samples(recording), theirs(path)[1])
    assert any("column 'header.stamp' is not increasing" in note for note in recording.notes)


DEFINITION = (
    "std_msgs/Header header\nstring text\nbool flag\n"
    + "".join(f"uint{8 * size} u{size}\nint{8 * size} i{size}\n" for size in (1, 2, 4, 8))
    + "float32 f4\nfloat64 f8\nfloat64[3] three\nfloat32[] many\nstring[] words\nfloat64[9] some_covariance\n"
    "geometry_msgs/Vector3[] points\ngeometry_msgs/Vector3[2] two\nstring last\nuint8 tail\n"
)


def custom(form, name="lab_msgs/msg/Everything", text=DEFINITION):
    from rosbags.typesys import get_types_from_msg

    store = type(types(form))()
    store.fielddefs, store.types = {**types(form).fielddefs}, {**types(form).types}
    store.register(get_types_from_msg(text, name))
    return store


def everything(form, store, k):
    vector = types(form).types["geometry_msgs/msg/Vector3"]
    small = int(RNG.integers(0, 100))
    return store.types["lab_msgs/msg/Everything"](
        header=bag_files.header(form, 1_700_000_000_000_000_000 + k * 10_000_000, seq=k),
        text="x" * (k % 3), flag=bool(k % 2), u1=small, i1=-small, u2=small, i2=-small, u4=small, i4=-small, u8=small,
        i8=-small, f4=np.float32(RNG.normal()), f8=float(RNG.normal()), three=RNG.normal(size=3),
        many=RNG.normal(size=1 + k % 4).astype(np.float32), words=["ab"] * (k % 3), some_covariance=np.zeros(9),
        points=[vector(1.0, 2.0, 3.0)] * (k % 2), two=[vector(*RNG.normal(size=3)) for _ in range(2)],
        last="y" * (k % 5), tail=small,
    )  # fmt: skip


@rows("form", ["bag", "db3"])
@rows("big", [False, True])
def test_every_type_of_field_is_decoded_as_by_rosbags(form, big):
    if form == "bag" and big:
        pytest.skip("ROS 1 is little-endian")
    store, name = custom(form), "lab_msgs/msg/Everything"
    messages = [everything(form, store, k) for k in range(60)]
    data = [bytes(store.serialize_cdr(m, name, little_endian=False)) if big else packed(form, m, store)
            for m in messages]  # fmt: skip
    definition = Definition(store.fielddefs, name, aligned=form != "bag")
    assert definition.left == ["many", "words", "some_covariance", "points"]
    out = np.zeros(60, [(column, kind) for column, (kind, _) in definition.columns.items()])
    definition.decode(data, out)
    for k, message in enumerate(messages):
        assert out["header.stamp"][k] == message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        for column in ("flag", "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8", "tail"):
            assert out[column][k] == getattr(message, column), (column, k)
        assert [out[f"three[{i}]"][k] for i in range(3)] == list(message.three)
        assert [out[f"two[{i}].z"][k] for i in range(2)] == [vector.z for vector in message.two]
    refused(ValueError, "shorter than its definition", lambda: definition.decode([data[0][:40]], out[:1]))
    refused(ValueError, "longer than its definition", lambda: definition.decode([data[0] + bytes(8)], out[:1]))


def test_definitions_that_are_too_large_are_refused():
    base, name, array = 1, 2, 3

    def of_field(kind):
        return Definition({"a/msg/A": ([], [("x", kind)])}, "a/msg/A", aligned=True)

    refused(ValueError, "too large", lambda: of_field((name, "a/msg/A")))
    refused(ValueError, "too large", lambda: of_field((array, ((base, ("string", 0)), 10**9))))
    assert of_field((array, ((base, ("float64", 0)), 10**9))).left == ["x"]
    refused(ValueError, "wstring, which is not supported", lambda: of_field((base, ("wstring", 0))))


@pytest.fixture(scope="module", params=FORMS)
def several(request, tmp_path_factory):
    form = request.param
    field, vector = types(form).types["sensor_msgs/msg/MagneticField"], types(form).types["geometry_msgs/msg/Vector3"]
    start = 1_700_000_000_000_000_000
    compass = [field(bag_files.header(form, start), vector(1.0, 2.0, 3.0), np.zeros(9))] * 40
    text = types(form).types["std_msgs/msg/String"](data="hello")
    topics = [
        imu_topic(form, VALUES, name="/left/imu"),
        imu_topic(form, 2 * VALUES[:200], 20_000_000, name="/right/imu"),
        Topic("/mag", "sensor_msgs/msg/MagneticField", at_intervals(form, compass, 50_000_000)),
        Topic("/chat", "std_msgs/msg/String", at_intervals(form, [text] * 5)),
    ]
    return write(tmp_path_factory.mktemp(form), form, topics)


@pytest.mark.slow("takes more than half a second")
def test_a_topic_and_its_channels_are_named(several):
    assert np.array_equal(samples(al.read(several, channels=["/right/imu"])), 2 * VALUES[:200])
    assert al.read(several, channels=["right/imu"])[0].rate == 50.0
    one = al.read(several, channels=["/left/imu/gz"])
    assert one.channels == ("gz",)
    assert al.read(several, channels=["/left/imu/angular_velocity.z"])[0].values.tolist() == one[0].values.tolist()
    assert any(note.startswith("samples of /left/imu of type sensor_msgs/Imu (400 rows") for note in one.notes)
    left = next(note for note in one.notes if note.startswith("left out, other tables of the file: "))
    assert "/right/imu of type" in left
    assert "/mag" not in left


BOTH = r"/left/imu of type sensor_msgs/Imu \(400 rows at \S+ Hz\), /right/imu of type sensor_msgs/Imu \(200 rows at "


@rows("channels, words", [
    (None, rf"the file contains 2 tables .*, each with its own clock \({BOTH}\S+ Hz\)\); .*channels='/left/imu'$"),
    ("/imu", r"no table or column '/imu' .* contains /left/imu.*/mag of type sensor_msgs/MagneticField \(40 rows"),
    ("/imu", r"/chat of type std_msgs/String \(5 rows"),
    ("/left/imu,/right/imu", r"belong to 2 tables of the file, each with its own clock"),
    ("/left/imu/gw", r"no column 'gw'; columns: .*angular_velocity\.x"),
    ("/mag", r"inertial signal|a time by its header"),
])  # fmt: skip
def test_a_wrong_topic_is_refused_by_name(several, channels, words):
    refused(UsageError, words, lambda: al.read(several, channels=channels))


@rows("form", ["bag", "mcap"])
def test_numbers_of_other_messages_are_columns_with_dotted_names(tmp_path, form):
    name = "lab_msgs/msg/Pair"
    store = custom(form, name, "std_msgs/Header header\nlab_msgs/Gyro gyro\nfloat32 temperature\n"
                               "{}\nMSG: lab_msgs/Gyro\nint32 gyro_x\nint32 gyro_y\n".format("=" * 80))  # fmt: skip
    pair, gyro = store.types[name], store.types["lab_msgs/msg/Gyro"]
    counts = RNG.integers(-500, 500, size=(50, 2))
    messages = [
        pair(bag_files.header(form, k * 10**7), gyro(int(x), int(y)), np.float32(20 + k))
        for k, (x, y) in enumerate(counts)
    ]
    path = write(tmp_path, form, [Topic("/raw", name, at_intervals(form, messages, store=store))], store=store)
    refused(UsageError, r"'gyro\.gyro_x', 'gyro\.gyro_y'.*unit is unknown", lambda: al.read(path))
    recording = al.read(path, scale="0.01deg/s")
    assert recording.channels == ("gyro.gyro_x", "gyro.gyro_y")
    assert np.array_equal(samples(recording), counts)
    assert recording.others[0].name == "temperature"


def test_two_sensors_in_a_message_keep_their_names(tmp_path):
    name = "lab_msgs/msg/Two"
    store = custom("db3", name, "sensor_msgs/Imu a\nsensor_msgs/Imu b\n")
    messages = [store.types[name](imu("db3", k * 10**7, row), imu("db3", 0, -row)) for k, row in enumerate(VALUES[:50])]
    topic = Topic("/two", name, at_intervals("db3", messages, store=store))
    recording = al.read(write(tmp_path, "db3", [topic], store=store))
    assert (recording.channels[0], len(recording)) == ("a.angular_velocity.x", 12)
    assert recording["b.linear_acceleration.z"].values.tolist() == (-VALUES[:50, 5]).tolist()


def test_a_definition_that_the_bag_does_not_hold_is_read_beside_it(tmp_path):
    name, text = "lab_msgs/msg/Logged", "std_msgs/Header header\nsensor_msgs/Imu imu\nstring raw\n"
    store = custom("db3", name, text)
    messages = [
        store.types[name](bag_files.header("db3", k * 10**7), imu("db3", 0, row), "$VN" * (k % 4))
        for k, row in enumerate(VALUES[:50])
    ]
    topic = Topic("/imu", name, at_intervals("db3", messages, store=store))
    path = file_of(write(tmp_path, "db3", [topic], store=store))
    with sqlite3.connect(path) as file:
        file.execute("DELETE FROM message_definitions")
    file.close()
    refused(UsageError, r"of lab_msgs/Logged is missing: put it beside the bag as Logged\.msg", lambda: al.read(path))
    (path.parent / "Logged.msg").write_text(text)
    recording = al.read(path)
    assert np.array_equal(samples(recording), VALUES[:50])
    assert "defined by Logged.msg beside the bag" in recording.notes


@rows("form, frozen", paired(list(FORMS), [0, 1_700_000_000_000_000_000]))
def test_constant_stamps_of_headers_give_way_to_the_receive_time(tmp_path, form, frozen):
    rows = at_intervals(form, [imu(form, frozen, row) for row in VALUES], 4_000_000)
    recording = al.read(write(tmp_path, form, [Topic("/imu", IMU, rows)]))
    assert recording[0].rate == 250.0
    note = next(note for note in recording.notes if "'receive time' is used as the clock" in note)
    assert "'header.stamp' is constant" in note


def test_neither_counters_nor_covariances_are_channels(tmp_path):
    path = write(tmp_path, "bag", [imu_topic("bag", VALUES)])
    recording = al.read(path, unit="deg/s")
    assert (recording.channels, [r.unit for r in recording]) == (SIX, ["deg/s"] * 3 + ["m/s^2"] * 3)
    left = next(note for note in recording.notes if note.startswith("left out, no signal"))
    assert "orientation, orientation_covariance, angular_velocity_covariance" in left


def test_a_counter_in_the_header_shows_what_is_missing(tmp_path):
    topic = imu_topic("bag", VALUES)
    rows = [row for k, row in enumerate(topic.messages) if not 100 <= k < 105]
    recording = al.read(write(tmp_path, "bag", [topic._replace(messages=rows)]))
    assert recording[0].size == len(VALUES)
    assert np.flatnonzero(np.isnan(recording[0].values)).tolist() == [100, 101, 102, 103, 104]


@pytest.mark.slow("takes more than half a second")
def test_a_bag_of_several_files_is_one_recording(tmp_path):
    topic = imu_topic("db3", VALUES)
    parts = []
    for i, half in enumerate((topic.messages[:150], topic.messages[150:])):
        folder = tmp_path / str(i)
        folder.mkdir()
        parts.append(write(folder, "db3", [topic._replace(messages=half)]))
    whole = tmp_path / "whole"
    shutil.copytree(parts[0], whole)
    shutil.copy(file_of(parts[1]), whole / "run_2.db3")
    text = (whole / "metadata.yaml").read_text().replace("message_count: 150", "message_count: 400")
    (whole / "metadata.yaml").write_text(text.replace("  - run_db3.db3\n", "  - run_db3.db3\n  - run_2.db3\n"))
    recording = al.read(whole)
    assert np.array_equal(samples(recording), VALUES)
    assert recording.digest != al.read(parts[0]).digest
    (whole / "run_2.db3").unlink()
    refused(DataError, r"files are missing", lambda: al.read(whole))
    (whole / "metadata.yaml").unlink()
    refused(DataError, r"this is a directory", lambda: al.read(whole))


@rows("form", FORMS)
def test_a_packed_bag(tmp_path, form):
    path = file_of(write(tmp_path, form, [imu_topic(form, VALUES)]))
    packing = tmp_path / f"{path.name}.gz"
    packing.write_bytes(gzip.compress(path.read_bytes()))
    assert np.array_equal(samples(al.read(packing)), VALUES)


def test_a_name_that_means_something_in_a_url(tmp_path):
    path = file_of(write(tmp_path, "db3", [imu_topic("db3", VALUES)]))
    assert np.array_equal(samples(al.read(path.rename(tmp_path / "50% a#b?c=d.db3"))), VALUES)


def test_progress_is_told_while_a_bag_is_read(tmp_path):
    told = []
    path = write(tmp_path, "bag", [imu_topic("bag", VALUES)])
    open_recording(path, al.Recipe(), progress=lambda what, fraction: told.append((what, fraction)))
    assert (told[0], told[-1]) == (("reading", 0.0), ("reading, 100 %", pytest.approx(0.04)))


FAILED, CHUNK = (
    "damaged or incomplete: rosbags failed while",
    r"/imu/data \(sensor_msgs/Imu\)|while reading its structure",
)
CUT = [
    *((*how, lambda data: data[: 3 * len(data) // 5], FAILED) for how in EVERY),
    *((form, "", lambda data: data[: 99 * len(data) // 100], FAILED) for form in FORMS),
]
DAMAGED = [
    ("bag", "", lambda data: re.sub(rb"(?s)index_pos=.{8}", b"index_pos=" + bytes(8), data, count=1), "rosbag reindex"),
    *((*how, lambda data: data[: len(data) // 3] + bytes(64) + data[len(data) // 3 + 64 :], CHUNK)
      for how in (("bag", "bz2"), ("bag", "lz4"), ("mcap", "storage"))),
]  # fmt: skip


@pytest.mark.slow("seconds of reading")
@rows("form, compression, damage, words", [*thinned(CUT, 5), *DAMAGED])
def test_a_damaged_bag_is_refused_in_words(tmp_path, form, compression, damage, words):
    path = write(tmp_path, form, [imu_topic(form, VALUES)], compression=compression)
    file = file_of(path)
    file.write_bytes(damage(file.read_bytes()))
    refused(DataError, words, lambda: al.read(path))


@rows("suffix", [".bag", ".db3", ".mcap"])
def test_other_files_with_the_suffix_of_a_bag(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(RNG.bytes(3000))
    refused(DataError, "does not begin like a ROS bag", lambda: al.read(path))
    path.write_bytes(b"\x28\xb5\x2f\xfd" + RNG.bytes(3000))
    refused(DataError, "compressed with zstd; of a ROS 2 bag, give the folder", lambda: al.read(path))


def test_fewer_messages_than_announced_are_refused(tmp_path):
    path = write(tmp_path, "db3", [imu_topic("db3", VALUES)])
    with sqlite3.connect(file_of(path)) as file:
        file.execute("DELETE FROM messages WHERE id > 300")
    file.close()
    refused(DataError, "400 messages are announced, but 300 are there", lambda: al.read(path))
    assert al.read(file_of(path))[0].size == 300
