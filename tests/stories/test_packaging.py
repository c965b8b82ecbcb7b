"""The files of other package managers say what pyproject.toml says."""

import re
import tomllib

import yaml
from tests import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
CALLED = {"matplotlib": "matplotlib-base"}
"""Packages that conda knows by another name."""


def test_the_conda_recipe_has_the_dependencies_of_the_project():
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text("utf-8"))
    wanted = [re.match(r"([\w-]+)(>=[\d.]+)", line).groups() for line in PROJECT["project"]["dependencies"]]
    _, *run = recipe["requirements"]["run"]
    assert run == [f"{CALLED.get(name, name)} {bound}" for name, bound in wanted]
    assert recipe["requirements"]["run"][0] == f"python {PROJECT['project']['requires-python']}"
    assert PROJECT["build-system"]["requires"][0].replace("hatchling", "hatchling ") in recipe["requirements"]["host"]


def test_the_container_copies_what_exists():
    text = (ROOT / "packaging" / "Containerfile").read_text("utf-8")
    for line in re.findall(r"^COPY (?!--from)(?:--chown=\S+ )?(.+)$", text, re.MULTILINE):
        *sources, _ = line.split()
        assert all((ROOT / source).exists() for source in sources), line
    assert "[all]" in text


def test_the_article_cites_what_its_bibliography_has():
    folder = ROOT / "paper"
    cited = set(re.findall(r"@(\w+)", (folder / "paper.md").read_text("utf-8").split("---", 2)[2]))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", (folder / "paper.bib").read_text("utf-8"), re.MULTILINE))
