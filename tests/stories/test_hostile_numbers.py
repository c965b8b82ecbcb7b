"""Names, units, descriptions and numbers that no sensor gives, in files that can be read: a result, or a sentence."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from tests.commands import run
from tests.rows import paired, rows

import allanite as al

h5py = pytest.importorskip("h5py")

RNG = np.random.default_rng(1)
SAMPLES = RNG.normal(size=4000)
RAW = ("--rate", "100", "--unit", "deg/s")


def text(header):
    """A file of text with this header."""
    lines = "".join(f"{k / 100:.2f},{x:.4f}\n" for k, x in enumerate(SAMPLES))
    return lambda path: path.write_text(f"time [s],{header}\n{lines}")


def described(rate=100.0, scale=None):
    """A Parquet file that states these."""

    def write(path):
        al.write(al.Record(SAMPLES, 100.0, "deg/s", name="gx"), path)
        table = parquet.read_table(path)
        said = json.loads(table.schema.metadata[b"allanite"])
        said["rate"], said["channels"][0]["scale"] = rate, scale
        metadata = {"allanite": json.dumps(said), "rate": repr(rate)}
        parquet.write_table(pa.table(table).replace_schema_metadata(metadata), path)

    return write


def twelve_bits(path):
    """Integers of 12 bits."""
    kind = h5py.h5t.STD_I16LE.copy()
    kind.set_precision(12)
    with h5py.File(path, "w") as file:
        made = h5py.h5d.create(file.id, b"gx", kind, h5py.h5s.create_simple(SAMPLES.shape))
        h5py.Dataset(made)[:] = (1000 * SAMPLES).astype("<i2").clip(-2000, 2000)


CASES = {
    "formula.csv": (text(r"$\frac{a [deg/s]"), (), 0, ""),
    "<img src=x onerror=alert(1)>.csv": (text("gx [deg/s]"), (), 0, ""),
    "infinite_unit.csv": (text("gx [rad/s*(rad/mrad)^200]"), (), 2, "the unit is unknown"),
    "rate.parquet": (described(rate=1e308), (), 2, "must be between 1e-09 and 1e+15 Hz, not 1e+308"),
    "slow.parquet": (described(rate=1e-308), (), 2, "must be between 1e-09 and 1e+15 Hz, not 1e-308"),
    "scale.parquet": (described(scale=1e308), (), 2, "scale must be"),
    "fine.parquet": (described(scale=5e-324), (), 2, "scale must be"),
    "random.bin": (lambda path: path.write_bytes(RNG.bytes(64_000)), ("--dtype", "<f8", *RAW), 3, "any sensor"),
    "bits.h5": (twelve_bits, RAW, 0, ""),
}


@pytest.mark.slow("seconds of analyses")
@rows("name, verb", paired(CASES, ["analyze", "deviation", "spectrum"]))
def test_a_result_or_a_sentence(name, verb, tmp_path, monkeypatch):
    make, options, code, words = CASES[name]
    monkeypatch.chdir(tmp_path)
    make(tmp_path / name)
    outputs = ("--json", "a.json", "--csv", "a.csv", "--plot", "a.png")
    result = run(verb, name, *options, *outputs, code=code)
    assert words in result.stderr
    assert len(re.sub(r"(?m)^(try: |  ).*\n", "", result.stderr).splitlines()) == bool(words), result.stderr
    assert {path.name for path in tmp_path.iterdir()} == {name, *(() if code else outputs[1::2])}


def test_a_stage_named_like_a_formula(tmp_path):
    text("gx [deg/s]")(tmp_path / "a.csv")
    run("budget", tmp_path / "a.csv", "--stage", r"$\frac{ 16 300deg/s", "--plot", tmp_path / "a.png", code=0)


@pytest.mark.slow("takes more than half a second")
def test_a_backend_that_does_not_exist(tmp_path):
    text("gx [deg/s]")(tmp_path / "a.csv")
    command = [sys.executable, "-m", "allanite.cli", "analyze", tmp_path / "a.csv", "--plot", tmp_path / "a.png"]
    done = subprocess.run(command, env=os.environ | {"MPLBACKEND": "nonsense"}, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
