"""What users of other programs complained of: the one command that answers each, in the words of the complaint."""

import importlib.util
import re
import shlex
import shutil

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rows import rows

import allanite as al
from allanite.cli import main

INTERVAL = 0.01


class Answer:
    """The command in the folder of `files`, what it must say, and how it ends."""

    def __init__(self, command, *said, code=0):
        self.command, self.said, self.code = command, said, code


TRUTH = "N 0.3 deg/sqrt(h), K 60 deg/h/sqrt(h)"
COMPLAINTS = {
    "plotted values in deg/s do not match the exported ones in rad/s":
        Answer("analyze gyro.csv --channels gx --to rad/s/sqrt(Hz)", r"8\.66e-5 .* rad/s/√Hz .* 0\.2977 .* °/√h"),
    "simulated noise is found 28 % too small, and results of tools differ: which is right?":
        Answer("selfcheck --model 'N 0.15 deg/sqrt(h)' --rate 10 --duration 10min --records 4 --max-bias 10",
               r"N 0\.15 °/√h .* \+- ", "coverage: share of the printed intervals that contain the truth"),
    "the tangent of slope -1/2 is no tangent; what do the marks mean, is the sensor good, who tells of long records?":
        Answer("analyze gyro.csv --channels gx", "angle random walk .* identified",
               r"explained \(goodness of fit p = .* 95 % interval",
               r"what it means: gx .* dominates up to .* The drift is random",
               r"[Gg]rade by its in-run bias stability .* grades are conventions"),
    "a bag must be converted with MATLAB first":
        Answer("info run.bag", r"rate 100\.0 Hz from column 'header\.stamp'"),
    "the bag must be played in real time, and the program waits for data":
        Answer("info run.bag --quiet", "^$"),
    "the documentation does not say whether the variance is overlapped":
        Answer("deviation gyro.csv --channels gx", "overlapping Allan deviation"),
    "a record of three seconds gives NaN":
        Answer("analyze short.csv", "the record is only 3 s long; .* record for longer"),
    "the sensor was shaken for the calibration of its noise":
        Answer("analyze shaken.csv", r"moves from 10 s .* the longest static stretch: --until 10", code=3),
    "no messages were found: is the topic right?":
        Answer("info run.bag --channels /imu/wrong",
               r"it contains .*/imu/data of type sensor_msgs/Imu \(1500 rows", code=2),
    "only mcap is read, or only db3: the other one":
        Answer("info run_db3", r"/imu/data of type sensor_msgs/Imu \(1500 rows at 100 Hz\)"),
    "only db3 is read, or only mcap: the other one":
        Answer("info run_mcap", r"/imu/data of type sensor_msgs/Imu \(1500 rows at 100 Hz\)"),
    "messages out of order are skipped, and something is divided by zero":
        Answer("info order.csv", "2 time stamps .* the rows were out of order and have been sorted by time"),
    "time stamps repeat or jitter with the latency of the driver":
        Answer("info jitter.csv", r"time stamps .* scatter by 0\.2\d intervals RMS"),
    "records with gaps have no good solution":
        Answer("analyze gaps.csv", "401 of 4000 samples are missing .* gaps are not filled"),
    "results have no names, limits and units":
        Answer("analyze gyro.csv --channels gx --json - --quiet", r'"symbol": "N".*"unit": '),
    "for a given bias instability, what is the normalization of the noise?":
        Answer("simulate flicker.csv --model 'B 10 deg/h' --rate 10 --duration 100 --force",
               "B bias instability 10 °/h"),
    "rate and angle as input give different curves":
        Answer("info gyro.csv --unit deg", "'deg' does not determine what a sample is", code=2),
    "axes have averaging times of different number":
        Answer("deviation gyro.csv --csv - --quiet", "channel,statistic,m,tau_s"),
    "the simulator has no rate random walk":
        Answer(f"simulate walk.csv --model '{TRUTH}' --rate 20 --duration 100 --force",
               r"K rate random walk 60 °/h/√h"),
    "how long is a record to be?":
        Answer(f"plan --model '{TRUTH}' --rate 100 --accuracy 10", r"K 60 °/h/√h .* 1\.75 h"),
    "is a temperature effect to be removed first?":
        Answer("compensate warm.csv --channels gx --regressors temp", r"temp .* p"),
    "one of many units is missing in the results":
        Answer("analyze units", r"not analyzed: units/c\.csv", code=5),
}  # fmt: skip


def csv(path, stamps, values, names="gx [deg/s],gy [deg/s],gz [deg/s]"):
    rows = (",".join(f"{x:.6f}" for x in row) for row in np.column_stack([stamps, values]))
    path.write_text("\n".join((f"time [s],{names}", *rows, "")))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Recordings with the faults that are complained of."""
    bag_files = pytest.importorskip("bag_files") if importlib.util.find_spec("rosbags") else None
    folder, rng = tmp_path_factory.mktemp("complaints"), np.random.default_rng(7)
    gyros = [al.simulate(al.Model(TRUTH), 20_000, 20.0, rng=rng, unit="deg/h", name=n) for n in ("gx", "gy", "gz")]
    al.write(al.Recording(tuple(gyros)), folder / "gyro.csv")
    times, values = INTERVAL * np.arange(4000), 0.01 * rng.normal(size=(4000, 3))
    csv(folder / "short.csv", times[:300], values[:300])
    shaken = values.copy()
    shaken[1000:3000] += 40 * np.sin(8 * times[1000:3000])[:, np.newaxis]
    csv(folder / "shaken.csv", times, shaken)
    order = np.arange(4000)
    order[[500, 501, 900, 901]] = 501, 500, 901, 900
    csv(folder / "order.csv", times[order], values[order])
    late = rng.uniform(0, 0.008, 4000) * (rng.random(4000) < 0.3)
    csv(folder / "jitter.csv", np.sort(times + late), values)
    there = (times < 10) | (times > 14)
    csv(folder / "gaps.csv", times[there], values[there])
    warmth = 20 + 5 * np.sin(0.2 * times)
    warm = np.column_stack([values[:, 0] + 0.01 * warmth, warmth])
    csv(folder / "warm.csv", times, warm, "gx [deg/s],temp [degC]")
    (folder / "units").mkdir()
    for name in ("a", "b"):
        shutil.copy(folder / "order.csv", folder / "units" / f"{name}.csv")
    (folder / "units" / "c.csv").write_text("gx")
    if bag_files:
        data = 1e-3 * rng.normal(size=(1500, 6))
        for form in bag_files.FORMS:
            bag_files.write(folder, form, [bag_files.imu_topic(form, data)])
    return folder


@pytest.mark.nightly("sentences about many kinds of records")
@rows("complaint", COMPLAINTS)
@pytest.mark.usefixtures("details")
def test_one_command_answers_a_complaint(complaint, files, monkeypatch):
    answer = COMPLAINTS[complaint]
    if " run" in answer.command:
        pytest.importorskip("rosbags")
    monkeypatch.chdir(files)
    result = CliRunner().invoke(main, shlex.split(answer.command))
    said = " ".join((result.stdout + " " + result.stderr).split())
    assert result.exit_code == answer.code, said
    assert [words for words in answer.said if not re.search(words, said)] == [], said
    assert "--json" in answer.command or not re.search(r"\b(nan|NaN|inf)\b", said), said  # no limit is "inf" in JSON


def test_averaging_times_are_those_of_all_axes(files):
    curves = [al.deviation(record) for record in al.read(files / "gyro.csv")]
    assert len({tuple(curve.tau) for curve in curves}) == 1
