"""What the small functions of the readers make of typical input."""

import numpy as np
import pytest

import allanite as al
from allanite.readers.clock.clocks import unwrapped
from allanite.readers.clock.findings import SampleGrid, duration, resolution
from allanite.readers.clock.stamps import mended
from allanite.readers.columns import dates, headers
from allanite.readers.columns.column import FileColumn, headed, split
from allanite.readers.columns.containers import any_inertial
from allanite.readers.columns.layout import is_number, statement
from allanite.readers.columns.resolver import angle_of
from allanite.readers.formats.text import FileSheet
from allanite.readers.options import parts_of, stated_unit
from allanite.readers.parts import bytes_of, size_in_words

HOUR = 3600 * 10**9


def test_words_of_headers_and_lines():
    units = {
        "gx [deg/s]": ("gx", "deg/s"), "acc_x_mps2": ("acc_x_mps2", "m/s^2"), "gyro_rad[0]": ("gyro_rad[0]", "rad"),
    }  # fmt: skip
    assert {header: headers.split(header) for header in units} == units
    assert [any_inertial(names) for names in (["time [s]", "gx [deg/s]"], ["gyro_x"], ["T [degC]"])] == [1, 1, 0]
    other = (("Temp1",), ("yaw", "deg/s"), ("yaw_rate",), ("mag_x", "G"), ("gyro_device_id",), ("gyro_integral_dt",))
    assert [headers.is_other(*name) for name in (*other, ("gyro_counts_x",))] == [1, 0, 0, 1, 1, 1, 0]
    assert [headers.is_driver(*name) for name in (("Temp1",), ("baro", "hPa"), ("seq",), ("yaw", "deg"))] == [
        1, 1, 0, 0,
    ]  # fmt: skip
    names = ("header.frame_id", "deltaAngleDt", "accel_clip_count", "gyro_x")
    assert list(map(headers.identifies, names)) == [True, True, True, False]
    assert [is_number(*cell) for cell in (("-1.5e-3",), ("1,5", ","), ("1_000",), ("0x10",))] == [1, 1, 0, 0]
    column = headed(np.array([1.0, 2.0]), 1, "gx [deg/s]")
    assert (column.name, column.unit, column.label) == ("gx", "deg/s", "column 'gx [deg/s]'")
    stated = [statement(1, text).rate for text in ("// Update Rate: 100.0Hz", "Sample interval: 0.01 s")]
    assert (stated, statement(3, "FS = 250 dps"), statement(4, "rate: 115200 baud")) == ([100.0, 100.0], None, None)
    matrix = [(header, len(values)) for header, values in split("gyro [deg/s]", np.zeros((3, 50)))]
    assert matrix == [(f"gyro {i} [deg/s]", 50) for i in (1, 2, 3)]


def test_what_is_stated_of_units_and_sizes():
    assert (stated_unit("deg/s"), stated_unit({"gyro": "deg/s", "ax": "g"})) == ("deg/s", "gyro=deg/s,ax=g")
    assert (parts_of("gyro=deg/s, ax=g"), parts_of("deg/s")) == ((("gyro", "deg/s"), ("ax", "g")), ())
    assert (size_in_words(72e9), size_in_words(1500)) == ("72 GB", "1.5 kB")
    assert (bytes_of("1GB"), bytes_of("1.5 MB")) == (1000000000, 1500000)
    sheet = FileSheet((FileColumn(np.array([0.0, 180.0]), 1, "h", "deg"),))
    assert sheet.values("h", "rad") == pytest.approx([0.0, np.pi])


def test_stamps_dates_and_grids():
    counts, bits = unwrapped(np.array([250, 253, 0, 3, 6]))
    assert (counts.tolist(), bits) == ([250, 253, 256, 259, 262], 8)
    assert list(map(duration, (1.0, 0.0025, 2e-6, 0.0))) == ["1 s", "2.5 ms", "2 us", "0 s"]
    grid = SampleGrid(0.01, places=np.array([0, 1, 3]))
    assert (grid.lost, repr(grid.put(np.array([5.0, 6.0, 7.0])).tolist())) == (1, "[5.0, 6.0, nan, 7.0]")
    assert (resolution(np.array([0.002, 0.003, 0.0, 0.002])), resolution(np.ones(3) / 7)) == (0.001, 0.0)
    stamps, damaged = mended(np.array([10, 20, 30, 40, 5, 60, 70, 80, 90, 100]))
    assert (stamps.tolist(), damaged.tolist()) == (list(range(10, 101, 10)), [4])
    assert all(map(dates.pattern_of, ("2018-04-25", "15:20:24.125", "25.4.2018 3:20 pm")))
    assert (dates.pattern_of("1.25"), dates.pattern_of("GYRO")) == ("", "")
    assert dates.continued(np.array([1, 2]) * HOUR, np.array([95]) * HOUR).tolist() == [97 * HOUR, 98 * HOUR]
    hours = np.array([22, 23, 0, 1], dtype="timedelta64[h]").astype("timedelta64[ns]")
    assert (dates.past_midnight(hours) // HOUR).tolist() == [22, 23, 24, 25]


def test_the_angle_of_sine_and_cosine():
    true = np.linspace(0.0, 20.0, 201)
    sine, cosine = (al.Record(3 * f(true), rate=10.0, unit="V", name=f.__name__) for f in (np.sin, np.cos))
    angle, findings, _ = angle_of(sine, cosine)
    assert angle.values == pytest.approx(true)
    assert (angle.unit, findings) == ("rad", [])
