"""Files that cannot be analysed are refused in words: what came, what was expected, what to do. See test_errors."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import rows

OPTIONS = ["--rate", "100", "--unit", "deg/s"]


class Trap:
    """Leaves a file behind if it is ever unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (Path.touch, (self.path,))


def noise(n=5000):
    return np.random.default_rng(1).standard_normal(n)


def spoilt(y, where, value):
    y[where] = value
    return y


def csv_of(path, values):
    np.savetxt(path, values, "%.17g", header="gx", comments="")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs")
    csv_of(folder / "nan.csv", np.full(1000, np.nan))
    csv_of(folder / "constant.csv", np.full(1000, 3.25))
    csv_of(folder / "short.csv", noise(10))
    csv_of(folder / "brief.csv", noise(199))
    csv_of(folder / "infinite.csv", spoilt(noise(), slice(7, 9), np.inf))
    csv_of(folder / "lost.csv", spoilt(noise(), slice(150, None), np.nan))
    csv_of(folder / "nearly.csv", spoilt(noise(), slice(300, None), np.nan))
    csv_of(folder / "torn.csv", spoilt(noise(), np.isin(np.arange(5000) % 5, (1, 3, 4)), np.nan))
    csv_of(folder / "still.csv", spoilt(spoilt(noise(), slice(None), 3.25), slice(50, 90), np.nan))
    csv_of(folder / "moving.csv", noise() + 500 * np.sin(np.arange(5000) / 90) * (np.arange(5000) > 3000))
    np.save(folder / "pickle.npy", np.array([Trap(folder / "executed")], dtype=object), allow_pickle=True)
    (folder / "bare.npy").write_bytes(pickle.dumps(Trap(folder / "executed")))
    body = "\n".join(f"{v:.4f}" for v in noise())
    (folder / "rates.csv").write_text("Sample rate: 100 Hz\nUpdate rate: 50 Hz\ngx [deg/s]\n" + body)
    return folder


REFUSED = {
    "nan.csv": "not finite", "constant.csv": "constant", "short.csv": "too short", "brief.csv": "too short",
    "lost.csv": "too little left", "nearly.csv": "too little left", "torn.csv": "too little left",
    "still.csv": "constant", "moving.csv": "moving",
}  # fmt: skip
"""Records that cannot be analyzed, and the finding that says so."""


@rows("file, finding", REFUSED.items())
def test_a_record_is_refused_for_its_finding(inputs, file, finding, refusals):
    run("analyze", inputs / file, *OPTIONS, code=3)
    assert refusals.pop().code == finding


@rows("file, options, code, words", [
    ("rates.csv", (), 2, "contradict each other line 1 line 2 --rate HZ"),
    ("infinite.csv", OPTIONS, 3, "2 of 5000 samples infinite sample 7 NaN"),
    ("pickle.npy", OPTIONS, 3, "pickle never"), ("bare.npy", OPTIONS, 3, "bare.npy"),
])  # fmt: skip
def test_a_file_is_refused_in_words(inputs, file, options, code, words):
    ends(run("analyze", inputs / file, *options), code, *words.split())
    assert not (inputs / "executed").exists()


@pytest.mark.slow("takes more than half a second")
def test_gaps_and_outliers_are_dealt_with_and_said(tmp_path):
    y = noise(20_000)
    y[[500, 9000]] += 40
    csv_of(tmp_path / "a.csv", spoilt(y, slice(4000, 4300), np.nan))
    found = {}
    for choice in ("", "keep", "mark"):
        words = (tmp_path / "a.csv", *OPTIONS, *(("--outliers", choice) if choice else ()))
        found[choice] = json.loads(run("analyze", *words, "--json", "-", code=0).stdout)["channels"][0]
    sizes = {name: channel["fit"]["terms"][1]["value"] for name, channel in found.items()}
    assert sizes["keep"] > 1.05 * sizes[""]
    assert sizes["mark"] == pytest.approx(sizes[""], rel=1e-9)
    assert "2 outliers beyond" in found[""]["fit"]["notes"][-1]
    assert "2 outliers beyond" in found["mark"]["history"][-1]
    assert not any("outlier" in note for note in found["keep"]["fit"]["notes"])
    assert {"gaps", "outliers"} <= {finding["name"] for finding in found[""]["quality"]["findings"]}
    said = " ".join(run("analyze", tmp_path / "a.csv", *OPTIONS, "--details").output.split())
    assert "exclude them there, too (--outliers mark)" in said
    # the curve has them, unless they are left out everywhere
    curves = {name: channel["curves"][0]["deviation"][0] for name, channel in found.items()}
    # the noise of the exact expectation is another one, which rounds otherwise
    assert curves[""] == pytest.approx(curves["keep"], rel=1e-12)
    assert curves["keep"] > 1.02 * curves["mark"]
