"""The tests with the wheel installed into environments of their own: several Pythons, oldest and newest dependencies.

    python benchmarks/environments.py [--pythons python3.11 python3.12] [--tests tests/unit/cli] [--write PATH]

The wheel is built from the sdist. The oldest dependencies are the lower bounds of pyproject.toml, which the first
Python has; the newest are what pip finds today. Tools of the tests themselves are the newest throughout. Ends with
exit code 1 if something cannot be installed or a test fails.
"""

from table import ROOT, begin, markdown

import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable
from pathlib import Path

EXTRAS = ("hdf5", "ros", "r", "ulog", "xlsx", "tdms", "mdf", "web", "live")
TESTS = [
    "tests/unit/readers",
    "tests/unit/reporting",
    "tests/unit/cli",
    "tests/conformance/test_statistics.py",
    "tests/conformance/test_round_trip.py",
]
"""Tests of everything that meets a dependency, and of every statistic."""

SHOWN = ("numpy", "scipy", "numba", "pyarrow", "matplotlib", "click", "h5py", "threadpoolctl")
"""Packages whose versions the table has."""


def bounds() -> list[str]:
    """Lower bounds of the dependencies, those of the extras among them, as constraints."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *(one for name in EXTRAS for one in extras[name])]
    return [re.sub(r">=([\d.]+).*", r"==\1", one) for one in wanted]


def run(*words: object, folder: Path) -> tuple[int, str]:
    """The exit code of a command, and what it printed."""
    done = subprocess.run([str(word) for word in words], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def must(*words: object, folder: Path) -> str:
    """What a command prints that has to succeed."""
    code, said = run(*words, folder=folder)
    if code:
        sys.exit(said)
    return said


def built(folder: Path) -> tuple[Path, Path]:
    """The sources as a user unpacks them, and the wheel that is built of them."""
    must(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, folder=ROOT)
    (archive,) = folder.glob("*.tar.gz")
    shutil.unpack_archive(archive, folder, filter="data")
    sources = archive.with_name(archive.name.removesuffix(".tar.gz"))
    must(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, folder=sources)
    return sources, next(folder.glob("*.whl"))


def tried(python: str, oldest: bool, made: tuple[Path, Path], tests: Iterable[str]) -> tuple[list[str], bool]:
    """The line of an environment, and whether all tests passed in it."""
    sources, wheel = made
    home = sources.parent / f"{python}-{oldest}"
    must(python, "-m", "venv", home, folder=sources)
    own = home / "bin" / "python"
    limits = home / "oldest.txt"
    limits.write_text("\n".join(bounds() if oldest else ()))
    which = f"{wheel}[{','.join(EXTRAS)}]"
    also = [one for one in test_tools() if not one.startswith("allanite")]
    must(own, "-m", "pip", "install", "-q", "-c", limits, which, *also, folder=sources)
    listed = dict(line.split("==") for line in must(own, "-m", "pip", "freeze", folder=sources).split() if "==" in line)
    version = must(own, "-c", "import platform; print(platform.python_version())", folder=sources).strip()
    code, said = run(own, "-m", "pytest", "-q", "-n", "2", "--dist", "worksteal", *tests, folder=sources)
    print(said, flush=True)
    last = said.strip().splitlines()[-1].strip("= ")
    row = [version, "oldest" if oldest else "newest", *(listed.get(name, "") for name in SHOWN), last]
    return row, code == 0


def test_tools() -> list[str]:
    """What the tests themselves need."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return list(project["optional-dependencies"]["test"])


def main() -> None:
    asked = begin(__doc__, pythons=["python3.11", "python3.12", "python3.13"], tests=TESTS)
    rows, good = [], True
    with tempfile.TemporaryDirectory() as name:
        made = built(Path(name))
        first, *_ = asked.asked.pythons
        for python, oldest in [(first, True), *((python, False) for python in asked.asked.pythons)]:
            row, passed = tried(python, oldest, made, asked.asked.tests)
            rows.append(row)
            good &= passed
    notes = ("the wheel of the sdist, with its extras " + ", ".join(EXTRAS),)
    asked.publish(
        "Versions of Python and of dependencies", notes, markdown(("Python", "dependencies", *SHOWN, "tests"), rows)
    )
    sys.exit(not good)


if __name__ == "__main__":
    main()
