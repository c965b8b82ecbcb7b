"""What a checkout promises."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import allanite

ROOT = Path(__file__).resolve().parents[2]


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


def test_constraints_name_no_host_and_cover_the_dependencies():
    text = (ROOT / "constraints.txt").read_text()
    assert "://" not in text
    pinned = {line.split("==")[0].lower() for line in text.splitlines() if "==" in line}
    wanted = re.findall(r'^  "([A-Za-z0-9_-]+)>=', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert {name.lower() for name in wanted} <= pinned


def test_no_machine_paths_and_no_large_files():
    for path in tracked():
        assert path.stat().st_size < 2**20, path
        if path.suffix in (".py", ".md", ".toml", ".txt", ".cff", ".j2", "") and path != Path(__file__).resolve():
            assert not re.search(r"/(root|home|work|tmp)/", path.read_text(encoding="utf-8")), path


def test_the_version_is_one():
    command = [str(Path(sys.executable).with_name("allanite")), "--version"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert allanite.__version__ in said
    assert f"version: {allanite.__version__}" in (ROOT / "CITATION.cff").read_text()


def test_starting_imports_nothing_heavy():
    heavy = ("numba", "scipy", "matplotlib", "pyarrow", "jinja2", "rich")
    for what in ("import allanite", "import allanite.cli"):
        code = f"import sys; {what}; print([m for m in {heavy} if m in sys.modules])"
        said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        assert said.strip() == "[]"


def test_continuous_integration_is_make_test():
    assert "make test" in (ROOT / ".ci" / "run").read_text()
