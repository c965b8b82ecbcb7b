"""What a release says of itself, its packages and its workflows: versions, dates, dependencies, changes."""

import re
import tomllib
from datetime import date

import yaml
from tests import ROOT
from tests.rows import refused, rows

import allanite
import changes
from allanite.cli import VERBS

LOG = changes.LOG.read_text("utf-8")
DAY = date(2027, 1, 2)
BEGUN = "# Changelog\n\nWords.\n\n## 1.0 (2026-12-01)\n\nFirst.\n\n### Read\n\n- A.\n\n### Draw\n\n- B.\n"


def test_the_version_is_the_same_everywhere():
    (released,) = re.findall(rf"^## {re.escape(allanite.__version__)} \((.*)\)$", LOG, re.MULTILINE)
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text("utf-8"))
    assert (cited["version"], str(cited["date-released"])) == (allanite.__version__, released)
    assert recipe["context"]["version"] == allanite.__version__
    assert f"Status: {allanite.__version__}" in (ROOT / "README.md").read_text("utf-8")


def test_the_changelog_is_short_and_by_job():
    first = LOG.split("\n## ")[1]
    assert len(first.splitlines()) <= 80
    assert re.search(r"unreleased", LOG, re.IGNORECASE) is None
    assert set(re.findall(r"`allanite (\w+)", LOG)) == set(VERBS)


def test_every_fragment_is_taken():
    texts = [path.read_text("utf-8") for path in changes.fragments()]
    grown = changes.joined(LOG, texts, allanite.__version__, DAY)
    assert all(text.split("\n\n", 1)[1] in grown for text in texts)


@rows("version, texts, expected", [
    ("1.0", ["### Read\n\n- C\n  D.\n"], BEGUN.replace("- A.\n", "- A.\n- C\n  D.\n")),
    ("1.0", ["### New\n\n- C.\n", "### Draw\n\n- D.\n"], f"{BEGUN}- D.\n\n### New\n\n- C.\n"),
    ("1.1", ["### Read\n\n- C.\n"], BEGUN.replace("## 1.0", "## 1.1 (2027-01-02)\n\n### Read\n\n- C.\n\n## 1.0")),
    ("1.0", [], BEGUN),
])  # fmt: skip
def test_fragments_join_the_section_of_the_version(version, texts, expected):
    assert changes.joined(BEGUN, texts, version, DAY) == expected


@rows("text", ["- C.\n", "### Read\n- C.\n", "### Read\n\nC.\n", ""])
def test_a_fragment_of_another_form_is_refused(text):
    refused(ValueError, "a fragment is", lambda: changes.joined(BEGUN, [text], "1.0", DAY))


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
CALLED = {"matplotlib": "matplotlib-base"}  # packages that conda knows by another name


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


@rows("path", sorted((ROOT / ".github" / "workflows").glob("*.yml")), ids=lambda path: path.stem)
def test_a_workflow_runs_what_exists_and_uses_what_is_pinned(path):
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    workflow = yaml.safe_load(path.read_text("utf-8"))
    for step in (step for job in workflow["jobs"].values() for step in job.get("steps", [job])):
        for name in re.findall(r"^make ([a-z-]+)", step.get("run", ""), re.MULTILINE):
            assert name in targets, name
        for script in re.findall(r"^(\.ci/\w+)", step.get("run", "")):
            assert (ROOT / script).is_file()
        used = step.get("uses", "./")
        assert used.startswith("./") or re.search(r"@[0-9a-f]{40}$", used), used
        if used.startswith("./.github"):
            assert (ROOT / used).is_file()
    assert workflow["permissions"] == {"contents": "read"} or path.stem == "docs"
