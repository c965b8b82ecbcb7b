"""What a checkout promises."""

import ast
import hashlib
import importlib
import json
import os
import pkgutil
import re
import shutil
import subprocess
import sys
import tarfile
import types
import zipfile
from pathlib import Path

import pytest
from tests import ROOT
from tests.commands import run
from tests.rows import rows

import allanite
from allanite.cli import VERBS

BIN = Path(sys.executable).parent
MAKE = shutil.which("make")
OF_MAKE = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS", "FILE", "ARGS")
TEXT = (".py", ".md", ".toml", ".txt", ".cff", ".j2", "")


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


def make(*words, folder=ROOT):
    if MAKE is None:
        pytest.skip("no make here")
    surroundings = {k: v for k, v in os.environ.items() if k not in OF_MAKE}
    return subprocess.run([MAKE, *words], cwd=folder, env=surroundings, capture_output=True, text=True, check=False)


def test_constraints_name_no_host_and_cover_the_dependencies():
    text = (ROOT / "constraints.txt").read_text()
    pins = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert "://" not in text
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", pin) for pin in pins)
    pinned = {pin.split("==")[0].lower() for pin in pins}
    wanted = re.findall(r'^  "([A-Za-z0-9_-]+)>=', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert {name.lower() for name in wanted} <= pinned
    assert "allanite" not in pinned


VENDORED = {"plotly-basic.min.js"}  # libraries of the page: it asks nobody else for them


def test_no_machine_paths_and_no_large_files():
    for path in tracked():
        assert path.stat().st_size < 2**20 or path.name in VENDORED, path
        if path.suffix in TEXT and path != Path(__file__).resolve():
            assert not re.search(r"/(root|home|work|tmp)/", path.read_text(encoding="utf-8")), path


def test_the_tests_of_a_change_are_those_of_its_packages():
    import changed

    paths = ("src/allanite/web/store.py", "src/allanite/kernels/sums.py", "docs/plan.md", "LICENSE")
    found = list(changed.selection(paths))
    files = ("tests/conformance/test_kernels.py", "tests/unit/statistics", "tests/stories/test_docs.py")
    assert found == ["tests/web", *files]
    assert all((ROOT / path).exists() for path in found)


@pytest.mark.slow("takes more than half a second")
def test_the_demo_takes_any_file_name(tmp_path):
    """A set-up .venv is stood in for by this test's own."""
    path = tmp_path / "my gyro's $1 file.csv"
    lines = (ROOT / "examples" / "tactical_gyro.csv").read_text(encoding="utf-8").splitlines()[4:2000]
    path.write_text("\n".join(lines), encoding="utf-8")
    name = str(path).replace("$", "$$")
    out, tools = tmp_path / "demo", tmp_path / "bin"
    tools.symlink_to(BIN)  # whose path may have blanks, which .venv/bin has not
    done = make("demo", "-o", ".venv/run", f"BIN={tools}", f"OUT={out}", f"FILE={name}", "ARGS=--channels gz")
    assert done.returncode == 0, done.stderr
    assert "angle random walk" in done.stdout
    assert done.stdout.splitlines()[-2:] == [f"report: {out}/report.html", f"plot: {out}/curve.png"]
    assert min((out / name).stat().st_size for name in ("report.html", "curve.png")) > 10_000


@rows("can, words", [("nothing", "Python 3.11 or later"), ("version", "apt install python3-venv")])
def test_make_says_what_to_install(tmp_path, can, words):
    shutil.copy(ROOT / "Makefile", tmp_path)
    python = tmp_path / "python"
    python.write_text('#!/bin/sh\ncase "$CAN$2" in version*version_info*) exit 0;; *) exit 1;; esac\n')
    python.chmod(0o755)
    done = make(".venv/made", "PYTHON=./python", f"CAN={can}", folder=tmp_path)
    assert done.returncode != 0
    assert words in done.stderr
    assert not (tmp_path / ".venv").exists()


@pytest.mark.slow("takes more than half a second")
def test_the_wheel_of_the_sdist_holds_what_the_package_needs(tmp_path):
    pytest.importorskip("hatchling", reason="the build backend is not installed here")
    import release

    archive, wheel = release.built(tmp_path)
    names = zipfile.ZipFile(wheel).namelist()
    needed = ("py.typed", "reporting/page.html.j2", "planning/datasheets.csv", "cli/__init__.py")
    assert {f"allanite/{name}" for name in needed} <= set(names)
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert not [name for name in names if not name.startswith(("allanite/", "allanite-"))]
    with tarfile.open(archive) as packed:
        inside = {name.partition("/")[2] for name in packed.getnames()}
    assert {"SECURITY.md", "constraints.txt", "tests/conftest.py"} <= inside
    digests = [(hashlib.sha256(path.read_bytes()).hexdigest(), path.name) for path in (archive, wheel)]
    assert release.sums(archive, wheel) == "".join(f"{digest}  {name}\n" for digest, name in digests)


def test_the_bill_of_materials_has_the_library_of_the_page():
    import release

    bare = json.dumps({"metadata": {"component": {"name": "allanite"}}, "components": []})
    bill = json.loads(release.completed(bare, "1.2"))
    assert bill["metadata"]["component"] == {"name": "allanite", "version": "1.2"}
    (plotly,) = bill["components"]
    assert re.fullmatch(r"pkg:npm/plotly\.js-basic-dist-min@\d+\.\d+\.\d+", plotly["purl"])


def test_a_pinned_version_with_an_open_advisory_is_named(tmp_path):
    import advisories

    def advisory(name, *events, **more):
        if events:
            more["ranges"] = [{"type": "ECOSYSTEM", "events": [dict([event]) for event in events]}]
        return {"id": f"X-{name}", "affected": [{"package": {"ecosystem": "PyPI", "name": name}, **more}]}

    known = [
        advisory("A_b", ("introduced", "0"), ("fixed", "2.0"), ("introduced", "2.9")),
        advisory("c", versions=["1.0", "1.1"]),
        advisory("d", ("introduced", "1.0"), ("last_affected", "1.5")),
        # closed, withdrawn, or of another package
        advisory("a-b", ("introduced", "0"), ("fixed", "2.0")),
        advisory("d", ("introduced", "0"), ("last_affected", "1.4.9")),
        advisory("c", versions=["1.0"]) | {"withdrawn": "2026-01-01T00:00:00Z"},
        advisory("unknown", versions=["1.0"]),
    ]
    for k, one in enumerate(known):
        (tmp_path / f"{k}.json").write_text(json.dumps(one))
    (tmp_path / "e.yaml").write_text("id: X-e\naffected: [{package: {ecosystem: PyPI, name: e}, versions: ['3']}]\n")
    pinned = advisories.pins("# what is pinned\na-b==3.0\nC==1.1\nd==1.5\ne==3\n")
    found = advisories.findings(pinned, advisories.advisories(tmp_path))
    assert found == ["a-b 3.0: X-A_b", "c 1.1: X-c", "d 1.5: X-d", "e 3: X-e"]


def test_no_module_is_hidden_by_an_object_of_its_name():
    hidden = set()
    for found in pkgutil.walk_packages(allanite.__path__, "allanite."):
        if not found.name.endswith(("__main__", "hdf5_worker")):
            importlib.import_module(found.name)
            package, _, name = found.name.rpartition(".")
            if not isinstance(vars(sys.modules[package]).get(name), types.ModuleType):
                hidden.add(found.name)
    assert hidden == set()


def test_the_front_door_opens_to_what_the_stub_names_and_nothing_else():
    stub = (ROOT / "src" / "allanite" / "__init__.pyi").read_text(encoding="utf-8")
    rooms = {*re.findall(r"^from \.(?:applications)? import (\w+) as", stub, re.MULTILINE)}
    names = set(re.findall(r"^from \S+ import \w+ as (\w+)$", stub, re.MULTILINE))
    assert len(names) == len([line for line in stub.splitlines() if line.startswith("from ")])
    assert set(dir(allanite)) == names
    assert len(names) <= 75
    assert {name for name in names if isinstance(getattr(allanite, name), types.ModuleType)} == rooms


def test_names_to_build_on_are_there_and_others_are_not():
    from allanite import extending

    assert {name for name in extending.__all__ if not hasattr(extending, name)} == set()
    assert not vars(allanite).keys() & (set(extending.__all__) - set(dir(allanite)))  # the front door is not changed
    assert not hasattr(extending, "identify_all")


def test_every_promise_about_security_names_a_test_that_is_there():
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", (ROOT / "SECURITY.md").read_text("utf-8"))
    assert len(named) > 10
    for path, name in named:
        assert f"def {name}(" in (ROOT / path).read_text("utf-8"), f"{path}::{name}"


def test_every_verb_is_listed_in_one_group_and_its_summary_is_not_cut():
    shown = run("--help").stdout
    assert shown.count("...") == 1  # of the usage
    assert all(shown.count(f"{heading}:") == 1 for heading in {verb.group for verb in VERBS.values()})
    assert [verb for verb in VERBS if f"\n  {verb} " not in shown] == []


def test_a_phrase_of_the_list_is_found(tmp_path):
    import words

    file = tmp_path / "x.py"
    file.write_text('"""The overlapped Allan deviation."""\nx = f"{3} lost readings"  # an honest interval\n')
    said = [text for _, text in words.texts(file)]
    assert sum(bool(re.search(phrase, text)) for phrase in words.BANNED for text in said) == 3


BUDGET = {"lines": 76_591, "files": 0, "names": 55, "circles": 0, "hidden circles": 0}
"""What the package has at most: lines, files above 400 of them, values whose name says little, circles of imports.

Hidden are those that are closed by an import in a function. Each number only falls: lower it with what makes it lower.
"""


@pytest.mark.slow("reads the whole package")
def test_the_package_keeps_its_budget():
    import house

    sizes = house.lines().values()
    closed, hidden = (house.circles(house.imports(inside=inside)) for inside in (False, True))
    counted = {
        "lines": sum(sizes), "files": sum(count > house.LARGE for count in sizes), "names": len(house.vague_names()),
        "circles": len(closed), "hidden circles": len(hidden),
    }  # fmt: skip
    above = {what: count for what, count in counted.items() if count > BUDGET[what]}
    assert above == {}, f"python tools/house.py ROOM shows where; circles: {closed + hidden}"


def test_a_circle_of_imports_and_a_name_that_says_little_are_noticed(monkeypatch):
    import house

    trees = {
        "allanite.a": "from .b import x\nfor one in x:\n    kept, left = one\n", "allanite.b": "import allanite.c",
        "allanite.c": "def f():\n    from . import a\n", "allanite": "if TYPE_CHECKING:\n    from . import a\n",
    }  # fmt: skip
    monkeypatch.setattr(house, "modules", lambda: {name: ast.parse(text) for name, text in trees.items()})
    assert house.circles(house.imports()) == []
    assert house.circles(house.imports(inside=True)) == [["allanite.a", "allanite.b", "allanite.c"]]
    assert house.vague_names() == [("allanite.a", 2, "one"), ("allanite.a", 3, "left")]
