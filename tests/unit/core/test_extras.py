"""What is missing, and the command that installs it into this environment."""

import re
import tomllib

import pytest
from tests import ROOT
from tests.rows import rows

from allanite.core.errors import SOURCE, UsageError, cure, demand_extra, requirements

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]


@rows("extra", sorted(set(EXTRAS) - {"all", "dev", "test", "docs", "release"}))
def test_requirements_are_those_of_the_project(extra):
    assert requirements(extra) == [re.match(r"[\w.-]+", line)[0].lower() for line in EXTRAS[extra]]
    assert re.search(rf"\b{extra}\b", EXTRAS["all"][0])


@rows("folder, made, typed", [
    (".venv", "home = /usr/bin\n", "pip install fastapi uvicorn"),
    (".venv", "home = /usr/bin\nuv = 0.5.1\n", "uv pip install fastapi uvicorn"),
    ("uv/tools/allanite", "uv = 0.5.1\n", "uv tool install allanite -w fastapi,uvicorn"),
    ("uv/archive-v0/d8doDpq", "uv = 0.5.1\n", f"uvx -w fastapi,uvicorn --from {SOURCE} allanite"),
    ("pipx/venvs/allanite", "home = /usr/bin\n", "pipx inject allanite fastapi uvicorn"),
    ("pipx/a184b18", "home = /usr/bin\n", f"pipx run --with fastapi --with uvicorn --spec {SOURCE} allanite"),
])  # fmt: skip
def test_the_command_is_that_of_the_program_that_made_the_environment(tmp_path, folder, made, typed):
    prefix = tmp_path / folder
    prefix.mkdir(parents=True)
    (prefix / "pyvenv.cfg").write_text(made, "utf-8")
    assert cure(["fastapi", "uvicorn"], prefix) == typed


def test_what_is_missing_is_named():
    demand_extra("hdf5", "json")
    with pytest.raises(UsageError, match=r"the page needs fastapi and uvicorn, .*pip install fast"):
        demand_extra("web", "no_such_module", what="the page")
