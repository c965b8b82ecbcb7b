"""Units by sensor and by column, and warnings where the file says otherwise."""

import json

import numpy as np
import pytest
from tests.commands import run
from tests.rows import refused, rows

import allanite as al
from allanite.readers import read

NOISE = np.random.default_rng(1).standard_normal((400, 3)).round(4)


@pytest.fixture
def timed(table):
    """Write three columns and their time below a header."""
    return lambda header: table(header, np.arange(400) / 100, *NOISE.T)


def units(recording):
    return {record.name: record.unit for record in recording}


@rows("unit", [
    "gyro=deg/s,accel=g", " gyroscope = deg/s , accelerometer = g ", {"gyro": "deg/s", "accel": "g"},
    {"wx": "deg/s", "wy": "deg/s", "ax": "g"}, {"2": "deg/s", "3": "deg/s", "acc": "g"}, {"gyro": "°/с", "ax": "g"},
])  # fmt: skip
def test_units_by_sensor_and_by_column(timed, unit):
    assert units(read(timed("time [s],wx,wy,ax"), unit=unit)) in (
        {"wx": "deg/s", "wy": "deg/s", "ax": "g"},
        {"wx": "°/s", "wy": "°/s", "ax": "g"},
    )


def test_a_column_by_name_wins_over_its_sensor_and_over_its_name(timed):
    path = timed("time [s],wx,temp,ax")
    assert units(read(path, unit={"gyro": "deg/s", "temp": "deg/h"})) == {"wx": "deg/s", "temp": "deg/h"}
    assert units(read(path, unit="wx=deg/h,gyro=deg/s")) == {"wx": "deg/h"}


@rows("unit", ["gyro=deg/h,temp=degC", "wx=deg/h,3=degC"])
def test_columns_beside_the_signals_have_the_unit_that_is_given_for_them(timed, unit):
    assert units(read(timed("time [s],wx,temp"), along=["temp"], unit=unit)) == {"wx": "deg/h", "temp": "degC"}


def test_other_columns_keep_their_header_or_are_left_out(timed):
    recording = read(timed("time [s],wx,ax [mg],foo"), unit="gyro=deg/s")
    assert units(recording) == {"wx": "deg/s", "ax": "mg"}
    assert any("unit is unknown" in note and "'foo'" in note for note in recording.notes)
    assert not recording.findings


@rows("unit, words", [
    ("gyro=deg/s,accel=g", ["unit g", "accelerometer", "no column", "wx (gyro)", "omit it"]),
    ("gyro=deg/s,wz=deg/s", ["'wz'", "2: wx"]), ("gyro=g", ["'g'", "not a unit of a gyro"]),
    ("gyro=furlong", ["unknown unit 'furlong'"]), ("gyro=deg/s,gyros=deg/h", ["gyro", "two units"]),
    ("gyro=", ["'gyro='", "gyro=deg/s,accel=g"]), ("gyro=deg/s,g", ["each sensor or column", "gyro=deg/s,accel=g"]),
    ({}, ["no unit is given"]), ({"gyro": 5}, ["unit must be a string, a mapping of strings", "5"]),
    ({"a,b": "g"}, ["'a,b'", "number"]),
])  # fmt: skip
def test_what_the_file_has_not_is_refused_by_name(timed, unit, words):
    with pytest.raises(al.UsageError) as caught:
        read(timed("time [s],wx,wy,T [degC]"), unit=unit)
    assert [word for word in words if word not in str(caught.value)] == []


def test_one_scale_for_several_units_is_refused(timed):
    path = timed("time [s],wx,wy,ax")
    refused(al.UsageError, "one scale", lambda: read(path, unit="gyro=arcsec,accel=m/s", kind="count", scale=0.1))
    refused(al.UsageError, "give the scale as a number", lambda: read(path, unit="gyro=deg/s", scale="0.1deg/h"))


@pytest.mark.slow("takes more than half a second")
def test_recipe_command_line_and_python_agree(timed, tmp_path):
    path = str(timed("time [s],wx,wy,ax"))
    (tmp_path / "text.toml").write_text('unit = "gyro=deg/s,accel=g"\n')
    (tmp_path / "table.toml").write_text('[unit]\ngyro = "deg/s"\naccel = "g"\n')
    ways = (["--unit", "gyro=deg/s,accel=g"], *(["--recipe", tmp_path / f"{n}.toml"] for n in ("text", "table")))
    for way in ways:
        said = json.loads(run("analyze", path, "--method", "slopes", "--json", "-", *way, code=0).stdout)
        assert [channel["unit"] for channel in said["channels"]] == ["deg/s", "deg/s", "g"]
        assert said["recipe"]["unit"] == "gyro=deg/s,accel=g"
    recipe = al.Recipe(unit={"gyro": "deg/s", "accel": "g"})
    assert recipe == al.Recipe.load(tmp_path / "table.toml") == al.Recipe.load(tmp_path / "text.toml")
    assert al.Recipe.from_dict(recipe.to_dict()) == recipe


def test_a_unit_against_the_header_is_a_warning_that_names_both(timed):
    recording = read(timed("time [s],wx [rad/s],wy [deg/s],ax [g]"), unit="deg/s")
    assert units(recording) == {"wx": "deg/s", "wy": "deg/s", "ax": "g"}
    (warning,) = recording.findings
    assert (warning.name, warning.fatal) == ("given unit", False)
    for word in ("deg/s", "rad/s", "'wx [rad/s]'", "0.0174533", "omit unit='deg/s'"):
        assert word in str(warning)
    other = read(timed("time [s],wx [rad/s],wy,ax [g]"), unit={"wx": "g"}).findings
    assert (other[0].name, "another quantity" in str(other[0])) == ("given unit", True)
    assert not read(timed("time [s],wx [deg/s],wy,ax [g]"), unit="dps").findings


@rows("rate, noted", [(15.041, True), (12.0, False)])
def test_the_rate_of_the_earth_is_noted_with_the_latitude(tmp_path, rate, noted):
    up, north = np.array([0.48, -0.36, 0.8]), np.array([0.6, 0.8, 0.0])
    turn = rate * (np.sin(np.radians(50)) * up + np.cos(np.radians(50)) * north)
    rng = np.random.default_rng(1)
    y = np.hstack((turn + 3 * rng.standard_normal((4000, 3)), up + 1e-3 * rng.standard_normal((4000, 3))))
    header = ",".join([f"g{a} [deg/h]" for a in "xyz"] + [f"a{a} [g]" for a in "xyz"])
    np.savetxt(tmp_path / "six.csv", y, "%.6f", ",", header=header, comments="")
    notes = read(tmp_path / "six.csv", rate=100.0).notes
    assert any("a latitude of 50 deg" in note for note in notes) == noted
