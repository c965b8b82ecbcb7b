"""The first screen on real recordings: its size, and what must not be hidden."""

import re
import shlex

import pytest
from tests import thinned
from tests.commands import run
from tests.rows import rows

SCREENS = {
    "analyze adis_16405_imu1.rda --unit gyro=deg/s,accel=g": (
        r"Gyro\. X +2\.4\d+ ± ", r"\+20\d0 µg at 22\d\d s\. Try --from", r"not valid", r"in part"
    ),
    "analyze phone_gyro4.txt --unit rad/s": (
        r"N +angle random walk +°/√h +1\.6\d+ ±", r"column 4: the noise level changes by a factor of 1\.23",
    ),
    "analyze aegiverse_fog_0917.txt --unit deg/h": (
        r"in-run bias stability", r"fog DOES NOT FIT: quantization errors", r"fog: the output is stuck .* Try --until"
    ),
    "analyze vn100_car_idle.bag": (
        r"model fits \d of 6 channels",
    ),
    "info psins_lasergyro.imu": (r"mean +°/h +-12\.27", r"the body moved: .* Try --from 1011 --until 1847"),
    "info format_only_vn100_moving.mcap": (r"0 of 6 channels are fit for analysis", r"gz NO RESULT: moves from 0 s"),
    "info cubeorange_sample_log_small.ulg": (r"3 × gyroscope, 3 × accelerometer", r"missing in 1 gap"),
}  # fmt: skip
"""Commands; what the first five lines have, and what else is there."""


@pytest.mark.slow("takes more than half a second")
@pytest.mark.usefixtures("analyzed_once")
@rows("line", thinned(SCREENS, 4))
def test_the_first_screen_of_a_recording(recordings, line):
    verb, file, *rest = shlex.split(line)
    done = run(verb, recordings / file, *rest)
    lines = done.stdout.splitlines()
    assert len(lines) <= 20
    assert max(map(len, lines)) <= 100
    first, *others = SCREENS[line]
    assert re.search(first, "\n".join(lines[:5]))
    for other in others:
        assert re.search(other, done.stdout)
