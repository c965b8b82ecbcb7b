"""The committed tables of the benchmarks as pages."""

import re
import shutil
from collections.abc import Iterable
from pathlib import Path

from generate.markdown import table


def benchmark_pages(results: Path, folder: Path) -> None:
    """A page for each table, and their index."""
    folder.mkdir(parents=True, exist_ok=True)
    names = sorted(path.stem for path in results.glob("*.md"))
    for source in results.glob("*.md"):
        shutil.copy(source, folder / source.name)
    (folder / "index.md").write_text("\n".join(_index(results, names)) + "\n", encoding="utf-8")


def _index(results: Path, names: Iterable[str]) -> list[str]:
    rows = []
    for name in names:
        text = (results / f"{name}.md").read_text(encoding="utf-8")
        title, command = re.search(r"^# (.*)", text), re.search(r"`(python benchmarks/\w+\.py)", text)
        rows.append((f"[{title[1] if title else name}]({name}.md)", f"`{command[1]}`" if command else ""))
    return [
        "# Benchmarks", "",
        "What they show: [How well is it known](../../known.md). Each table was written by a script, and names the "
        "commit, the machine, the command and the seeds. A nightly run makes a part of each again.", "",
        *table(("table", "made by"), rows),
        "```{toctree}", ":hidden:", "", *names, "```",
    ]  # fmt: skip
