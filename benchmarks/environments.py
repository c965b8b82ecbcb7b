"""The tests with the distribution installed into environments of their own, in every kind of place.

The wheel is built from the sdist. `KINDS` says what is installed and where the tests run; kinds of one installation
share it. The oldest dependencies are the lower bounds of pyproject.toml, the newest are what pip finds today, and
pre-releases what it finds with --pre. Tools of the tests are the newest throughout. Pythons that are not at hand are
left out and named. Ends with exit code 1 if something cannot be installed or a test fails.
"""

from table import ROOT, begin, markdown

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

PYTHONS = ["python3.11", "python3.12", "python3.13", "python3.14"]
FIRST, LAST, EACH = slice(0, 1), slice(-1, None), slice(None)  # which of the Pythons at hand a kind is tried with

ROOMS = (
    "tests/unit/readers", "tests/unit/reporting", "tests/unit/cli/test_cli.py", "tests/conformance/test_statistics.py",
)  # fmt: skip
"""Tests of everything that meets a dependency, and of every statistic."""

PLACES = (
    "tests/conformance/test_round_trip.py", "tests/conformance/test_extras.py", "tests/stories/test_first_answer.py",
)  # fmt: skip
"""Tests of every format and of the commands, in processes of their own."""

REFUSED = """
import socket

def refuse(self, address):
    raise OSError(101, "Network is unreachable")

socket.socket.connect = socket.socket.connect_ex = refuse
"""
"""What Python begins with where the system cannot take the network away."""


def run(*words: object, folder: Path, environ: Mapping[str, str] = {}) -> tuple[int, str]:
    """The exit code of a command, and what it printed."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "NUMBA_CACHE_DIR")}
    command = [str(word) for word in words]
    done = subprocess.run(command, cwd=folder, env=kept | environ, capture_output=True, check=False)
    return done.returncode, (done.stdout + done.stderr).decode(errors="replace")


def must(*words: object, folder: Path) -> str:
    """What a command prints that has to succeed."""
    code, printed = run(*words, folder=folder)
    return sys.exit(printed) if code else printed


def offline(home: Path) -> tuple[tuple[str, ...], dict[str, str]]:
    """Without the network: taken away by the system, or refused by Python."""
    words = ("unshare", "--map-root-user", "--net")
    if shutil.which("unshare") and run(*words, "true", folder=home)[0] == 0:
        return words, {}
    (home / "refused").mkdir(exist_ok=True)
    (home / "refused" / "sitecustomize.py").write_text(REFUSED)
    return (), {"PYTHONPATH": str(home / "refused")}


def closed(home: Path) -> tuple[tuple[str, ...], dict[str, str]]:
    """Neither the environment nor the home folder can be written; the rights of root are given up."""
    must("chmod", "-R", "a-w", home, folder=home.parent)
    root = ("setpriv", "--bounding-set", "-all", "--inh-caps", "-all")
    return root if os.geteuid() == 0 else (), {"HOME": str(home)}


class Made(NamedTuple):
    """What is installed."""

    oldest: bool = False
    form: str = "wheel"
    extras: str = "[all]"
    pip: tuple[str, ...] = ()
    environ: Mapping[str, str] = {}
    """Variables; {bin} stands for the folder of the environment's programs."""


class Kind(NamedTuple):
    """What is installed, for which Pythons, and where which tests run."""

    place: str
    made: Made = Made()
    pythons: slice = LAST
    without: Callable[[Path], tuple[tuple[str, ...], dict[str, str]]] = lambda _: ((), {})
    """What is taken away: words before the command of the tests, and variables."""
    tests: tuple[str, ...] = PLACES


ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
NO_COMPILER = {"PATH": "{bin}", "CC": "/bin/false", "CXX": "/bin/false"}

KINDS = {
    "oldest": Kind("oldest dependencies", Made(oldest=True), FIRST, tests=ROOMS + PLACES),
    "newest": Kind("newest dependencies", pythons=EACH, tests=ROOMS + PLACES),
    "offline": Kind("no network", without=offline),
    "read-only": Kind("nothing can be written but temporary files", without=closed),
    "ascii": Kind("locale C, no UTF-8 mode", without=lambda _: ((), ASCII)),
    "pre-releases": Kind("pre-releases of dependencies", Made(pip=("--pre",)), tests=ROOMS + PLACES),
    "binary": Kind("no compiler", Made(pip=("--only-binary", ":all:"), environ=NO_COMPILER)),
    "sdist": Kind("from the sdist, without extras", Made(form="sdist", extras=""), FIRST),
}

SHOWN = ("numpy", "scipy", "numba", "pyarrow", "matplotlib", "click", "h5py")  # packages whose versions the table has

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
OPTIONAL = PROJECT["optional-dependencies"]
LINTERS = ("ruff", "mypy", "import-linter", "playwright")


def bounds() -> list[str]:
    """Lower bounds of the dependencies, those of the extras among them, as constraints."""
    extras = re.findall(r"\w+", OPTIONAL["all"][0])[1:]
    wanted = [*PROJECT["dependencies"], *(one for name in extras for one in OPTIONAL[name])]
    return [re.sub(r">=([\d.]+).*", r"==\1", one) for one in wanted]


def tools(made: Made) -> list[str]:
    """What the tests themselves need; what is an oracle of a format only with the extras."""
    named = OPTIONAL["dev"] + (OPTIONAL["test"] if made.extras else [])
    return [one for one in named if not one.startswith(("allanite", *LINTERS))]


def built(folder: Path) -> tuple[Path, dict[str, Path]]:
    """The sources as a user unpacks them, and the sdist and the wheel that is built of them."""
    must(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, folder=ROOT)
    (archive,) = folder.glob("*.tar.gz")
    shutil.unpack_archive(archive, folder, filter="data")
    sources = archive.with_name(archive.name.removesuffix(".tar.gz"))
    must(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, folder=sources)
    return sources, {"sdist": archive, "wheel": next(folder.glob("*.whl"))}


def install(made: Made, python: str, home: Path, files: Mapping[str, Path]) -> tuple[int, str]:
    """Make an environment, and install the distribution and what its tests need."""
    limits, folder = home.with_suffix(".limits"), home.parent
    limits.write_text("\n".join(bounds() if made.oldest else ()))
    pip = (home / "bin" / "python", "-m", "pip", "install", "-q", "-c", limits)
    environ = variables(made, home)
    must(python, "-m", "venv", home, folder=folder)
    code, printed = run(*pip, *made.pip, f"{files[made.form]}{made.extras}", folder=folder, environ=environ)
    return (code, printed) if code else run(*pip, *tools(made), folder=folder, environ=environ)


def variables(made: Made, home: Path) -> dict[str, str]:
    """Variables of an environment."""
    return {name: value.format(bin=home / "bin") for name, value in made.environ.items()}


def tried(kind: Kind, home: Path, sources: Path) -> tuple[int, str]:
    """The exit code of the tests in an environment, and what they say."""
    before, more = kind.without(home)
    pytest = ("-m", "pytest", "-q", "-n", "2", "--dist", "worksteal", "-p", "no:cacheprovider", "-m", "not slow")
    words = (*before, home / "bin" / "python", *pytest, *kind.tests)
    try:
        return run(*words, folder=sources, environ=variables(kind.made, home) | more)
    finally:
        must("chmod", "-R", "u+w", home, folder=home.parent)


def versions(home: Path) -> list[str]:
    """The version of Python in an environment, and those of packages."""
    own = home / "bin" / "python"
    listed = must(own, "-m", "pip", "freeze", folder=home).split()
    found = dict(line.split("==") for line in listed if "==" in line)
    python = must(own, "-c", "import platform; print(platform.python_version())", folder=home).strip()
    return [python, *(found.get(name, "") for name in SHOWN)]


def main() -> None:
    asked = begin(__doc__, pythons=PYTHONS, kinds=list(KINDS))
    shared = dict[tuple[str, str], list[str]]()
    found = (python for python in asked.asked.pythons if shutil.which(python))
    pythons = [python for python in found if run(python, "--version", folder=ROOT)[0] == 0]
    for name in asked.asked.kinds:
        for python in pythons[KINDS[name].pythons]:
            shared.setdefault((python, str(KINDS[name].made)), []).append(name)
    rows, good = [], True
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder, "environment")
        sources, files = built(home.parent)
        for (python, _), names in shared.items():
            installed = install(KINDS[names[0]].made, python, home, files)
            for name in names:
                code, printed = installed if installed[0] else tried(KINDS[name], home, sources)
                print(printed, flush=True)
                last = printed.strip().splitlines()[-1].strip("= ")
                rows.append([name, KINDS[name].place, *versions(home), last])
                good &= code == 0
            must("rm", "-rf", home, folder=sources)
    notes = [f"not at hand: {python}" for python in asked.asked.pythons if python not in pythons]
    headings = ("kind", "place", "Python", *SHOWN, "tests")
    asked.publish("Versions of Python and of dependencies, and places", notes, markdown(headings, rows))
    sys.exit(not good)


if __name__ == "__main__":
    main()
