"""Each line to copy holds what the file says, and placeholders for the rest; with the truth in their place it works."""

import json
import re
import shlex
from typing import NamedTuple

import numpy as np
import pytest
from tests.commands import run
from tests.rows import rows

from allanite.core.errors import MEANINGS

SIZE = 600
RNG = np.random.default_rng(17)
TIME = np.arange(SIZE)


def triple(size, gravity=0.0, offset=0.0):
    """Axes with noise of a size; the last bears gravity, the first an offset."""
    return [size * RNG.standard_normal(SIZE) + bias for bias in (offset, 0.3 * offset, gravity)]


def counts(*columns):
    return [np.rint(column).astype(int) for column in columns]


class Case(NamedTuple):
    """A file, what the line to copy is, what belongs in the place of each placeholder, and rate, units and kinds."""

    header: str
    columns: list
    typed: str
    fill: tuple[str, ...]
    rate: float
    units: tuple[str, ...]
    kind: str = "rate"
    options: str = ""


GYRO, SIX = ("rad/s",) * 3, ("deg/s",) * 3
CASES = {
    "a clock in ns without a heading": Case(
        "", [55 * 10**12 + TIME * 2_500_000, *triple(0.02, 9.7), *triple(0.004)],
        "--time 'column 1[ns]' --unit '2=m/s^2,3=m/s^2,4=m/s^2,5=UNIT,6=UNIT,7=UNIT'", GYRO, 400.0,
        ("m/s^2",) * 3 + GYRO),
    "a clock in us, gyros first": Case(
        "", [7_000 + TIME * 8000, *triple(0.1), *triple(2.0, -996.0)],
        "--time 'column 1[us]' --unit '5=mg,6=mg,7=mg,2=UNIT,3=UNIT,4=UNIT'", SIX, 125.0, SIX + ("mg",) * 3),
    "a clock in s": Case(
        "", [0.25 + TIME / 80, *triple(0.1)], "--time 'column 1[s]' --unit UNIT", ("rad/s",), 80.0, GYRO),
    "a counter": Case("", [TIME + 1, *triple(0.1)], "--rate HZ --unit UNIT", ("70", "deg/s"), 70.0, SIX),
    "neither rate nor heading": Case("", triple(0.1), "--rate HZ --unit UNIT", ("70", "deg/h"), 70.0, ("deg/h",) * 3),
    "a clock in one of two units": Case(
        "stamp,gx [deg/s]", [TIME * 200, triple(0.1)[0]], "--time 'stamp[UNIT]'", ("ms",), 5.0, ("deg/s",)),
    "French names": Case(
        ",".join(["temps", *(f"{name} {axis}" for name in ("vitesse angulaire", "accélération") for axis in "xyz")]),
        [1_650_000_000_000 + TIME * 20, *triple(0.1), *triple(2.0, 1020.0)], "--unit 'gyro=UNIT,accel=mg'",
        ("deg/s",), 50.0, SIX + ("mg",) * 3),
    "a second sensor without a name": Case(
        "t,ax,ay,az,rx,ry,rz,load", [TIME / 50, *triple(0.02, 9.8), *triple(0.1), triple(4.0)[0]],
        "--unit 'accel=m/s^2,5=UNIT,6=UNIT,7=UNIT'", SIX, 50.0, ("m/s^2",) * 3 + SIX),
    "names of ROS over other units": Case(
        ",".join(["t", *(f"{name}.{axis}" for name in ("angular_velocity", "linear_acceleration") for axis in "xyz")]),
        [TIME / 50, *triple(0.1), *triple(2.0, 1020.0)], "--unit 'gyro=UNIT,accel=mg'", ("deg/s",), 50.0,
        SIX + ("mg",) * 3),
    "biases of gyros with the length of gravity in g": Case(
        "", [TIME / 50, *triple(0.08, 1.0, 0.05)], "--time 'column 1[s]' --unit UNIT", ("deg/s",), 50.0, SIX),
    "the clock that was chosen without its unit": Case(
        "", [9 * 10**12 + TIME * 1_600_000, *triple(0.1)], "--time 1 --unit UNIT", ("deg/s",), 625.0, SIX,
        options="--time 1"),
    "g with an offset of 9 %": Case(
        "t,ax,ay,az,gx,gy,gz", [TIME / 50, *triple(0.01, -1.09, 0.05), *triple(0.1)],
        "--unit gyro=UNIT,accel=g", ("deg/s",), 50.0, ("g",) * 3 + SIX),
    "g too small": Case(
        "t,acc_x,acc_y,acc_z", [TIME / 50, *triple(0.01, 0.93)], "--unit g", (), 50.0, ("g",) * 3),
    "m/s^2 too small": Case(
        "t,acc_x,acc_y,acc_z", [TIME / 50, *triple(0.1, 9.5)], "--unit 'm/s^2'", (), 50.0, ("m/s^2",) * 3),
    "mm/s^2": Case("t,ax,ay,az", [TIME / 50, *triple(20.0, 9750.0)], "--unit 'mm/s^2'", (), 50.0, ("mm/s^2",) * 3),
    "1024 counts per g": Case(
        "t,ax,ay,az", [TIME / 50, *counts(*triple(4.0, 1027.0))], "--unit UNIT", ("mg",), 50.0, ("mg",) * 3),
    "counts of gyros and accelerometers": Case(
        "t [s],gx [LSB],gy [LSB],ax (counts)", [TIME / 50, *counts(*triple(9.0)[:2], *triple(9.0, 4100.0)[2:])],
        "--channels 2,3 --scale SCALE", ("0.02deg/s",), 50.0, ("deg/s",) * 2),
    "increments in rad and g*s": Case(
        "t [s],imu:deltaThetaX,imu:deltaThetaY,imu:deltaThetaZ,imu:deltaVelX,imu:deltaVelY,imu:deltaVelZ",
        [TIME / 200, *triple(1e-6), *triple(1e-5, -1.01 / 200)],
        "--unit 'gyro=rad,accel=g*s' --kind increment", (), 200.0, ("rad",) * 3 + ("g*s",) * 3, "increment"),
    "increments in m/s": Case(
        "t [s],delta_angle_x,delta_velocity_x,delta_velocity_y,delta_velocity_z",
        [TIME / 200, triple(0.1)[0], *triple(1e-3, 9.9 / 200)],
        "--unit gyro=UNIT,accel=m/s --kind increment", ("arcsec",), 200.0, ("arcsec",) + ("m/s",) * 3, "increment"),
    "a unit that no sensor has": Case(
        "t [s],gx", [TIME / 50, triple(0.1)[0]], "--unit UNIT", ("deg/h",), 50.0, ("deg/h",), options="--unit s^3"),
}  # fmt: skip


def file_of(case, folder):
    path = folder / "log.csv"
    lines = [",".join(map(str, row)) for row in zip(*(column.tolist() for column in case.columns), strict=True)]
    path.write_text("\n".join([case.header] * bool(case.header) + lines) + "\n")
    return path


def filled(line, values):
    for value in values:
        line = re.sub(r"\b(UNIT|HZ|SCALE)\b", value, line, count=1)
    return line


@rows("case", CASES.values(), ids=list(CASES))
def test_a_line_to_copy_says_what_the_file_says(case, tmp_path):
    path = file_of(case, tmp_path)
    said = run("info", path, *shlex.split(case.options), code=2)
    line = re.search(r"try: allanite (.*)", said.stderr)[1]
    assert shlex.split(line) == ["info", str(path), *shlex.split(case.typed)]
    if case.fill:
        left = run(*shlex.split(line), code=2)
        assert re.search("put .* in the place of (UNIT|HZ|SCALE)$", left.stderr)
        assert "try:" not in left.stderr
    done = run(*shlex.split(filled(line, case.fill)), "--json", "-", code=0)
    channels = json.loads(done.stdout)["channels"]
    assert [channel["unit"] for channel in channels] == list(case.units)
    assert {channel["kind"] for channel in channels} == {case.kind}
    assert [channel["rate"] for channel in channels] == pytest.approx([case.rate] * len(channels))


def test_a_placeholder_is_refused_in_each_form(tmp_path):
    path = file_of(CASES["neither rate nor heading"], tmp_path)
    for words in (["--rate=HZ"], ["--unit=gyro=UNIT"], ["--unit", "COLUMN=deg/s"], ["--time", "1[UNIT]"]):
        said = run("info", path, *words).stderr
        assert any(meaning in said for meaning in MEANINGS.values()), said


def test_columns_of_many_quantities_are_not_all_of_one_unit(tmp_path):
    three = [triple(0.1), triple(0.02, 9.79), triple(0.1), triple(0.3, 40.0)]
    case = Case("", [column for three_axes in three for column in three_axes], "", (), 1.0, ())
    said = run("info", file_of(case, tmp_path)).stderr
    assert "--rate HZ --unit '4=m/s^2,5=m/s^2,6=m/s^2,COLUMN=UNIT'" in said
