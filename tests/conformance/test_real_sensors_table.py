"""The tables of the first answer on real sensors hold what is claimed of them, and a part can be made again."""

from table import read

import math
import re

import pytest

import real_sensors

SIMULATED, RECORDED = read("real_sensors.md"), read("recordings.md")
CELLS, CHANNELS = SIMULATED.rows(), RECORDED.rows()
RECORDS = int(re.search(r"--records (\d+)", SIMULATED.head)[1])


def beyond_chance(share, sign):
    """A share, %, that this many records show with a true one of `share` in all but 1 of 200 cases."""
    return share + sign * 260 * math.sqrt(share / 100 * (1 - share / 100) / RECORDS)


def figures(cell):
    """(% covered, % off, rms) of each term that is there."""
    return {s: [float(x) for x in cell[s].split(" / ")[:2]] for s in "NBK" if "/" in cell[s]}


def cells(found):
    """Cells with their names."""
    return [pytest.param(cell, id=f"{cell['sensor']}-{cell['behind']}") for cell in found]


def test_they_say_how_they_were_made():
    for page in (SIMULATED, RECORDED):
        assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d", page.head)
    wanted = [(sensor, fault) for sensor in real_sensors.SENSORS for fault in real_sensors.FAULTS]
    assert [(cell["sensor"], cell["behind"]) for cell in CELLS] == wanted


@pytest.mark.parametrize("cell", cells(CELLS))
def test_limits_hold_where_a_record_is_called_explained(cell):
    for covered, _ in figures(cell).values():
        assert covered >= beyond_chance(91, -1)


@pytest.mark.parametrize("cell", cells(CELLS))
@pytest.mark.parametrize("symbol", "NBK")
def test_no_coefficient_is_off_where_a_record_is_called_explained(cell, symbol):
    if symbol in figures(cell):
        assert figures(cell)[symbol][1] <= beyond_chance(2, 1)


@pytest.mark.parametrize("cell", [c for c in CELLS if c["behind"] == "clean"], ids=lambda c: c["sensor"])
def test_clean_records_are_read_whole(cell):
    assert float(cell["filter claimed, %"]) + float(cell["band or mask, %"]) <= beyond_chance(2, 1)
    assert float(cell["false term, %"]) <= beyond_chance(5, 1)


@pytest.mark.parametrize("cell", [c for c in CELLS if "louder" in c["behind"]], ids=lambda c: c["sensor"])
def test_a_level_that_changes_is_never_called_explained(cell):
    assert float(cell["explained, %"]) <= beyond_chance(2, 1)


def test_four_of_five_channels_at_rest_are_explained_or_approximate():
    """Those of a swaying vehicle and of a record of five distinct values are to be refused."""
    at_rest = [c for c in CHANNELS if not c["file"].startswith(("psins", "aegiverse"))]
    good = [c for c in at_rest if c["grade"] in ("explained", "approximate")]
    assert len(good) >= 0.8 * len(at_rest)
    for channel in CHANNELS:
        if channel["file"].startswith("psins"):
            assert channel["grade"] == "unexplained"


@pytest.mark.xfail(reason="75 %: six channels of a swaying vehicle and one of five distinct values are refused")
def test_four_of_five_of_all_channels_are_explained_or_approximate():
    good = [c for c in CHANNELS if c["grade"] in ("explained", "approximate")]
    assert len(good) >= 0.8 * len(CHANNELS)


def test_gyroscopes_of_both_units_are_explained_and_no_flicker_lies_above_its_curve():
    for channel in CHANNELS:
        if channel["file"].startswith("adis") and channel["channel"].startswith("Gyro"):
            assert channel["grade"] == "explained"
            assert abs(float(channel["N over deviation at 1 s"]) - 1) < 0.03
        floor = float(channel["0.664 B over least upper limit"])
        assert math.isnan(floor) or floor <= 1


def test_a_part_is_made_again():
    answers = [real_sensors.simulated(("MEMS", "2nd-order filter, fs/6", 2**15, i)) for i in range(4)]
    assert all(a.filtered for a in answers)
    assert sum(a.terms["N"][1] for a in answers) >= 3
