"""Each extra by itself: what needs a missing library names the command that installs it, and all else goes on."""

import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from tests import ROOT
from tests.commands import run
from tests.rows import rows
from tests.sound_files import SEEDS

import allanite as al
from allanite.core.errors import cure, requirements

SAMPLE = ROOT / "examples" / "tactical_gyro.csv"
FOLDER = shlex.quote(str(SAMPLE.parent))

BLOCK = "import os, sys; sys.modules.update(dict.fromkeys(os.environ['ALLANITE_MISSING'].split(), None))\n"
"""What every process begins with that the tests start: these modules cannot be found."""


class Extra(NamedTuple):
    """The modules of an extra, files that it reads, and commands that need it."""

    modules: tuple[str, ...]
    files: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()


EXTRAS = {
    "hdf5": Extra(("h5py",), ("plain.h5", "matlab73.mat"), ("simulate new.h5 --sensor mems --duration 10 --rate 100",)),
    "ros": Extra(("rosbags",), ("plain.bag", "plain.db3", "plain.mcap")),
    "r": Extra(("rdata",), ("matrix.rda", "frame.rds")),
    "ulog": Extra(("pyulog",), ("flight.ulg",)),
    "xlsx": Extra(("openpyxl",), ("sheet.xlsx",)),
    "tdms": Extra(("nptdms",), ("run.tdms",)),
    "mdf": Extra(("asammdf",), ("run.mf4",)),
    "web": Extra(("fastapi", "uvicorn"), (), (f"serve {FOLDER}/{SAMPLE.name}",)),
    "live": Extra(("serial",), (), ("watch /dev/null --rate 100 --unit deg/s",)),
    "dask": Extra(("distributed",), (), (f"batch {FOLDER} --out out --scheduler tcp://127.0.0.1:9",)),
}
MODULES = {extra: set(row.modules) for extra, row in EXTRAS.items()}

SUFFIXES = {Path(name).suffix for row in EXTRAS.values() for name in row.files} - {".mat"}  # version 5 needs only scipy
PLAIN = [name for name in SEEDS if Path(name).suffix not in SUFFIXES and name not in EXTRAS["hdf5"].files]
"""Files of all formats that need no extra."""

PROGRAM = "import allanite as al; import sys; print(len(al.analyze(sys.argv[1]).channels))"


def take_away(modules, monkeypatch, folder):
    """Take modules away from this process and from those that it starts."""
    (folder / "sitecustomize.py").write_text(BLOCK, "utf-8")
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    monkeypatch.setenv("ALLANITE_MISSING", " ".join(modules))
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)


def write_files(extra):
    """Write the files of an extra into the current folder; skipped without the libraries that make them."""
    for module in EXTRAS[extra].modules if EXTRAS[extra].files else ():
        pytest.importorskip(module)
    for name in EXTRAS[extra].files:
        Path(name).write_bytes(SEEDS[name].make())


@rows("extra", EXTRAS)
def test_what_needs_a_missing_library_names_the_command_that_installs_it(extra, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    write_files(extra)
    take_away(MODULES[extra], monkeypatch, tmp_path)
    for command in (*(f"info {name}" for name in EXTRAS[extra].files), *EXTRAS[extra].commands):
        done = run(*shlex.split(command), code=2)
        assert done.stderr.strip().endswith(f"not installed: {cure(requirements(extra))}"), (command, done.stderr)


@pytest.mark.slow("seconds of analyses")
@rows("extra", [extra for extra, row in EXTRAS.items() if row.files])
def test_a_format_needs_only_the_libraries_of_its_extra(extra, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    write_files(extra)
    take_away(set().union(*MODULES.values()) - MODULES[extra], monkeypatch, tmp_path)
    for name in EXTRAS[extra].files:
        assert len(al.read(name, **SEEDS[name].options)) >= 1


@pytest.mark.slow("takes more than half a second")
def test_everything_else_needs_no_extra(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in PLAIN:
        Path(name).write_bytes(SEEDS[name].make())
    take_away(set().union(*MODULES.values()), monkeypatch, tmp_path)
    done = subprocess.run([sys.executable, "-c", PROGRAM, SAMPLE], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "3\n", "")
    for name in PLAIN:
        options = {key: [value] if key == "channels" else value for key, value in SEEDS[name].options.items()}
        assert len(al.read(name, **options)) >= 1, name
