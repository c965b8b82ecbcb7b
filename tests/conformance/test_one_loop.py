"""Every verb that reads a recording says the same of a hostile one, and takes the same options."""

import json
import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner
from tests import ALL
from tests.rows import rows
from tests.verbs import ROWS

from allanite.cli import main

N = 12_000
RATE = 20.0

READ = {verb: shlex.split(row.options) for verb, row in ROWS.items() if row.options is not None}
"""Verbs that read a recording, and what each needs besides. Those that read six channels have files of their own."""


def third(k):
    """Every third verb, begun with one of the first three, so that each check meets verbs of its own."""
    return list(READ)[0 if ALL else k :: 1 if ALL else 3]


IDENTIFY = set(READ) - {"info", "dynamic"}
REFUSE = set(READ) - {"info"}  # which shows why a record is refused


def run(verb, file, *options, regressor="temp"):
    own = [part.format(regressor=regressor) for part in READ[verb]]
    return CliRunner().invoke(main, [verb, str(file), *own, *map(str, options)])


def words(result):
    """What was said on both streams, without the breaks of lines."""
    return " ".join((result.stdout + result.stderr).split())


def write(path, gyro, time=None):
    """A gyroscope beside a thermometer."""
    rng = np.random.default_rng(5)
    time = np.arange(len(gyro)) / RATE if time is None else time
    temp = 20 + 5 * np.sin(np.arange(len(gyro)) / len(gyro) * 9) + 0.01 * rng.standard_normal(len(gyro))
    data = np.column_stack([time, gyro, temp])
    np.savetxt(path, data, delimiter=",", fmt="%.9g", header="time [s],gz [deg/h],temp [degC]", comments="")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hostile")
    rng = np.random.default_rng(3)
    quiet = 10 * rng.standard_normal(N) + np.cumsum(0.1 * rng.standard_normal(N))
    write(folder / "quiet.csv", quiet)
    moving = quiet.copy()
    moving[2000:6000] += 40_000 * np.sin(np.arange(4000) / RATE * 3)
    write(folder / "moving.csv", moving)
    write(folder / "constant.csv", np.full(N, 1.25))
    spikes = quiet.copy()
    spikes[rng.choice(N, 12, replace=False)] += 900
    write(folder / "spikes.csv", spikes)
    stamps = np.arange(N) / RATE + rng.uniform(-0.2, 0.2, N) / RATE
    write(folder / "jitter.csv", quiet, stamps)
    np.column_stack([np.rint(quiet * 20), np.rint(quiet[::-1] * 20)]).astype("<i2").tofile(folder / "raw.bin")
    return folder


@rows("verb, what", [(verb, what) for what in ("moving", "constant") for verb in sorted(REFUSE)])
def test_a_recording_that_moves_and_a_constant_signal_are_refused(verb, what, folder, refusals):
    assert run(verb, folder / f"{what}.csv").exit_code == 3
    assert refusals.pop().code == what


@pytest.mark.slow("every third verb")
@rows("verb", third(0))
def test_stamps_that_scatter_are_said_once(verb, folder):
    result = run(verb, folder / "jitter.csv")
    assert result.exit_code == 0, words(result)
    assert words(result).count("scatter by 0.11 intervals RMS") == 1


@pytest.mark.slow("takes more than half a second")
@rows("verb", third(0))
def test_outliers_are_said_and_the_option_is_taken(verb, folder):
    result = run(verb, folder / "spikes.csv")
    assert result.exit_code == 0, words(result)
    assert re.search(r"\d+ outliers beyond 5\.\d standard deviations", words(result))
    gaps = ("--split-gaps",) if verb in ("rate", "compensate") else ()  # marked samples are missing
    result = run(verb, folder / "spikes.csv", "--outliers", "mark", *gaps)
    assert result.exit_code == 0, words(result)
    refused = run(verb, folder / "spikes.csv", "--outliers", "fill")
    assert refused.exit_code == 2
    assert "'fill'" in words(refused)


@pytest.mark.slow("takes more than half a second")
@rows("verb", third(1))
def test_pieces_are_left_out_and_said(verb, folder, tmp_path):
    gaps = ("--split-gaps",) if verb in ("rate", "compensate") else ()
    path = tmp_path / "made.json"
    result = run(verb, folder / "quiet.csv", "--exclude", "60..70,400..405", "--json", path, *gaps)
    assert result.exit_code == 0, words(result)
    assert json.loads(path.read_text("utf-8"))["recipe"]["exclude"] == [[60.0, 70.0], [400.0, 405.0]]
    refused = run(verb, folder / "quiet.csv", "--exclude", "70..60")
    assert refused.exit_code == 2
    assert "begins at 0 s or later and ends after that, unlike 70..60" in words(refused)


@rows("verb", third(0))
def test_a_band_is_taken_by_every_verb_that_identifies(verb, folder):
    result = run(verb, folder / "quiet.csv", "--band", "0.01,5")
    assert result.exit_code == (0 if verb in IDENTIFY else 2), words(result)
