"""A recording of the ADIS16405 beside its data sheet is as the committed table has it."""

from table import read

import pytest

import allanite as al
import data_sheets


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("name", data_sheets.FILES[:1])
def test_a_channel_is_as_in_the_table(recordings, name):
    channel = "Gyro. X"
    rows = [row for row in read("data_sheets.md").rows() if (row["file"], row["channel"]) == (name, channel)]
    found = al.compare_with_sheet(recordings / name, "adis16405", unit=data_sheets.UNIT, channels=(channel,))
    measured = {m.claim.printed: m.ratio[0] for m in found.measured(found[channel])}
    assert {row["quantity"]: pytest.approx(float(row["ratio"]), rel=0.01) for row in rows} == measured
