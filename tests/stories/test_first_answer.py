"""The first answer on a file that is not as it should be: what is said once, in whose times, and what to type next."""

import json
import re
import shlex

import numpy as np
import pytest
from tests import ROOT, commands
from tests.rows import rows

pytestmark = pytest.mark.slow("analyses")

RATE = 20.0


def run(*arguments):
    done = commands.run(*arguments)
    assert done.exit_code in (0, 3), done.output
    return " ".join(done.output.split())


def write(path, columns, rate=RATE):
    rows = np.column_stack([np.arange(len(next(iter(columns.values())))) / rate, *columns.values()])
    np.savetxt(path, rows, "%.9g", ",", header=",".join(("time [s]", *columns)), comments="")
    return path


@pytest.mark.usefixtures("details")
def test_a_stretch_without_a_gap_is_offered_in_times_of_the_file(tmp_path):
    lines = (ROOT / "examples" / "tactical_gyro.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    head = [line for line in lines if line.startswith("#")] + [next(line for line in lines if line.startswith("time"))]
    rows = lines[len(head) :]
    file = tmp_path / "gap.csv"
    file.write_text("".join((*head, *rows[:19995], *rows[20095:])), encoding="utf-8")
    said = run("info", file, "--from", 1000, "--until", 3000)
    either = "--from 2009.5 --until 3000|--from 1000 --until 1999.5"
    offered = re.search(f"the longest stretch without a gap: ({either})", said)
    again = run("info", file, *shlex.split(offered[1]))
    assert ("are lost" in again, "fit for analysis" in again) == (False, True)


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    rng = np.random.default_rng(1)
    gyro = rng.standard_normal((3, 20_000))
    gyro[1, 6000:8000] += 80 * np.sin(np.arange(2000) / RATE)
    columns = {f"g{axis} [deg/s]": values for axis, values in zip("xyz", gyro, strict=True)}
    return write(tmp_path_factory.mktemp("data") / "shaken.csv", columns)


@pytest.mark.usefixtures("details")
def test_motion_of_one_axis_is_told_once_and_the_cure_works(shaken):
    said = run("analyze", shaken)
    assert said.count("the body moved: gy moves") == 1
    assert "gx, gz: the body moved: gy moves from 299.2 s" in said
    offered = re.search(r"the longest static stretch: ((--from \S+ )?--until \d+)", said)[1]
    again = run("analyze", shaken, *shlex.split(offered))
    assert "moves" not in again
    assert again.count("angle random walk") >= 3


def warm(follow, seed=3):
    """A gyroscope pair beside a thermometer that wanders: the first follows it, or has a random walk of its own."""
    rng = np.random.default_rng(seed)
    temp = 20 + np.cumsum(rng.standard_normal(20_000)) * 0.02
    other = np.cumsum(rng.standard_normal(20_000)) * 0.02
    gyro = rng.standard_normal((2, 20_000))
    gyro[0] += 2 * (temp if follow else other)
    return {"gx [deg/h]": gyro[0], "gy [deg/h]": gyro[1], "temp [degC]": np.round(temp, 3)}


@pytest.mark.usefixtures("details")
def test_a_temperature_that_explains_the_drift_is_named_with_the_line_to_type(tmp_path):
    file = write(tmp_path / "my day.csv", warm(True))
    said = run("analyze", file, "--from", 50)
    assert said.count("the drift of gx follows temp") == 1
    line = re.search(r"remove it: (allanite compensate .* --regressors temp) ", said)[1]
    words = shlex.split(line)[1:]
    assert words == ["compensate", str(file), "--from", "50", "--regressors", "temp"]
    again = run(*words)
    assert "gx depends on temp" in again
    assert "follows temp" in run("info", file)


PARTIAL = {
    "stuck": (slice(6000, 6400), lambda y: y[0]),
    "clipped": (slice(6000, 8000), lambda y: np.clip(3 * y, -4, 4)),
    "level": (slice(5000, 10_000), lambda y: 3 * y),
    "outliers": (slice(6000, 6050, 10), lambda y: y + 30),
    "moving": (slice(6000, 8000), lambda y: y + 80 * np.sin(np.arange(2000) / RATE)),
}
"""The finding of a fault, the samples that have it, and what becomes of them."""


@rows("name", PARTIAL)
def test_a_window_without_the_fault_is_free_of_it(name, tmp_path):
    y, (where, fault) = np.random.default_rng(4).standard_normal(20_000), PARTIAL[name]
    y[where] = fault(y[where])
    file, data = write(tmp_path / "day.csv", {"gx [deg/s]": y}), tmp_path / "day.json"

    def finding(*window):
        run("info", file, *window, "--json", data, "--force")
        quality = json.loads(data.read_text())["channels"][0]["quality"]
        return next((f for f in quality["findings"] if f["name"] == name), None)

    found = finding()
    assert re.search("--from.*--until", found["remedy"])
    start, end = found["place"]
    assert 240 < start < end < 510
    assert finding("--until", start) is None
    assert finding("--from", end) is None
    typed = re.search(r"(--from \S+ )?--until [\d.]+", found["remedy"])
    assert typed or name in ("clipped", "outliers")
    assert not typed or finding(*typed[0].split()) is None
