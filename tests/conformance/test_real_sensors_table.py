"""The tables of the first answer on real sensors hold what is claimed of them, and a part can be made again."""

from table import read

import math
from collections import Counter

import pytest
from tests.shares import chance, records

import real_sensors

SIMULATED, RECORDED = read("real_sensors.md"), read("recordings.md")
CELLS, CHANNELS = SIMULATED.rows(), RECORDED.rows()
EACH = records(SIMULATED)


def figures(cell):
    """(% covered, % off, rms) of each term that is there."""
    return {s: [float(x) for x in cell[s].split(" / ")[:2]] for s in "NBK" if "/" in cell[s]}


def test_every_sensor_and_fault_is_there():
    wanted = [(sensor, fault) for sensor in real_sensors.SENSORS for fault in real_sensors.FAULTS]
    assert [(cell["sensor"], cell["behind"]) for cell in CELLS] == wanted


def test_limits_hold_where_a_record_is_called_explained():
    least = 91 - chance(91, EACH)
    assert [cell for cell in CELLS if any(covered < least for covered, _ in figures(cell).values())] == []


def test_no_coefficient_is_off_where_a_record_is_called_explained():
    most = 2 + chance(2, EACH)
    assert [cell for cell in CELLS if any(off > most for _, off in figures(cell).values())] == []


def test_clean_records_are_read_whole():
    clean = [cell for cell in CELLS if cell["behind"] == "clean"]
    whole = 2 + chance(2, EACH)
    assert [c for c in clean if float(c["filter claimed, %"]) + float(c["band or mask, %"]) > whole] == []
    assert [c for c in clean if float(c["false term, %"]) > 5 + chance(5, EACH)] == []


def test_a_level_that_changes_is_never_called_explained():
    louder = [cell for cell in CELLS if "louder" in cell["behind"]]
    assert len(louder) == len(real_sensors.SENSORS)
    assert [cell for cell in louder if float(cell["explained, %"]) > 2 + chance(2, EACH)] == []


def test_four_of_five_channels_at_rest_are_explained_or_approximate():
    """The others are of a swaying vehicle and of a record of five distinct values: of all, three of four are."""
    others = [c for c in CHANNELS if c["grade"] not in ("explained", "approximate")]
    assert Counter(c["file"] for c in others) == {"psins_lasergyro.imu": 6, "aegiverse_fog_0917.txt": 1}
    assert {c["grade"] for c in others} == {"unexplained"}


def test_gyroscopes_of_both_units_have_n_right_and_no_flicker_lies_above_its_curve():
    """All are explained, but for the slowest drift of two axes of the second unit, which the answer names."""
    for channel in CHANNELS:
        if channel["file"].startswith("adis") and channel["channel"].startswith("Gyro"):
            assert channel["grade"] == "explained" or "the slower drift is not described" in channel["read"]
            assert abs(float(channel["N over deviation at 1 s"]) - 1) < 0.03
        floor = float(channel["0.664 B over least upper limit"])
        assert math.isnan(floor) or floor <= 1


@pytest.mark.slow("takes more than half a second")
def test_a_part_is_made_again():
    answers = [real_sensors.simulated(("MEMS", "2nd-order filter, fs/6", 2**15, i)) for i in range(4)]
    assert all(a.filtered for a in answers)
    assert sum(a.terms["N"][1] for a in answers) >= 3
