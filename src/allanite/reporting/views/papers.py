"""A paper beside what was found here: table, figure and claim, one after the other."""

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from allanite.papers.paper import (  # isort: skip
    AGREES, DIFFERS, DRAWN, MISSING, PAPERS, SHOWN, VERDICTS, Compared, Reproduction, paper
)  # fmt: skip
from allanite.phrases.phrase import Phrase, join, say, say_count
from allanite.reporting.first import DETAILS, First
from allanite.reporting.matplotlib_svg import stored
from allanite.reporting.sheet import Code, Column, Drawing, Face, Mark, Note, Part, Table, one_sheet

from . import Rows, view

BRAND = say("a paper beside what is found here")

OWN, PAGE = say("your recording"), say("its page")

MARKS: dict[str, Mark] = {AGREES: "good", DIFFERS: "weak"}  # marks of verdicts; the others have none
HEADS = (say("in the paper"), "", say("paper"), say("other source"), say("here"), say("verdict"), say("why"))
COUNTED = (say("{agree} of {count} printed numbers agree"), say("{agree} of {count} numbers of other sources agree"))
PLACES = {SHOWN: 1, MISSING: 1, AGREES: 2, DRAWN: 2}  # place of an item among those shown, by its verdict
MAX_ITEMS = 13  # items on the first screen


def about(*names: str) -> list[tuple[str, str]]:
    """What next after papers of these names, and after terms and statistics that papers are about."""
    rows = [row for row in map(paper, PAPERS) if not {row.short, *row.topics}.isdisjoint(names)]
    own = [(f"allanite {line}", OWN) for row in rows if row.short in names and row.name in names for line in row.own]
    return [*((f"allanite example {row.short}", BRAND) for row in rows), *own, *((row.page, PAGE) for row in rows)]


def first_of_paper(value: Reproduction, _: float) -> First:
    """How many items agree, and those that do not."""
    parts = [
        say(text, agree=sum(item.verdict == AGREES for item in items), count=len(items))
        for by, text in enumerate(COUNTED) if (items := [i for i in value.items if i.printed and bool(i.source) == by])
    ]  # fmt: skip
    if drawn := sum(item.verdict == DRAWN for item in value.items):
        parts.append(say_count(drawn, "{count} figure drawn", "{count} figures drawn"))
    verdict = join("; ", parts)
    told = sorted(value.items, key=lambda item: (item.expected, PLACES.get(item.verdict, 0)))
    own = ((command, OWN) for command in value.own[:1])
    after = ((f"{Path(value.folder, 'page.html')}", say("all of them, with the figures")), DETAILS, *own)
    return First(value.title, verdict, [_brief(told[:MAX_ITEMS])], after=after)


@view(rows=lambda value, _: _rows(value), first=first_of_paper)
def paper_view(value: Reproduction, _: float) -> Face:
    """Every item of a paper beside what was found, its figures, and the commands."""
    figures = [
        Drawing(partial(stored, Path(value.folder, name)), caption, caption) for name, caption in value.figures.items()
    ]
    parts: list[Part] = [
        Note(value.data), _table(value.items), *figures, Code("\n".join(value.commands), say("commands")),
    ]  # fmt: skip
    return one_sheet(value.title, BRAND, value.name, parts, about=(say("source: {source}", source=value.source),))


def _brief(items: Sequence[Compared]) -> Table:
    heads = [Column("", "name"), *(Column(text, "text") for text in (say("paper or source"), *HEADS[4:]))]
    return Table(heads, [brief(item) for item in items], marks=_marks(items))


def brief(item: Compared) -> list[str]:
    """An item in a line: of the reason its first clause."""
    clause = "" if isinstance(item.why, Phrase) else re.split("[:;] ", item.why)[0]
    where = ": ".join((item.item, item.claim))
    return [where, item.paper or item.source, item.here, VERDICTS[item.verdict], clause]


def _table(items: Sequence[Compared]) -> Table:
    heads = [Column(head, "text" if at else "name") for at, head in enumerate(HEADS)]
    rows = [[i.item, i.claim, i.paper, i.source, i.here, VERDICTS[i.verdict], i.why] for i in items]
    return Table(heads, rows, marks=_marks(items), most=len(rows))


def _marks(items: Sequence[Compared]) -> list[Mark]:
    return [MARKS.get(item.verdict, "") if item.expected else "alarm" for item in items]


def _rows(value: Reproduction) -> Rows:
    heads = ["item", "claim", "paper", "source", "here", "verdict", "why"]
    return heads, [[getattr(item, head) for head in heads] for item in value.items]
