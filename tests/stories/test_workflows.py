"""The workflows of the repository: their steps are those of the Makefile, and what they use is pinned."""

import re

import yaml
from tests import ROOT
from tests.rows import rows

FILES = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def steps(path):
    for job in yaml.safe_load(path.read_text("utf-8"))["jobs"].values():
        yield from job.get("steps", [job])


@rows("path", FILES, ids=lambda path: path.stem)
def test_a_workflow_runs_what_exists_and_uses_what_is_pinned(path):
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    for step in steps(path):
        for name in re.findall(r"^make ([a-z-]+)", step.get("run", ""), re.MULTILINE):
            assert name in targets, name
        for script in re.findall(r"^(\.ci/\w+)", step.get("run", "")):
            assert (ROOT / script).is_file()
        used = step.get("uses", "./")
        assert used.startswith("./") or re.search(r"@[0-9a-f]{40}$", used), used
        if used.startswith("./.github"):
            assert (ROOT / used).is_file()
    assert yaml.safe_load(path.read_text("utf-8"))["permissions"] == {"contents": "read"} or path.stem == "docs"
