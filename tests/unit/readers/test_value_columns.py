"""Columns whose samples are the quantity itself."""

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al


@pytest.fixture(scope="module")
def angles(tmp_path_factory):
    path = tmp_path_factory.mktemp("angles") / "run.csv"
    rng = np.random.default_rng(1)
    rows = np.column_stack([np.arange(3000) / 10, rng.integers(-90, 90, (3000, 2)), 20 + rng.standard_normal(3000)])
    np.savetxt(path, rows, "%.9g", ",", header="t [s],az [arcmin],tilt [arcmin],temp [degC]", comments="")
    return path


NOISE = np.random.default_rng(1).standard_normal(500)


def test_pulses_are_offered_for_integers_only(table):
    with pytest.raises(al.UsageError) as caught:
        al.read(table("a [arcsec]", NOISE), rate=10.0)
    assert "count" not in str(caught.value)


def test_values_are_all_columns_with_a_unit(angles):
    recording = al.read(angles, kind="value")
    assert [(r.name, r.signal.name, r.unit) for r in recording] == [
        ("az", "angle", "arcmin"), ("tilt", "angle", "arcmin"), ("temp", "temperature", "degC")
    ]  # fmt: skip
    assert {r.kind for r in recording} == {"value"}
    # a unit selects its columns
    recording = al.read(angles, kind="value", unit="deg")
    assert recording.channels == ("az", "tilt")
    assert any("its unit 'degC' does not match deg" in note for note in recording.notes)
    assert any("according to the file it is arcmin" in str(finding) for finding in recording.findings)


def test_columns_without_a_unit_are_asked_for(table):
    path = table("a,seq", NOISE, NOISE**2)
    refused(al.UsageError, "unit is unknown", lambda: al.read(path, kind="value", rate=10.0))
    recording = al.read(path, kind="value", rate=10.0, unit="mV")
    assert [(r.name, r.signal.name) for r in recording] == [("a", "voltage")]
    # an unknown quantity is refused by its unit
    words = "'V/s' is not a unit of a quantity that can be analyzed"
    refused(al.UsageError, words, lambda: al.read(table("a [V/s]", NOISE), kind="value", rate=10.0, channels=["a"]))


@rows("suffix", [".csv", ".npz", ".parquet"])
def test_a_value_is_read_as_it_was_written(tmp_path, suffix):
    record = al.Record(NOISE, 10.0, "arcsec", "value", name="az")
    al.write(record, tmp_path / f"a{suffix}")
    again = al.read(tmp_path / f"a{suffix}")["az"]
    assert (again.kind, again.unit, again.signal.name) == ("value", "arcsec", "angle")
    assert np.array_equal(again.values, record.values)


def test_an_angle_may_explain_a_gyro(table):
    path = table("gx [deg/s],table [deg]", NOISE, NOISE**2)
    angle = al.read(path, rate=10.0, channels=["gx"], along=["table"])["table"]
    assert (angle.kind, angle.unit) == ("value", "deg")
