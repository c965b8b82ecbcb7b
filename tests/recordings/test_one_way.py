"""One way for samples, on real recordings: whole, in parts and watched."""

from contextlib import nullcontext

import pytest
from tests.conformance.test_one_pipeline import compare
from tests.rows import rows

TEXTS = {
    "aegiverse_fog_0917.txt": {"unit": "deg/h"},
    "aegiverse_fpga_gyro_0802.txt": {"unit": "deg/s", "channels": ("2",)},
    "ig500n_milkytipo.txt": {"rate": 100.0, "unit": "deg/s", "channels": ("1", "2", "3")},
    "phone_acc2.txt": {"unit": "m/s^2"},
    "phone_gyro4.txt": {"unit": "rad/s"},
}


SHORT = {
    "phone_gyro4.txt": "a sinusoid at 1.68 Hz is not removed in parts: N is 0.9 % beyond the limits of the whole",
    "phone_acc2.txt": "the residuals, which are not white, are not tested in parts: N is claimed",
    "aegiverse_fog_0917.txt": "the residuals, which are not white, are not tested in parts: N is claimed",
}
"""Where reading in parts falls short of the whole, and why."""


@pytest.mark.nightly("real recordings three times")
@rows("name", TEXTS)
def test_a_recording_is_the_same_in_all_ways(recordings, name):
    outcome = pytest.raises(AssertionError) if name in SHORT else nullcontext()
    with outcome:
        compare(recordings / name, TEXTS[name] | {"outliers": "mark"})
