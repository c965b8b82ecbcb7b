"""Each extra by itself: what needs a missing library names the command that installs it, and all else goes on."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

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


EXTRAS = {
    # its modules, files that it reads, and a command that needs it
    "hdf5": ("h5py", "plain.h5 matlab73.mat", "simulate new.h5 --sensor mems --duration 10 --rate 100"),
    "ros": ("rosbags", "plain.bag plain.db3 plain.mcap", ""), "r": ("rdata", "matrix.rda frame.rds", ""),
    "ulog": ("pyulog", "flight.ulg", ""), "xlsx": ("openpyxl", "sheet.xlsx", ""), "tdms": ("nptdms", "run.tdms", ""),
    "mdf": ("asammdf", "run.mf4", ""), "web": ("fastapi uvicorn", "", f"serve {FOLDER}/{SAMPLE.name}"),
    "live": ("serial", "", "watch /dev/null --rate 100 --unit deg/s"),
    "dask": ("distributed", "", f"batch {FOLDER} --out out --scheduler tcp://127.0.0.1:9"),
}  # fmt: skip
MODULES = {extra: set(modules.split()) for extra, (modules, _, _) in EXTRAS.items()}
FILES = {extra: files.split() for extra, (_, files, _) in EXTRAS.items() if files}

SUFFIXES = {Path(name).suffix for files in FILES.values() for name in files} - {".mat"}  # version 5 needs only scipy
PLAIN = [name for name in SEEDS if Path(name).suffix not in SUFFIXES and name not in FILES["hdf5"]]
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
    for module in MODULES[extra]:
        pytest.importorskip(module)
    for name in FILES[extra]:
        Path(name).write_bytes(SEEDS[name].make())


@rows("extra", EXTRAS)
def test_what_needs_a_missing_library_names_the_command_that_installs_it(extra, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    commands = [*(f"info {name}" for name in FILES.get(extra, ())), EXTRAS[extra][2]]
    if extra in FILES:
        write_files(extra)
    take_away(MODULES[extra], monkeypatch, tmp_path)
    for command in filter(None, commands):
        done = run(*shlex.split(command), code=2)
        assert done.stderr.strip().endswith(f"not installed: {cure(requirements(extra))}"), (command, done.stderr)


@pytest.mark.slow("seconds of analyses")
@rows("extra", FILES)
def test_a_format_needs_only_the_libraries_of_its_extra(extra, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    write_files(extra)
    take_away(set().union(*MODULES.values()) - MODULES[extra], monkeypatch, tmp_path)
    for name in FILES[extra]:
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
