"""Every verb that reads a recording says the same of a hostile one, and takes the same options."""

import json
import re
import shlex

import numpy as np
import pytest
from tests import ALL, commands
from tests.rows import rows
from tests.verbs import ROWS

N = 12_000
TIME = np.arange(N) / 20.0

READ = {verb: shlex.split(row.options) for verb, row in ROWS.items() if row.options is not None}
"""Verbs that read a recording, and what each needs besides. Those that read six channels have files of their own."""


def third(k):
    """Every third verb, begun with one of the first three, so that each check meets verbs of its own."""
    return list(READ)[0 if ALL else k :: 1 if ALL else 3]


IDENTIFY = set(READ) - {"info", "dynamic"}
REFUSE = set(READ) - {"info"}  # which shows why a record is refused


def run(verb, file, *options, code=0):
    """What a verb says on both streams, without the breaks of lines."""
    own = [part.format(regressor="temp") for part in READ[verb]]
    result = commands.run(verb, file, *own, *options, code=code)
    return " ".join((result.stdout + result.stderr).split())


def write(path, gyro, time=TIME):
    """A gyroscope beside a thermometer."""
    temp = 20 + 5 * np.sin(np.arange(N) / N * 9) + 0.01 * np.random.default_rng(5).standard_normal(N)
    data = np.column_stack([time, gyro, temp])
    np.savetxt(path, data, delimiter=",", fmt="%.9g", header="time [s],gz [deg/h],temp [degC]", comments="")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hostile")
    rng = np.random.default_rng(3)
    quiet = 10 * rng.standard_normal(N) + np.cumsum(0.1 * rng.standard_normal(N))
    moving, spikes = quiet.copy(), quiet.copy()
    moving[2000:6000] += 40_000 * np.sin(3 * TIME[:4000])
    spikes[rng.choice(N, 12, replace=False)] += 900
    for name, gyro in (("quiet", quiet), ("moving", moving), ("constant", np.full(N, 1.25)), ("spikes", spikes)):
        write(folder / f"{name}.csv", gyro)
    write(folder / "jitter.csv", quiet, TIME + rng.uniform(-0.01, 0.01, N))
    return folder


@rows("verb, what", [(verb, what) for what in ("moving", "constant") for verb in sorted(REFUSE)])
def test_a_recording_that_moves_and_a_constant_signal_are_refused(verb, what, folder, refusals):
    run(verb, folder / f"{what}.csv", code=3)
    assert refusals.pop().code == what


@pytest.mark.slow("every third verb")
@rows("verb", third(0))
def test_stamps_that_scatter_are_said_once(verb, folder):
    assert run(verb, folder / "jitter.csv").count("scatter by 0.11 intervals RMS") == 1


@pytest.mark.slow("takes more than half a second")
@rows("verb", third(0))
def test_outliers_are_said_and_the_option_is_taken(verb, folder):
    assert re.search(r"\d+ outliers beyond 5\.\d standard deviations", run(verb, folder / "spikes.csv"))
    gaps = ("--split-gaps",) if verb in ("rate", "compensate") else ()  # marked samples are missing
    run(verb, folder / "spikes.csv", "--outliers", "mark", *gaps)
    assert "'fill'" in run(verb, folder / "spikes.csv", "--outliers", "fill", code=2)


@pytest.mark.slow("takes more than half a second")
@rows("verb", third(1))
def test_pieces_are_left_out_and_said(verb, folder, tmp_path):
    gaps = ("--split-gaps",) if verb in ("rate", "compensate") else ()
    path = tmp_path / "made.json"
    run(verb, folder / "quiet.csv", "--exclude", "60..70,400..405", "--json", path, *gaps)
    assert json.loads(path.read_text("utf-8"))["recipe"]["exclude"] == [[60.0, 70.0], [400.0, 405.0]]
    refused = run(verb, folder / "quiet.csv", "--exclude", "70..60", code=2)
    assert "begins at 0 s or later and ends after that, unlike 70..60" in refused


@rows("verb", third(0))
def test_a_band_is_taken_by_every_verb_that_identifies(verb, folder):
    run(verb, folder / "quiet.csv", "--band", "0.01,5", code=0 if verb in IDENTIFY else 2)
