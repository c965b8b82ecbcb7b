"""ArduPilot logs: instances, batches, and messages that are damaged."""

import struct
from itertools import chain

import numpy as np
import pytest
from tests.hostile import generator, judged, mutated, read
from tests.rows import refused, rows

import allanite as al

RNG = np.random.default_rng(7)
KINDS = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "IMU": (130, "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    "GYR": (131, "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"), "BARO": (132, "Qfc", "TimeUS,Alt,Temp"),
    "ISBH": (133, "QHBBHHQf", "TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate"),
    "ISBD": (134, "QHHaaa", "TimeUS,N,seqno,x,y,z"), "UNIT": (135, "QbZ", "TimeUS,Id,Label"),
    "MULT": (136, "Qbd", "TimeUS,Id,Mult"), "FMTU": (137, "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    "RATE": (138, "Qcf", "TimeUS,R,ROut"),
}  # fmt: skip
CODES = {"n": "4s", "N": "16s", "Z": "64s", "a": "32h", "c": "h"}


def code(letters):
    return "<" + "".join(CODES.get(letter, letter) for letter in letters)


def message(kind, *values):
    number, letters, _ = KINDS[kind]
    return b"\xa3\x95" + bytes([number]) + struct.pack(code(letters), *values)


def header():
    return b"".join(
        message("FMT", number, 3 + struct.calcsize(code(letters)), name.encode(), letters.encode(), columns.encode())
        for name, (number, letters, columns) in KINDS.items()
    )


def log(path, *messages):
    path.write_bytes(header() + b"".join(messages))
    return path


@pytest.fixture
def flight(tmp_path):
    imu, gyro, made = RNG.normal(size=(600, 6)).astype("f4"), RNG.normal(size=(900, 3)).astype("f4"), []
    for i, at in enumerate(range(10**9, 10**9 + 300 * 20_000, 20_000)):
        made += [message("IMU", at + k, k, *imu[2 * i + k]) for k in (0, 1)]
        made += [message("GYR", at + 9, 0, 10**9 + k * 6667, *gyro[k]) for k in range(3 * i, 3 * i + 3)]
        made += [message("BARO", at, 1.5, 2500)]
    return log(tmp_path / "flight.bin", *made), gyro


def test_instances_are_listed_and_chosen(flight):
    path, gyro = flight
    words = r"3 tables.*\(IMU/0 \(300 rows at 50 Hz\), IMU/1 \(300 rows at 50 Hz\), GYR/0 \(900 rows at 150.3 Hz\)\)"
    refused(al.UsageError, words, lambda: al.read(path))
    recording = al.read(path, channels=["GYR"])
    assert (recording.channels, recording[0].unit, recording[0].size) == (("GyrX", "GyrY", "GyrZ"), "rad/s", 900)
    assert recording[0].rate == pytest.approx(1e6 / 6667)
    assert np.array_equal(recording[1].values, gyro[:, 1].astype(float))
    assert any("'SampleUS [us]' is used as the clock, of 2 candidates" in note for note in recording.notes)
    second = al.read(path, channels=["IMU/1"])
    assert [record.unit for record in second] == ["rad/s"] * 3 + ["m/s^2"] * 3
    assert al.read(path, channels=["imu/1/AccZ"]).channels == ("AccZ",)
    refused(al.UsageError, r"'Alt'", lambda: al.read(path, channels=["BARO"]))


def test_the_samples_are_those_of_pymavlink(flight):
    reader = pytest.importorskip("pymavlink.DFReader").DFReader_binary(str(flight[0]))
    expected = {}
    while (found := reader.recv_msg()) is not None:
        if found.get_type() in ("IMU", "GYR"):
            fields = found.to_dict()
            expected.setdefault(f"{fields['mavpackettype']}/{fields['I']}", []).append(fields)
    reader.data_map.close()
    reader.filehandle.close()
    assert set(expected) == {"IMU/0", "IMU/1", "GYR/0"}
    for name, table in expected.items():
        recording = al.read(flight[0], channels=[name])
        assert all(np.array_equal(r.values, [row[r.name] for row in table]) for r in recording)


def batch(number, counts, start, missing=()):
    head = message("ISBH", start, number, 1, 0, 500, counts.shape[1], start, 1000.0)
    parts = (k for k in range(counts.shape[1] // 32) if k not in missing)
    return [head, *(message("ISBD", start, number, k, *counts[:, 32 * k : 32 * k + 32].ravel()) for k in parts)]


def test_batches_are_unrolled_with_gaps_between_them(tmp_path):
    counts = RNG.integers(-9000, 9000, (3, 3, 1024))
    made = [batch(i, counts[i], 10**9 + i * 1_500_000, missing=(5,) if i == 1 else ()) for i in range(3)]
    recording = al.read(log(tmp_path / "a.bin", *chain(*made)))
    assert "3 batches of up to 1024 samples" in recording.notes
    assert (recording.channels, recording[0].unit) == (("x", "y", "z"), "rad/s")
    assert (recording[0].rate, recording[2].size) == (pytest.approx(1000.0), 3000 + 1024)
    expected = np.full(4024, np.nan)
    expected[np.add.outer((0, 1500, 3000), np.arange(1024))] = counts[:, 2] / 500
    expected[1660:1692] = np.nan
    np.testing.assert_allclose(recording[2].values, expected, rtol=1e-12)


UNITS = [
    *(("UNIT", 0, ord(letter), label.encode()) for letter, label in
      {"s": "s", "k": "deg/s", "E": "rad/s", "o": "m/s/s", "#": "instance", "-": ""}.items()),
    *(("MULT", 0, ord(letter), factor) for letter, factor in {"-": 0.0, "F": 1e-6, "B": 1e-2, "C": 1e-3}.items()),
    ("FMTU", 0, 130, b"s#kkkooo", b"F-CCC---"),
    ("FMTU", 0, 131, b"s#sEEE", b"F-F---"),
    ("FMTU", 0, 138, b"sk-", b"FB-"),
]  # fmt: skip


def as_text(*messages):
    """Messages as Mission Planner writes them: hundredths as what they mean."""
    kinds = [("FMT", number, 3 + struct.calcsize(code(letters)), name, letters, columns)
             for name, (number, letters, columns) in KINDS.items()]  # fmt: skip

    def word(value, letter):
        return value.decode() if isinstance(value, bytes) else str(value / 100 if letter == "c" else value)

    return "".join(
        ", ".join((kind, *map(word, values, KINDS[kind][1]))) + "\n" for kind, *values in (*kinds, *messages)
    )


def flown(count=300):
    values = RNG.normal(size=(count, 6)).round(6).tolist()
    imu = [("IMU", 10**9 + i * 20_000, i % 2, *row) for i, row in enumerate(values)]
    rate = [("RATE", 10**9 + i * 20_000, int(RNG.integers(-9000, 9000)), 0.5) for i in range(count)]
    return imu, rate


@rows("form", ["binary", "text"])
def test_units_and_factors_that_the_log_says(tmp_path, form):
    imu, rate = flown()
    every, path = (*UNITS, *imu, *rate), tmp_path / "flight.log"
    if form == "binary":
        log(path, *(message(*values) for values in every))
    else:
        path.write_text(as_text(*every))
    recording = al.read(path, channels=["IMU/0"])
    assert [record.unit for record in recording] == ["deg/s"] * 3 + ["m/s^2"] * 3
    assert "units by the definitions in the log" in recording.notes
    values = np.array([row[3:] for row in imu[::2]])
    np.testing.assert_allclose(np.array([r.values for r in recording]).T, values * ([1e-3] * 3 + [1] * 3), rtol=1e-6,
                               atol=1e-9)  # fmt: skip
    assert recording[0].rate == pytest.approx(25.0)
    (roll,) = al.read(path, channels=["RATE/R"])
    assert (roll.unit, roll.rate) == ("deg/s", pytest.approx(50.0))
    np.testing.assert_allclose(roll.values, [row[2] / 100 for row in rate], rtol=1e-12)


def test_a_log_as_text_is_read_as_pymavlink_reads_it(tmp_path):
    reader = pytest.importorskip("pymavlink.DFReader").DFReader_text
    path, (imu, rate) = tmp_path / "flight.log", flown()
    path.write_text(as_text(*imu, *rate))
    flight, expected = reader(str(path)), []
    while (row := flight.recv_match(type="IMU")) is not None:
        expected.append([getattr(row, name) for name in ("GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ")])
    flight.data_map.close()
    flight.filehandle.close()
    for instance in (0, 1):
        recording = al.read(path, channels=[f"IMU/{instance}"])
        assert [record.unit for record in recording] == ["rad/s"] * 3 + ["m/s^2"] * 3
        assert np.array_equal(np.array([record.values for record in recording]).T, expected[instance::2])


def test_damaged_lines_of_a_log_as_text(write):
    imu, _ = flown()
    lines = ["ArduCopter V3.1", "", *as_text(*imu).splitlines()]
    lines[40], lines[60] = lines[40][:30], lines[60].replace(".", "x")
    recording = al.read(write("\r\n".join(lines), "flight.log"), channels=["IMU/0"])
    assert any("2 lines of IMU cannot be read" in note for note in recording.notes)
    assert recording[0].size == 150
    refused(
        al.DataError, "no rows", lambda: al.read(write("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"))
    )


@pytest.mark.slow("takes more than half a second")
def test_mutations_of_a_log_as_text_are_read_or_refused(tmp_path):
    path, (imu, rate) = tmp_path / "flight.log", flown(40)
    data, found = as_text(*UNITS, *imu, *rate).encode(), set()
    for k in range(200):
        path.write_bytes(mutated(generator(path.name, k), data))
        found.add(judged(read, path, {"channels": "IMU/0"}))
    assert found == {"taken", "refused"}


def test_damaged_logs(flight, write):
    whole = flight[0].read_bytes()
    assert 400 < al.read(write(whole[: len(whole) // 2], "cut.bin"), channels=["GYR/0"])[0].size <= 450
    at = whole.index(b"\xa3\x95\x83", len(whole) // 2)
    lost = whole[: at + 9] + whole[at + 20 :]  # eleven bytes of a message
    damaged = al.read(write(lost, "cut.bin"), channels=["GYR/0"])
    assert np.isnan(damaged[0].values).sum() == 1
    assert np.nanmax(np.abs(damaged[0].values)) < 10
    assert any("bytes belong to no message" in note for note in damaged.notes)
    refused(al.DataError, "no rows", lambda: al.read(write(whole[:534], "cut.bin")))
    path = write(header() + message("BARO", 1, 2.0, 3) * 9, "cut.bin")
    refused(al.UsageError, r"BARO \(9 rows\)", lambda: al.read(path))
