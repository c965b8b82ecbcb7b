"""The check of a recording at the command line, in a repository of a simulator, and on the page about it."""

import json
import re
import shlex

import numpy as np
import pytest
import yaml
from tests import ROOT
from tests.commands import run
from tests.rows import rows

import allanite as al
from allanite.cli import main

WORKFLOW = yaml.safe_load((ROOT / ".github" / "workflows" / "check-noise.yml").read_text("utf-8"))
RIGHT = "N 0.3 deg/sqrt(h), K 300 deg/h/sqrt(h)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("check")
    rng = np.random.default_rng(8)
    records = [al.simulate(al.Model(RIGHT), 20_000, 50.0, rng=rng).values for _ in range(2)]
    np.savetxt(folder / "imu.csv", np.column_stack(records), delimiter=",", header="gx [rad/s],gy [rad/s]", comments="")
    accelerometer = "N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)"
    for name, gyro in (("right", RIGHT), ("wrong", RIGHT.replace("0.3", "0.2121"))):
        text = al.export([al.Model(gyro), al.Model(accelerometer)], "kalibr", rate=50.0).text
        (folder / f"{name}.yaml").write_text(text)
    return folder


@pytest.mark.slow("a dozen analyses")
@rows("words, code, answer", [
    ("imu.csv --claims right.yaml", 0, "the record agrees with the claim"),
    ("imu.csv --claims wrong.yaml", 4, "sqrt(2): one-sided and two-sided density"),
    ("imu.csv --claims wrong.yaml --tolerance 50", 0, "agrees with the claim"),
    ("no.csv --claims right.yaml", 3, "no.csv"),
    ("imu.csv --claims no.yaml", 3, "'no.yaml' cannot be read"),
    ("imu.csv", 2, "--claims 'N 0.3 deg/sqrt(h)'"),
    ("imu.csv --claims adis16740", 2, "did you mean the data sheet ADIS16470"),
    ("imu.csv --claims right.yaml --claims-from kalbir", 2, "did you mean kalibr"),
])  # fmt: skip
def test_the_exit_code_is_the_answer(folder, monkeypatch, words, code, answer):
    monkeypatch.chdir(folder)
    assert answer in " ".join(run("check", *words.split(), "--rate", "50", code=code).output.split())


@pytest.mark.slow("takes more than half a second")
def test_what_is_written_says_the_same(folder, monkeypatch, tmp_path):
    outputs = {"report": "page.html", "plot": "curve.svg", "json": "noise.json", "csv": "noise.csv"}
    options = [word for name, file in outputs.items() for word in (f"--{name}", str(tmp_path / file))]
    monkeypatch.chdir(folder)
    run("check", "imu.csv", "--rate", "50", "--claims", "wrong.yaml", *options, code=4)
    page, plot, numbers, table = ((tmp_path / file).read_text("utf-8") for file in outputs.values())
    found = json.loads(numbers)
    assert (found["agrees"], found["claim"]["kind"]) == (False, "kalibr")
    assert "sqrt(2)" in str(found["causes"])
    assert "claimed" in page
    assert "one-sided and two-sided density" in page
    assert "claimed" in plot
    assert len(table.splitlines()) == 1 + len(found["terms"])


def test_the_workflow_runs_what_exists():
    inputs = WORKFLOW[True]["workflow_call"]["inputs"]  # YAML takes "on" for a truth value
    (job,) = WORKFLOW["jobs"].values()
    text = str(job)
    assert set(re.findall(r"inputs\.(\w+)", text)) == set(inputs)
    assert {name for name, row in inputs.items() if row.get("required")} == {"record", "claims"}
    (line,) = (step["run"] for step in job["steps"] if step.get("name") == "Check")
    words = [word for word in shlex.split(line) if word.startswith("--")]
    offered = {option for param in main.get_command(None, "check").params for option in param.opts}
    assert words == ["--claims", "--report", "--json"]
    assert set(words) < offered
    assert not any("${{" in step.get("run", "") for step in job["steps"])  # no input is run as a command


def test_the_page_calls_the_workflow_with_its_inputs():
    page = (ROOT / "docs" / "check.md").read_text("utf-8")
    (block,) = re.findall(r"^```yaml\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    job = yaml.safe_load(block)["jobs"]["noise"]
    assert job["uses"].endswith("/.github/workflows/check-noise.yml@main")
    assert set(job["with"]) <= set(WORKFLOW[True]["workflow_call"]["inputs"])
