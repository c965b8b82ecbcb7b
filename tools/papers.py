"""Figures and tables of the pages on papers: ``python tools/papers.py [NAME ...]`` runs the examples."""

import re
import shutil
import sys
import tempfile
from pathlib import Path

from click.testing import CliRunner

from allanite.cli import main
from allanite.papers.paper import PAPERS, VERDICTS, Reproduction, compare, paper
from allanite.reporting.digits import printable
from allanite.reporting.language import speaking, tr
from allanite.reporting.views.papers import HEADS

DOCS = Path(__file__).parents[1] / "docs" / "papers"


def renew(name: str) -> None:
    """Run the example of a paper; write its figures, and its table in English and in the languages of its file."""
    with tempfile.TemporaryDirectory() as made:
        done = CliRunner().invoke(main, ["example", name, made])
        if done.exit_code:
            sys.exit(done.output)
        where = DOCS / name
        where.mkdir(parents=True, exist_ok=True)
        for figure in paper(name).captions:
            shutil.copy(Path(made, figure), where / figure)
        for lang in ("en", *paper(name).spoken):
            (where / f"table_{lang}.md").write_text(table(compare(paper(name).within(lang), Path(made)), lang), "utf-8")


def table(found: Reproduction, lang: str) -> str:
    """The items of a paper as a table of a page."""
    with speaking(lang):
        heads = [tr(head) for head in HEADS]
        rows = [
            [*map(written, (i.item, i.claim, i.paper, i.source, i.here)), whole(written(tr(VERDICTS[i.verdict]))),
             written(tr(i.why))] for i in found.items
        ]  # fmt: skip
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def whole(text: str) -> str:
    """A text that a narrow column does not break between Chinese letters."""
    return re.sub(r"(?<=[\u4e00-\u9fff])(?=[\u4e00-\u9fff])", "\u2060", text)


def written(cell: str) -> str:
    """A cell in Markdown: signs as on a page, options as code."""
    return re.sub(r"(--[a-z][\w-]*)", r"`\1`", printable(cell)).replace("|", r"\|")


if __name__ == "__main__":
    for each in sys.argv[1:] or PAPERS:
        renew(each)
