"""Text and CSV in the shapes that loggers write."""

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import strategies as st
from pyarrow import csv
from tests.rows import paired, refused, rows
from tests.unit.readers.checks import noted, tried

from allanite.core.errors import DataError, UsageError
from allanite.readers import read
from allanite.readers.columns import headers, layout, parse

finite = st.floats(allow_nan=False, allow_infinity=False, width=64).filter(lambda x: x == 0 or 1e-300 < abs(x) < 1e300)
tables = st.integers(2, 4).flatmap(
    lambda width: st.lists(st.lists(finite, min_size=width, max_size=width), min_size=3, max_size=12)
)
HEADERS = {
    "brackets": ("gx [deg/s]", "gy [deg/s]", "ax [g]", "az [m/s^2]"),
    "parentheses": ("gx (deg/s)", "gy (deg/s)", "ax (g)", "az (m/s^2)"),
    "suffix": ("gx_dps", "gy_deg_per_s", "ax_g", "az_mps2"),
}
UNITS = ("deg/s", "deg/s", "g", "m/s^2")


shapes = st.fixed_dictionaries(
    {
        "delimiter": st.sampled_from([",", ";", "\t", " ", "   ", ", ", " \t "]),
        "style": st.sampled_from(sorted(HEADERS)),
        "clock": st.sampled_from([("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]),
        "ends": st.sampled_from(["\n", "\r\n", "\r"]), "trailing": st.booleans(), "bom": st.booleans(),
        "comment": st.sampled_from(["", "#", "%", "//"]),
        "final": st.booleans(),
    }
)  # fmt: skip


def written(rows, shape):
    width, delimiter = len(rows[0]), shape["delimiter"]
    unit, size = shape["clock"]
    stamps = [repr(round(k * 0.01 / size)) if unit != "s" else repr(k * 0.01) for k in range(len(rows))]
    lines = [delimiter.join((f"time [{unit}]", *HEADERS[shape["style"]][:width]))]
    lines += [delimiter.join([stamp, *map(repr, row)]) for stamp, row in zip(stamps, rows, strict=True)]
    lines = [line + delimiter * (shape["trailing"] and delimiter in ",;\t") for line in lines]
    if shape["comment"]:
        lines = [f"{shape['comment']} made by a logger", *lines, f"{shape['comment']} the end, really"]
    return "\ufeff" * shape["bom"] + shape["ends"].join(lines) + shape["ends"] * shape["final"]


@tried(150, rows=tables, shape=shapes)
def test_whatever_the_shape_the_numbers_come_back(write, rows, shape):
    recording = read(write(written(rows, shape)))
    assert [record.unit for record in recording] == list(UNITS[: len(rows[0])])
    for i, record in enumerate(recording):
        assert record.rate == pytest.approx(100.0)
        assert np.array_equal(record.values, np.array([row[i] for row in rows]))


@tried(
    60,
    rows=st.lists(st.tuples(*[st.integers(-(2**53) - 1000, 2**53 + 1000)] * 2), min_size=3, max_size=20),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    header=st.booleans(),
)
def test_integers_stay_exact(write, rows, delimiter, header):
    text = (f"gx{delimiter}gy\n" if header else "") + "".join(f"{a}{delimiter}{b}\n" for a, b in rows)
    recording = read(write(text), rate=10, unit="arcsec", kind="count", scale=0.1, channels=["1", "2"])
    for i, record in enumerate(recording):
        assert record.values.dtype == np.int64
        assert record.values.tolist() == [row[i] for row in rows]


@rows("header, name, unit", [
    ("gx [deg/s]", "gx", "deg/s"), ("gx(deg/s)", "gx", "deg/s"), ("Gyroscope X (deg/s)", "Gyroscope X", "deg/s"),
    ("w_RS_S_x [rad s^-1]", "w_RS_S_x", "rad s^-1"), ("a_x [m s-2]", "a_x", "m s-2"), ("acc [m/s2]", "acc", "m/s2"),
    ("acc [m/s²]", "acc", "m/s²"), ("gx [°/s]", "gx", "°/s"), ("arw [deg/sqrt(h)]", "arw", "deg/sqrt(h)"),
    ("gyro_x_dps", "gyro_x_dps", "deg/s"), ("gyro_x_rad_per_s", "gyro_x_rad_per_s", "rad/s"),
    ("raw_angular_rate_x_deg_per_s", "raw_angular_rate_x_deg_per_s", "deg/s"), ("acc_x_g", "acc_x_g", "g"),
    ("acc_x_mps2", "acc_x_mps2", "m/s^2"), ("accelerometer_m_s2[0]", "accelerometer_m_s2[0]", "m/s^2"),
    ("bmi160_g_x[mDeg]", "bmi160_g_x", "mDeg"), ("gx [LSB]", "gx", ""), ("gyro_x", "gyro_x", ""),
    ("angular_velocity.x", "angular_velocity.x", ""), ("timestamp [ns]", "timestamp", "ns"),
    ("time_us", "time_us", "us"), ("T [degC]", "T", "degC"), ("", "", ""),
])  # fmt: skip
def test_headers(header, name, unit):
    assert headers.split(header) == (name, unit)


GYRO = {"rate": 100, "unit": "deg/s"}
OTHERS = "index,gx [deg/s],Temp1,temperature,packet_no,mag_x [G],count,status"
TABLES = {  # a heading or a text, how it is read, the units of its channels, words of its notes
    "units in the heading": ("time [s],gx [deg/s],ax [g],T [degC]\n0,1,2,30\n0.01,2,3,30\n0.02,1,2,31\n", {},
        {"gx": "deg/s", "ax": "g"},
        [("rate 100.0 Hz from column 'time [s]'",), ("unit deg/s from the header of 'gx [deg/s]'",),
         ("unit g from the header of 'ax [g]'",), ("left out", "'T [degC]'")]),
    "a unit of one sensor": ("gx [rad/s],ax [g],gy", GYRO, {"gx": "deg/s", "ax": "g", "gy": "deg/s"},
        [("unit g, which does not match deg/s", "ax [g]")]),
    "that of a named column": ("gx [rad/s],ax [g],gy", GYRO | {"channels": ["ax"]}, {"ax": "deg/s"}, []),
    "names of the other sensor": ("gx,gy,ax,acc_z", GYRO, {"gx": "deg/s", "gy": "deg/s"},
        [("left out", "accelerometer by its name", "'ax', 'acc_z'")]),
    "other units, and none": ("gx [deg/s],foo,roll [deg]", {"rate": 100}, {"gx": "deg/s"},
        [("left out", "the unit is unknown", "'foo'"), ("left out", "'roll [deg]'")]),
    "temperatures, counters and a compass": (OTHERS, {"rate": 100}, {"gx": "deg/s"}, []),
    "a counter by name": (OTHERS, GYRO | {"channels": "count"}, {"count": "deg/s"}, []),
    "equal names": ("g [deg/s],g [deg/s],g [rad/s]", {"rate": 9}, {"g": "deg/s", "g 2": "deg/s", "g 3": "rad/s"}, []),
    "a heading in a comment": ("#timestamp [ns],w_RS_S_x [rad s^-1],a_RS_S_x [m s^-2]\n"
        + "".join(f"{1403636579758555392 + 5_000_000 * k},{k % 3}.5,9.{k % 4}\n" for k in range(20)), {},
        {"w_RS_S_x": "rad s^-1", "a_RS_S_x": "m s^-2"}, [("names from the comment on line 1",), ("rate 200.0 Hz",)]),
    "lines above": ("Logger 7\nserial;17\n\ntime [s];gx [deg/s];gy [deg/s];\n0;1;2;\n0.1;1.5;2.5;\n0.2;1;2;\n", {},
        {"gx": "deg/s", "gy": "deg/s"}, [("2 lines above", "Logger 7")]),
    "decimal commas": ("time [s];gx [deg/s]\n0,0;1,5\n0,1;2\n", {}, {"gx": "deg/s"}, [("decimal sign is a comma",)]),
    "a table of pandas": (",0,1\n" + "".join(f"{k},{k % 3}.5,0.25\n" for k in range(20)), GYRO,
        {"0": "deg/s", "1": "deg/s"}, [("used as column names",), ("left out", "'column 1'")]),
}  # fmt: skip


@rows("text, options, units, notes", TABLES.values(), ids=[*TABLES])
def test_what_is_a_channel_and_in_which_unit(write, text, options, units, notes):
    count = text.count(",") + 1
    below = "\n" + f"{','.join(['1'] * count)}\n{','.join(['2.5'] * count)}\n" * 10
    recording = read(write(text if "\n" in text else text + below), **options)
    assert {record.name: record.unit for record in recording} == units
    assert [words for words in notes if not noted(recording, *words)] == []


@rows("text, values", [
    ("  time [s]   gx [deg/s]   gy (deg/s)\n  0.0  1.0 2.0\n  0.1 \t 1.5 2.5\n\n", [[1.0, 1.5], [2.0, 2.5]]),
    ("time [s];gx [deg/s]\n0,0;1,5\n0,1;-2,25\n0,2;1e-3\n", [[1.5, -2.25, 1e-3]]),
    ('"time [s]","gx [deg/s]"\n"0.0","1.5"\n"0.1","2.5"\n"0.2","1.5"\n', [[1.5, 2.5, 1.5]]),
    ("gx [deg/s],gy [deg/s]\n+1.5, 2\n , NaN\n-1.5,\n+2.5,nan\n",
     [[1.5, np.nan, -1.5, 2.5], [2, np.nan, np.nan, np.nan]]),
], ids=["blanks", "decimal commas", "quoted", "signs and blank cells"])  # fmt: skip
def test_cells_in_other_forms(write, text, values):
    np.testing.assert_array_equal([record.values for record in read(write(text), rate=10)], values)


def test_only_other_columns_are_no_recording(write):
    path = write("temp,index\n" + "20.5,1\n20.75,2\n" * 10)
    refused(UsageError, r"no column is recognized.*channels=.*'temp'", lambda: read(path, **GYRO))


@rows("header, first", [("t [s],gx [deg/s]", "0,1"), ("t [s],gx [deg/s],gy [deg/s]", "0,1,2")])
def test_a_first_row_of_0_and_1_below_a_heading_is_a_row(write, header, first):
    more = "".join(",".join([str(k / 4), str(k % 3), "0"][: first.count(",") + 1]) + "\n" for k in range(1, 30))
    record = read(write(f"{header}\n{first}\n{more}"))["gx"]
    assert (record.size, record.values[0], record.rate) == (30, 1, pytest.approx(4.0))


def test_a_leading_clock_without_header_is_never_a_gyro(write):
    path = write("".join(f"{k * 0.01:.2f} {k % 3}.5 {k % 4}.25\n" for k in range(50)))
    recording = read(path, **GYRO)
    assert recording.channels == ("column 2", "column 3")
    assert noted(recording, "increases in every row", "time='1'", "column 1")
    refused(UsageError, "time='1'", lambda: read(path, unit="deg/s"))
    timed = read(path, unit="deg/s", time="1")
    assert (timed.channels, timed[0].rate) == (("column 2", "column 3"), pytest.approx(100.0))
    assert read(path, **GYRO, channels=["1", "3"]).channels == ("column 1", "column 3")


@rows("delimiter", [",", ";", "\t", " "])
@rows("line", [2, 3, 60, 200])
def test_words_among_numbers_are_named_by_line_and_column(write, delimiter, line):
    lines = [delimiter.join(("gx", "gy"))] + [delimiter.join(("1.5", "2.5"))] * 200
    lines[line - 1] = delimiter.join(("1.5", "oops"))
    lines[1:1] = ["# a comment"] * 2
    path, words = write("\n".join(lines) + "\n"), f"line {line + 2}, column 'gy': 'oops' is not a number"
    refused(DataError, words, lambda: read(path, rate=10, unit="deg/s"))


@rows("content, words", [
    ("gx,gy\n" + "1.5,2.5\n" * 29 + "1.5,2.5,3\n" + "1.5,2.5\n" * 20, "line 31 has 3 columns instead of 2"),
    ("gx,gy,gz\n" + "1.5,2.5\n" * 9, "names 3 columns.*have 2"),
    ("gx\n" + "1.5\n" * 30_000 + "\0" * 10, "zero byte"),  # beyond the head
])  # fmt: skip
def test_a_row_of_another_width_is_named(write, content, words):
    refused(DataError, words, lambda: read(write(content), rate=10, unit="deg/s"))


def test_a_last_line_that_was_cut_off_is_left_out_with_a_note(write):
    recording = read(write("gx,gy\n" + "1.5,2.5\n" * 29 + "1."), rate=10, unit="deg/s")
    assert recording["gx"].size == 29
    assert noted(recording, "last line", "'1.'", "left out")


def test_a_file_of_many_blocks(write):
    # integers that become fractions after the first megabyte, comments in the middle, empty lines
    rows = ["1"] * 400_000 + ["# pause", "", "0.5"] + ["2"] * 400_000
    values = read(write("gx [deg/s]\n" + "\n".join(rows)), rate=10)["gx"].values
    assert (len(values), values[0], values[400_000], values[-1]) == (800_001, 1.0, 0.5, 2.0)


NOISE = np.random.default_rng(5).normal(size=(60, 6)).round(4)


def lines(form):
    """Lines of this form for each row: its number 0, its readings 1 to 6, and its time t."""
    return "".join(form.format(k, *row, t=k * 0.01) + "\n" for k, row in enumerate(NOISE.tolist()))


@rows("delimiter, name", paired([",", ", ", ";", " ", "\t"], ["", "gx [deg/s]"]))
def test_a_recording_on_one_line(write, delimiter, name):
    values = np.random.default_rng(1).normal(size=90_000).round(5)
    text = delimiter.join([*([name] if name and delimiter != " " else []), *map(repr, values.tolist())])
    recording = read(write(text), rate=100, unit="deg/s")
    assert len(recording) == 1
    assert np.array_equal(recording[0].values, values)
    assert noted(recording, "line of 90000 numbers", "one channel")


def test_a_channel_on_each_line(write):
    values = np.random.default_rng(1).normal(size=(3, 2000)).round(5)
    lines = (" ".join(map(str, [f"g{axis}", *row])) for axis, row in zip("xyz", values.tolist(), strict=True))
    recording = read(write("\n".join(["# a matrix", *lines, ""])), rate=100, unit="deg/s")
    assert recording.channels == ("gx", "gy", "gz")
    assert np.array_equal([record.values for record in recording], values)


@rows("header", ["", "t [s],gx [deg/s],gy [deg/s]\nax [g],ay [g],az [g],T\n", "# by two lines\n\n"])
def test_two_lines_for_a_sample(write, header):
    text = lines("{t:.2f},{1},{2}\n{3},{4},{5},20.5")
    options = {} if "gx" in header else {"time": "1", "unit": "deg/s", "channels": "2,3"}
    recording = read(write(header + text), **options)
    assert recording[0].rate == pytest.approx(100.0)
    assert np.array_equal([record.values for record in recording][:2], NOISE[:, :2].T)
    assert recording.channels == (("gx", "gy", "ax", "ay", "az") if "gx" in header else ("column 2", "column 3"))
    assert noted(recording, "2 lines of 3, 4 numbers", "one row")


def test_an_empty_line_of_a_single_column_is_a_missing_sample(write):
    for ends, blank in (("\n", ""), ("\r\n", ""), ("\n", "  \t")):
        lines = ["gx [deg/s]", "", "1", "2", blank, "4", blank, blank, "7", "", "# paused", "", "8", "9", "", ""]
        values = read(write(ends.join(lines)), rate=10)["gx"].values
        np.testing.assert_array_equal(values, [1, 2, np.nan, 4, np.nan, np.nan, 7, 8, 9])
    # rows that are all apart have none between them, and rows of several columns are no cells
    assert read(write("gx [deg/s]\n" + "\n\n".join(map(str, range(50)))), rate=10)["gx"].size == 50
    assert read(write("gx [deg/s],gy [deg/s]\n1,2\n\n3,4\n5,6\n"), rate=10)["gx"].size == 3


def test_a_heading_of_many_columns_is_one(write):
    names = [f"g{i:0150}x [deg/h]" for i in range(1200)]  # more than is looked at of other files
    rows = "".join(f"{i / 10}" + f",{i}.5" * len(names) + "\n" for i in range(3))
    recording = read(write(",".join(["t [s]", *names]) + "\n" + rows))
    assert [record.name for record in recording] == [name[:-8] for name in names]
    assert (len(recording), recording[-1].rate, recording[-1].unit) == (1200, 10.0, "deg/h")


@rows("text, words", [
    ("\ufeff", "blank lines only"), ("\n" * 200_000, "bytes of the file are blank lines"),
    ("gx [deg/s]\n1\n" + "1" * (3 << 20) + "\n2\n", r"line 3 has 3145728 bytes; expected one row per sample"),
    ("t [s]\n0\n0.01\n0.02\n", "times and no samples"),
    ("application/vnd.oasis.opendocument.spreadsheet", "an OpenDocument sheet"),
])  # fmt: skip
def test_what_is_no_table_is_named(write, text, words):
    refused(DataError, words, lambda: read(write(text)))


def test_blank_lines_between_rows(write):
    recording = read(write("t gx gy\n\n" + lines("{t:.2f}\t {1}  \t{2}\n   ")), unit="deg/s")
    assert np.array_equal(recording["gy"].values, NOISE[:, 1])


def test_ids_of_sensors_between_the_columns(write):
    text = lines("{t:.2f}, 3, {1}, {2}, {3}, 4, {4}, {5}, {6}, 5, 1.5, 2.5, {1}")
    recording = read(write(text), time="1", unit="rad/s", channels=["sensor 4 x", "sensor 4 z"])
    assert np.array_equal([record.values for record in recording], NOISE[:, [3, 5]].T)
    assert noted(recording, "2 (always 3), 6 (always 4), 10 (always 5)", "ids of sensors")
    assert read(write(text), rate=100, unit="rad/s").channels[0] == "sensor 3 x"


def test_a_row_for_each_sensor(write):
    text = lines("4,{t:.2f},{1},{2},{3}\n3,{t:.2f}1,{4},{5},{6}")
    recording = read(write("id,t [s],x,y,z\n" + text), unit="rad/s", channels=["4 x", "4 z"])
    assert np.array_equal(recording["4 z"].values, NOISE[:, 2])
    assert recording[0].rate == pytest.approx(100.0)
    assert noted(recording, "rows belong to 2 sensors according to column 'id': 3 (60 rows), 4 (60 rows)")
    bare = read(write(text), rate=100, unit="rad/s", channels=["4 column 3"])
    assert np.array_equal(bare[0].values, NOISE[:, 0])


def test_rows_of_sensors_with_different_rates(write):
    both = lines("GYRO,{0}0,{1},{2},{3}\nMAG,{0}3,{4},{5},{6}").splitlines(keepends=True)
    text = "".join(line for k, line in enumerate(both) if k % 6 != 1)  # every third of the others is missing
    path = write("sensor,t_ms,x,y,z\n" + text)
    recording = read(path, unit="deg/s")
    assert recording.channels == ("GYRO x", "GYRO y", "GYRO z")
    assert (recording[0].size, recording[0].rate) == (60, pytest.approx(100.0))
    path = write("sensor,t_ms,x,y,z\n" + text.replace("GYRO", "U").replace("MAG", "V"))
    refused(DataError, r"different lengths .*'U x' has 60.*'V x' has 40.*channels=", lambda: read(path, unit="deg/s"))
    assert read(path, unit="deg/s", channels="U x")[0].size == 60


def test_coarse_readings_are_no_ids(write):
    codes = np.random.default_rng(2).integers(-1, 2, 400)
    recording = read(write("".join(f"{code}\t{code * 2}\n" for code in codes)), rate=10, unit="deg/s")
    assert recording[0].size == 400


STAMPS = {
    "date and time of day": "date,time,gx [deg/s]\n2018-04-25,15:20:{s:06.3f},{v}\n",
    "time of day first": "time;date;gx [deg/s]\n15:20:{s:06.3f};25.04.2018;{v}\n",
    "no names": "2018/04/25   15:20:{s:06.3f}    {v}\n", "time of day": "clock,gx [deg/s]\n15:20:{s:06.3f},{v}\n",
    "iso": "stamp,gx [deg/s]\n2018-04-25T15:20:{s:09.6f}Z,{v}\n",
    "iso with a zone": "stamp,gx [deg/s]\n2018-04-25T15:20:{s:06.3f}+02:00,{v}\n",
    "slashes": "stamp,gx [deg/s]\n04/25/2018 3:20:{s:06.3f} PM,{v}\n",
    "a colon before the fraction": "stamp,gx [deg/s]\n2018.04.25 15:20:{c},{v}\n",
}  # fmt: skip
"""A heading, and the form of a row."""


@rows("shape", list(STAMPS))
def test_dates_in_words(write, shape):
    *heading, form = STAMPS[shape].splitlines(keepends=True)
    rows = (
        form.format(s=k / 50, v=value, c=f"{k // 50:02d}:{k % 50 * 20:03d}")
        for k, value in enumerate(NOISE.ravel().tolist())
    )
    recording = read(write("".join([*heading, *rows])), unit="deg/s")
    assert (recording[0].rate, recording.findings) == (pytest.approx(50.0), ())
    assert np.array_equal(recording[0].values, NOISE.ravel())
    if shape in ("date and time of day", "time of day first", "no names"):
        assert noted(recording, "columns 1 and 2 are used as date and time of day")


LONG = np.random.default_rng(6).normal(size=(200, 6)).round(4)
SIX_AXES = ["gx", "gy", "gz", "ax", "ay", "az"]
GROUPED = ["t", *(f"{group} {axis}" for group in ("gyro", "acc") for axis in "xyz")]
HEADED = {
    "units of groups": ("t [s];gyro [deg/s];;;acc (g);;\n;x;y;z;x;y;z", GROUPED),
    "units below": ("t;gyro;;;acc;;\n;x;y;z;x;y;z\ns;deg/s;;;g;;", GROUPED),
    "units between": ("t;gyro;;;acc;;\ns;deg/s;;;g;;\n;x;y;z;x;y;z", GROUPED),
    "an empty cell first": ("t\tgx\tgy\tgz\tax\tay\taz\n\tdeg/s\tdeg/s\tdeg/s\tg\tg\tg", ["t", *SIX_AXES]),
    "a line above": ("log;7b\nt;gx;gy;gz;ax;ay;az\ns;deg/s;deg/s;deg/s;g;g;g", ["t", *SIX_AXES]),
}


@rows("heading, names", list(HEADED.values()), ids=list(HEADED))
def test_headings_of_several_lines(write, heading, names):
    mark = "\t" if "\t" in heading else ";"
    lines = [mark.join([f"{i / 50}", *map(str, LONG[i])]) for i in range(100)]
    recording = read(write("\n".join([heading, *lines[:50], "# a pause", *lines[50:], ""])))
    assert list(recording.channels) == names[1:]
    assert [record.unit for record in recording] == ["deg/s"] * 3 + ["g"] * 3
    assert noted(recording, "skipped 1 comment among the rows")


@rows("above", [0, 150, 190, 210, 700])
def test_a_few_lines_show_the_layout_of_all(above, monkeypatch):
    long = "".join(f"remark {i}, of the logger\n" for i in range(above)) + "t,gx,gy,state\n"
    long += "".join(f"{i / 100};{i % 7 / 2};{-i % 5},5;ok\n".replace(";", ",") for i in range(2000))
    mixed = long.replace(",gx", ",gx [°/s]").replace(",5,ok", ',,"a, b"')
    for data in (long.encode(), mixed.encode(), long.replace(",", "\t").encode(), long.replace(",", " ").encode()):
        few = layout.find(data)
        with monkeypatch.context() as patch:
            patch.setattr(layout, "LINES", layout.HEAD)
            assert layout.find(data) == few
        assert data[few.offset :].startswith(b"0.0")
        assert parse.signs(data, few.offset) == set(data[few.offset :].decode()) & set(parse.SIGNS)


@rows("cell", ["1.25", "+3", "", "word", "7"])
def test_a_large_text_is_parsed_in_pieces(cell, monkeypatch):
    lines = [f"{i},{i / 8},{cell if i == 30_000 else -i}" for i in range(40_000)]
    data = "\n".join(["a,b,c", *lines, ""]).encode()
    form = layout.find(data)
    try:
        whole = parse.columns(data, form)
    except DataError as error:
        whole = str(error)
    monkeypatch.setattr(parse, "PIECE", 300_000)
    if isinstance(whole, str):
        refused(DataError, whole, lambda: parse.columns(data, form))
        return
    for mine, known in zip(parse.columns(data, form)[0], whole[0], strict=True):
        np.testing.assert_array_equal(mine, known, strict=True)


def test_a_signal_that_ends_no_program_does_not_end_the_reading(write, monkeypatch):
    def cancelled(*_, **__):
        monkeypatch.undo()
        raise pa.ArrowCancelled("received signal 2")

    path = write("gx [deg/s]\n1\n2\n")
    monkeypatch.setattr(csv, "read_csv", cancelled)
    assert read(path, rate=1.0)[0].values.tolist() == [1, 2]


def test_a_row_of_whole_numbers_is_no_heading():
    for text, names in (("0,1\n0.1,0.5\n0.2,0.4\n", ("", "")), ("0,1\n0.7,0.5\n0.2,0.4\n", ("0", "1"))):
        assert layout.find(text.encode()).names == names


@rows("first, later", [("02/11/26", "02/12/26"), ("11.02.26", "12.02.26"), ("2/28/2026", "3/1/2026")])
def test_the_order_of_a_date_is_seen_where_it_matters(write, first, later):
    clocks = (f"{first} 23:59:59", f"{later} 00:00:00")
    lines = (f"{clock}.{i:02d},{LONG[i, k]}\n" for k, clock in enumerate(clocks) for i in range(100))
    assert read(write("time,gx [deg/s]\n" + "".join(lines)))["gx"].rate == pytest.approx(100)


def test_a_log_of_novatel_is_rows_of_counts(write):
    row = "%RAWIMUSXA,2051,{t};00,11,2051,{t},00000077,-327000,{i},2,3,-4,5*1234abcd\n#BESTPOSA,COM1;1*aabbccdd\n"
    path = write("".join(row.format(t=i / 100, i=i % 7) for i in range(60)))
    names = ["delta_angle_z", "delta_angle_-y", "delta_angle_x"]
    recording = read(path, scale="2e-9rad", kind="increment", channels=names)
    assert [record.values[0] for record in recording] == [3, -4, 5]
    assert recording[0].rate == pytest.approx(100)


def test_units_that_gravity_contradicts_are_doubted(write):
    down = "".join(f"{i / 50},{x},{y},{1 + z}\n" for i, (x, y, z) in enumerate(LONG[:, :3] / 500))
    (warning,) = read(write("t,ax [m/s^2],ay [m/s^2],az [m/s^2]\n" + down)).findings
    assert "0.102 times gravity, and is gravity in g" in str(warning)
    path = write(",".join(["t", *(f"linear_acceleration.{axis}" for axis in "xyz")]) + "\n" + down)
    refused(UsageError, "contradicts the unit that sensor_msgs/Imu defines", lambda: read(path))


def test_a_time_of_day_goes_past_midnight(write):
    seconds = 86_380 + np.arange(400) / 10
    clock = [f"{int(s) // 3600 % 24:02d}:{int(s) // 60 % 60:02d}:{s % 60:04.1f}" for s in seconds]
    recording = read(write("time,gx [deg/s]\n" + "".join(f"{c},{k % 7}.5\n" for k, c in enumerate(clock))))
    assert (recording["gx"].rate, recording.findings) == (pytest.approx(10.0), ())
    # a damaged date is named
    rows = [f"2018-04-25 15:20:{k:02d}.5,{k % 3}.5" for k in range(60)]
    rows[30] = "yesterday,1.5"
    path, words = (
        write("time,gx [deg/s]\n" + "\n".join(rows)),
        "row 31 of the data, column 'time': 'yesterday' is not a date",
    )
    refused(DataError, words, lambda: read(path))


@rows(("first", "repeated", "last"), [("gx (", " ", ""), ("gx ", "(", ""), ("gx [", "s*", "s]"), ("", "a[", "")])
def test_no_header_takes_the_square_of_its_length(first, repeated, last):
    header = first + 60_000 * repeated + last  # whose square would take minutes
    assert headers.split(header) == (header.strip(), "")
    layout.find(f"{header} b\n1 2\n".encode())


@rows("word", ["12:20", "12:20:20", "2018-04-25", "2018-04-25 12:20", "x"])
def test_runs_of_blanks_take_no_square_of_their_length(write, word):
    rows = "".join(f"{word}{' ' * 60_000}x,{i % 7}.5\n" for i in range(10))
    assert read(write(f"when,gx{' ' * 60_000}\n{rows}"), rate=1.0, unit="deg/s")[0].name == "gx"


@rows("cell", ['"y', '"2'])
def test_a_quotation_mark_that_is_not_closed_is_named_by_its_line(cell, write):
    path = write("gx [deg/s],b\n" + "1.5,x\n" * 20 + f"1.5,{cell}\n" + "2.5,z\n" * 20)
    refused(DataError, "line 22: a quotation mark is not closed", lambda: read(path, rate=100))


def test_a_column_of_many_words_is_the_same_whether_it_is_kept_or_not(write, monkeypatch):
    path = write("gx [deg/s],words,few\n" + "".join(f"{k % 7}.5,w{k},w{k // 90_000}\n" for k in range(100_000)))
    kept = read(path, rate=100)
    monkeypatch.setattr("allanite.readers.columns.parse.JUDGED_BYTES", 1 << 30)
    whole = read(path, rate=100)
    assert (kept.channels, kept.notes) == (whole.channels, whole.notes)
    assert np.array_equal(kept["gx"].values, whole["gx"].values)
