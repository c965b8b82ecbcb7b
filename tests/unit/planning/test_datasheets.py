"""Data sheets: each line has its place, each conversion is that of a formula in plain numbers, names are forgiving."""

import csv
import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from tests import ROOT
from tests.rows import refused, rows

import allanite as al
from allanite.exporting.imported import models_of
from allanite.planning.datasheets import QUANTITIES, SENSOR_TYPES, Claim, DataSheet, claimed
from allanite.testing import check_data_sheet

DEG, G, H = math.pi / 180, 9.80665, 3600.0
SI = {
    "deg/sqrt(h)": DEG / 60, "deg/s/sqrt(Hz)": DEG, "mdeg/s/sqrt(Hz)": 1e-3 * DEG, "deg/s": DEG, "deg/h": DEG / H,
    "m/s/sqrt(h)": 1 / 60, "ug/sqrt(Hz)": 1e-6 * G, "mg/sqrt(Hz)": 1e-3 * G, "m/s^2/sqrt(Hz)": 1.0, "m/s^2": 1.0,
    "mg": 1e-3 * G, "ug": 1e-6 * G,
}  # fmt: skip
"""Sizes of the units that are printed."""

FORMULAS = {
    "random walk": lambda value, _: ("N", value),
    "noise density": lambda value, _: ("N", value / 2**0.5),
    "rms noise": lambda value, bandwidth: ("N", value / (2 * bandwidth) ** 0.5),
    "bias stability": lambda value, _: ("B", value / (2 * math.log(2) / math.pi) ** 0.5),
    "bias instability": lambda value, _: ("B", value),
}

CLAIMS = [(sheet, claim) for sheet in al.planning.DATASHEETS.values() for claim in sheet.claims]


@rows("name", al.planning.DATASHEETS)
def test_a_sheet_of_the_table_keeps_what_every_sheet_must(name):
    check_data_sheet(al.planning.DATASHEETS[name])


def test_every_line_of_the_table_is_a_claim():
    _, *lines = csv.reader((ROOT / "src/allanite/planning/datasheets.csv").read_text("utf-8").splitlines())
    assert (len(lines), [line[0] for line in lines]) == (len(CLAIMS), sorted(line[0] for line in lines))


def test_every_conversion_of_the_table_is_that_of_its_formula():
    assert FORMULAS.keys() == QUANTITIES.keys() == {claim.quantity for _, claim in CLAIMS}
    assert {claim.unit for _, claim in CLAIMS} == SI.keys()
    for sheet, claim in CLAIMS:
        if claim.quantity == "rms noise" and claim.bandwidth is None:
            assert claim.term is None
            continue
        symbol, value = FORMULAS[claim.quantity](claim.value * SI[claim.unit], claim.bandwidth)
        assert claim.term.symbol == symbol
        assert claim.term.value == pytest.approx(value, rel=1e-12), (sheet.name, claim)


APART = {
    ("ADIS16355", "gyro", "noise density"): 0.51,  # 4.2 is 0.05 * 60 * sqrt(2): the root on the wrong side
    ("ADIS16355", "accelerometer", "noise density"): 0.385,
    ("IMX-5", "gyro", "noise density"): 1.33,
    ("IMX-6", "gyro", "noise density"): 1.61,
    ("IMX-6", "accelerometer", "noise density"): 1.47,
    ("MPU-9250", "accelerometer", "rms noise"): 2.75,
    ("MPU-9255", "accelerometer", "rms noise"): 2.75,
}
"""Where a sheet contradicts itself: N that follows from one line over that from another."""


def largest(sheet, sensor):
    """The largest N that typical lines give, by quantity."""
    found = {}
    for claim in sheet.claims:
        if claim.sensor == sensor and claim.limit != "maximum" and claim.term and claim.term.symbol == "N":
            found[claim.quantity] = max(found.get(claim.quantity, 0.0), claim.term.value)
    return found


def test_lines_of_a_sheet_agree_on_N_except_where_the_sheet_contradicts_itself():
    """That densities are one-sided, and rms noise their root mean square, is what the sheets themselves show."""
    ratios = {}
    for sheet, sensor in product(al.planning.DATASHEETS.values(), SENSOR_TYPES):
        if (sheet.model(sensor) is None) or len(found := largest(sheet, sensor)) < 2:
            continue
        first = next(value for quantity in QUANTITIES if (value := found.get(quantity)))
        ratios |= {(sheet.name, sensor, quantity): value / first for quantity, value in found.items()}
    densities = [value for (_, _, quantity), value in ratios.items() if quantity == "noise density" and value != 1]
    assert len(ratios) > 60
    assert np.median(densities) == pytest.approx(1.0, abs=0.1)
    for key, value in ratios.items():
        assert value == pytest.approx(APART[key], rel=0.01) if key in APART else 0.79 < value < 1.28, (key, value)


WALK = Claim("gyro", "random walk", "ARW", 0.3, "deg/sqrt(h)", place="page 1")
DENSITY = Claim("gyro", "noise density", "Density", 0.01, "deg/s/sqrt(Hz)", place="page 1")
NOISE = Claim("gyro", "rms noise", "Noise", 0.1, "deg/s", place="page 1", bandwidth=50.0)


@rows("claims, used", [
    ((NOISE, DENSITY, WALK), WALK), ((NOISE, DENSITY), DENSITY), ((NOISE,), NOISE),
    ((WALK, replace(WALK, value=0.4)), replace(WALK, value=0.4)),
    ((replace(WALK, limit="maximum"), DENSITY), DENSITY),
    ((replace(WALK, limit="maximum"),), replace(WALK, limit="maximum")),
])  # fmt: skip
def test_one_line_makes_the_coefficient(claims, used):
    sheet = DataSheet("X1", "Maker", "document 1", claims)
    assert (sheet.used("gyro"), sheet.gyro, sheet.accelerometer) == ((used,), al.Model((used.term,)), None)
    assert sheet.models == (sheet.gyro,)
    assert replace(sheet, claims=(replace(NOISE, bandwidth=None),)).models == ()


@rows("name", ["ADIS16470", "adis16470", "ADIS-16470", "adis 16470", "Adis_16470"])
def test_a_name_is_found_as_it_is_typed(name):
    assert al.planning.data_sheet_named(name).name == "ADIS16470"


@rows("text, words", [
    ("adis1647", r"^unknown data sheet 'adis1647'; did you mean ADIS16470\?"),
    ("xyz", "^unknown data sheet 'xyz'; known data sheets: ADIS16355, "),
    ("itg-3200 accelerometer", "^the data sheet of the ITG-3200 says nothing of the noise of its accelerometer"),
])  # fmt: skip
def test_what_is_not_there_is_refused(text, words):
    refused(al.UsageError, words, lambda: claimed(text))


def test_texts_of_a_conversion_may_be_names_of_data_sheets():
    sheet, given = al.planning.DATASHEETS["ADIS16470"], al.Model("N 0.5 deg/sqrt(h)")
    assert models_of(["adis16470"]) == list(sheet.models)
    assert models_of(["adis16470 accelerometer", "0.5 deg/sqrt(h)"]) == [sheet.accelerometer, given]


@rows("sensor", SENSOR_TYPES)
def test_what_was_measured_is_given_as_the_sheet_would_say_it(sensor):
    """A record of exactly the random walk of a sheet: its density is what the sheet should have printed."""
    sheet = al.planning.data_sheet_named("adis16470")
    record = al.simulate(al.Model((sheet.model(sensor)["N"],)), 60_000, 100.0, rng=2, name="x")
    found = al.comparison.compare_with_sheet(record, sheet)
    ratios = {m.claim.quantity: m.ratio for m in found.measured(found[0])}
    sizes = largest(sheet, sensor)
    assert ratios.keys() == {"random walk", "noise density", "bias stability"}
    for quantity, truth in (("random walk", 1.0), ("noise density", sizes["random walk"] / sizes["noise density"])):
        value, low, high = ratios[quantity]
        assert low < truth < high
        assert value == pytest.approx(truth, rel=0.02)
    least = found[0].readings.minimum.deviation / SI["deg/h" if sensor == "gyro" else "ug"]
    assert ratios["bias stability"][0] == pytest.approx(least / (8 if sensor == "gyro" else 13))
    assert [row[:2] for row in found.rows()[1]] == [["x", quantity] for quantity in ratios]


def test_a_channel_of_a_sensor_that_the_sheet_has_not_is_left_alone():
    record = al.simulate(al.N(60, "ug/sqrt(Hz)"), 8192, 100.0, rng=2, name="ax")
    found = al.comparison.compare_with_sheet(record, "itg-3200")
    assert list(found.measured(found[0])) == []
