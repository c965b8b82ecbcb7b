"""The tests with the distribution installed into environments of their own, in every kind of place.

The wheel is built from the sdist. `KINDS` says what is installed and where the tests run; rows of the same installation
share it. The oldest dependencies are the lower bounds of pyproject.toml, the newest are what pip finds today, and
pre-releases what it finds with --pre. Tools of the tests are the newest throughout. Pythons and locales that are not
at hand are left out and named. Ends with exit code 1 if something cannot be installed or a test fails.
"""

from table import ROOT, begin, markdown

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

PYTHONS = ["python3.11", "python3.12", "python3.13", "python3.14"]
FIRST, LAST, EACH = slice(0, 1), slice(-1, None), slice(None)  # which of the Pythons at hand a kind is tried with

ROOMS = (
    "tests/unit/readers", "tests/unit/reporting", "tests/unit/cli/test_cli.py", "tests/conformance/test_statistics.py",
)  # fmt: skip
"""Tests of everything that meets a dependency, and of every statistic."""

PLACES = tuple(f"tests/{test}.py" for test in (
    "conformance/test_round_trip", "conformance/test_extras", "stories/test_first_answer"
))  # fmt: skip
"""Tests of every format and of the commands, in processes of their own."""

REFUSED = """
import socket

def _refuse(self, address):
    raise OSError(101, "Network is unreachable")

socket.socket.connect = socket.socket.connect_ex = _refuse
"""
"""What Python begins with where the system cannot take the network away."""


def run(*words: object, folder: Path, environ: Mapping[str, str] = {}) -> tuple[int, str]:
    """The exit code of a command, and what it printed."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "NUMBA_CACHE_DIR")}
    done = subprocess.run(
        [str(word) for word in words], cwd=folder, env=kept | environ, capture_output=True, check=False
    )
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


class Kind(NamedTuple):
    """What is installed, and where the tests run."""

    place: str
    pythons: slice = LAST
    dependencies: str = "newest"
    form: str = "wheel"
    extras: str = "all"
    pip: tuple[str, ...] = ()
    environ: Mapping[str, str] = {}
    """Variables; {bin} stands for the folder of the environment's programs."""
    without: Callable[[Path], tuple[tuple[str, ...], dict[str, str]]] | None = None
    """What is taken away: words before the command of the tests, and more variables."""
    tests: tuple[str, ...] = PLACES


def _speaking(locale: str) -> dict[str, str]:
    return {"LC_ALL": locale, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


KINDS = {
    "oldest": Kind("plain", FIRST, dependencies="oldest", tests=ROOMS + PLACES),
    "newest": Kind("plain", EACH, tests=ROOMS + PLACES),
    "offline": Kind("no network", without=offline),
    "read-only": Kind("nothing can be written but temporary files", without=closed),
    "ascii": Kind("locale C, no UTF-8 mode", environ=_speaking("C")),
    "turkish": Kind("Turkish, ISO 8859-9", environ=_speaking("tr_TR")),
    "german": Kind("German, UTF-8", environ=_speaking("de_DE.UTF-8")),
    "chinese": Kind("Chinese, GB 18030", environ=_speaking("zh_CN.gb18030")),
    "pre-releases": Kind("plain", dependencies="pre-release", pip=("--pre",), tests=ROOMS + PLACES),
    "binary": Kind(
        "no compiler", pip=("--only-binary", ":all:"),
        environ={"PATH": "{bin}", "CC": "/bin/false", "CXX": "/bin/false"},
    ),
    "sdist": Kind("plain", FIRST, form="sdist", extras="none"),
}  # fmt: skip

SHOWN = ("numpy", "scipy", "numba", "pyarrow", "matplotlib", "click", "h5py")  # packages whose versions the table has

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
OPTIONAL = PROJECT["optional-dependencies"]
LINTERS = ("ruff", "mypy", "import-linter", "playwright")


def bounds() -> list[str]:
    """Lower bounds of the dependencies, those of the extras among them, as constraints."""
    extras = re.findall(r"\w+", OPTIONAL["all"][0])[1:]
    wanted = [*PROJECT["dependencies"], *(one for name in extras for one in OPTIONAL[name])]
    return [re.sub(r">=([\d.]+).*", r"==\1", one) for one in wanted]


def tools(extras: str) -> list[str]:
    """What the tests themselves need; what is an oracle of a format only with the extras."""
    named = OPTIONAL["dev"] + (OPTIONAL["test"] if extras == "all" else [])
    return [one for one in named if not one.startswith(("allanite", *LINTERS))]


def built(folder: Path) -> tuple[Path, dict[str, Path]]:
    """The sources as a user unpacks them, and the sdist and the wheel that is built of them."""
    must(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, folder=ROOT)
    (archive,) = folder.glob("*.tar.gz")
    shutil.unpack_archive(archive, folder, filter="data")
    sources = archive.with_name(archive.name.removesuffix(".tar.gz"))
    must(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, folder=sources)
    return sources, {"sdist": archive, "wheel": next(folder.glob("*.whl"))}


def install(kind: Kind, python: str, home: Path, made: Mapping[str, Path]) -> tuple[int, str]:
    """Make an environment, and install the distribution and what its tests need."""
    limits, folder = home.with_suffix(".limits"), home.parent
    limits.write_text("\n".join(bounds() if kind.dependencies == "oldest" else ()))
    which = str(made[kind.form]) + ("[all]" if kind.extras == "all" else "")
    environ = _environ(kind, home)
    pip = (home / "bin" / "python", "-m", "pip", "install", "-q", "-c", limits)
    must(python, "-m", "venv", home, folder=folder)
    code, printed = run(*pip, *kind.pip, which, folder=folder, environ=environ)
    return (code, printed) if code else run(*pip, *tools(kind.extras), folder=folder, environ=environ)


def _environ(kind: Kind, home: Path) -> dict[str, str]:
    return {name: value.format(bin=home / "bin") for name, value in kind.environ.items()}


def tried(kind: Kind, home: Path, sources: Path) -> tuple[list[str], bool]:
    """The versions in an environment and what the tests say there, and whether all passed."""
    own = home / "bin" / "python"
    listed = dict(line.split("==") for line in must(own, "-m", "pip", "freeze", folder=sources).split() if "==" in line)
    version = must(own, "-c", "import platform; print(platform.python_version())", folder=sources).strip()
    before, more = kind.without(home) if kind.without else ((), {})
    pytest = (own, "-m", "pytest", "-q", "-n", "2", "--dist", "worksteal", "-p", "no:cacheprovider", "-m", "not slow")
    try:
        environ = _environ(kind, home) | more
        code, printed = run(*before, *pytest, *kind.tests, folder=sources, environ=environ)
    finally:
        must("chmod", "-R", "u+w", home, folder=home.parent)
    print(printed, flush=True)
    what = [version, kind.dependencies, kind.form, kind.extras, kind.place]
    return [*what, *(listed.get(name, "") for name in SHOWN), printed.strip().splitlines()[-1].strip("= ")], code == 0


def failed(kind: Kind, python: str, printed: str) -> list[str]:
    """The line of an environment into which something cannot be installed."""
    print(printed, flush=True)
    return [python, *kind[2:5], kind.place, *("" for _ in SHOWN), printed.strip().splitlines()[-1]]


def at_hand(python: str) -> bool:
    """Whether a Python can be started."""
    return shutil.which(python) is not None and run(python, "--version", folder=ROOT)[0] == 0


def spoken(kind: Kind) -> bool:
    """Whether the system has the locale of a kind."""
    code = "import locale; locale.setlocale(locale.LC_ALL, '')"
    return run(sys.executable, "-c", code, folder=ROOT, environ=_environ(kind, ROOT))[0] == 0


def installations(pythons: list[str], names: list[str]) -> Iterator[tuple[str, list[tuple[str, Kind]]]]:
    """Each Python, with the kinds that share an installation of it."""
    rows = [(python, name, KINDS[name]) for name in names for python in pythons[KINDS[name].pythons]]
    for _, group in groupby(sorted(rows, key=_made), key=_made):
        shared = list(group)
        yield shared[0][0], [(name, kind) for _, name, kind in shared]


def _made(row: tuple[str, str, Kind]) -> tuple[object, ...]:
    python, _, kind = row
    return kind.dependencies, kind.form, kind.extras, kind.pip, python


def main() -> None:
    asked = begin(__doc__, pythons=PYTHONS, kinds=list(KINDS))
    pythons = [python for python in asked.asked.pythons if at_hand(python)]
    names = [name for name in asked.asked.kinds if spoken(KINDS[name])]
    missing = sorted({*asked.asked.pythons, *asked.asked.kinds} - {*pythons, *names})
    rows, good = [], True
    with tempfile.TemporaryDirectory() as name:
        sources, made = built(Path(name))
        for python, kinds in installations(pythons, names):
            home = Path(name, "environment")
            code, printed = install(kinds[0][1], python, home, made)
            for which, kind in kinds:
                row, passed = tried(kind, home, sources) if code == 0 else (failed(kind, python, printed), False)
                rows.append([which, *row])
                good &= passed
            must("rm", "-rf", home, folder=sources)
    notes = [f"not at hand: {', '.join(missing)}"] if missing else []
    headings = ("kind", "Python", "dependencies", "form", "extras", "place", *SHOWN, "tests")
    asked.publish("Versions of Python and of dependencies, and places", notes, markdown(headings, rows))
    sys.exit(not good)


if __name__ == "__main__":
    main()
