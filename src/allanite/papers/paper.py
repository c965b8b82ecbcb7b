"""A paper: the commands that reproduce it, and a row for each of its tables, figures and claims."""

import tomllib
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from typing import Any

from allanite.core.names import demand_name
from allanite.phrases.phrase import say

AGREES, DIFFERS, DRAWN = "agrees", "differs", "drawn"
"""Verdicts that are found."""

VERDICTS = {
    AGREES: say("agrees"), DIFFERS: say("differs"), DRAWN: say("drawn"), "misprint": say("misprint"),
    "not resolved": say("not resolved"), "not built": say("not built"), "computed": say("computed"),
    "present": say("present"),
}  # fmt: skip
"""All of them, as they are shown; the others stand in the file of the paper, each with its reason."""


@dataclass(frozen=True)
class Item:
    """A table, a figure or a claim of a paper."""

    item: str  # where it stands: "Table 3", "Fig. 2", "eq. 5".
    claim: str  # what is compared
    paper: str  # as the paper prints it
    numbers: tuple[float, ...] = ()  # the same as numbers, where they are compared
    # where ours stand: "file: cell", one a number. A cell is a column of a CSV file and the row it is read in
    # (``value @ term=N``, ``tau_s @ last``), or from ``/`` a path into a JSON file. Of a figure, its file alone.
    here: tuple[str, ...] = ()
    tolerance: float = 0.0  # relative; of a number that is zero, absolute
    # numbers that replace those of the paper, within 1 %, or that are computed where it has none
    ours: tuple[float, ...] = ()
    unit: str = ""  # that of ours where the file has SI units
    read: str = ""  # a key of `cells.READ`: what is made of the numbers of the cells
    form: str = ""  # how ours are written, with {} for each number; without it, four digits and the unit
    verdict: str = ""  # one of `VERDICTS` that is expected: without it, that numbers agree and that figures are drawn
    why: str = ""  # the reason of a difference, or what the agreement rests on


@dataclass(frozen=True)
class Paper:
    """What a file says of a paper."""

    # name, title, source: name on the command line, what it is about, authors and journal
    name: str
    title: str
    source: str
    data: str  # what stands in for the paper's records
    commands: tuple[str, ...]  # without the word allanite; they write their files into the current folder
    captions: dict[str, str]  # figures of the page in their order: file -> caption
    items: tuple[Item, ...]
    spoken: dict[str, dict[str, str]]  # language -> what its texts are there

    def within(self, lang: str) -> "Paper":
        """With its texts in another language, as far as the file has it."""
        known = self.spoken.get(lang, {})

        def tr(text: str) -> str:
            return known.get(text, text)

        items = tuple(
            replace(i, item=tr(i.item), claim=tr(i.claim), paper=tr(i.paper), form=tr(i.form), why=tr(i.why))
            for i in self.items
        )
        captions = {name: tr(text) for name, text in self.captions.items()}
        return replace(self, title=tr(self.title), data=tr(self.data), captions=captions, items=items)


_FOLDER = files("allanite.papers")

PAPERS: tuple[str, ...] = tuple(
    sorted(path.name.removesuffix(".toml") for path in _FOLDER.iterdir() if path.name.endswith(".toml"))
)
"""Names of the papers."""


def paper(name: str) -> Paper:
    """The paper of this name.

    Examples
    --------
    >>> paper("003").title
    'rate of a laser gyro in two minutes'
    """
    demand_name("paper", name, PAPERS)
    return read_paper(name, _FOLDER.joinpath(f"{name}.toml").read_text("utf-8"))


def read_paper(name: str, text: str) -> Paper:
    """The paper of a file; ``{word}`` in its commands is an entry of its table `words`."""
    data = tomllib.loads(text)
    words = data.pop("words", {})
    commands = [" ".join(command.split()) for command in data.pop("commands")]
    for word, meant in words.items():
        commands = [command.replace(f"{{{word}}}", meant) for command in commands]
    items = tuple(_item(row) for row in data.pop("items"))
    spoken = data.pop("spoken", {})
    return Paper(name, commands=tuple(commands), items=items, spoken=spoken, **data)


def _item(row: dict[str, Any]) -> Item:
    lists = {f.name: tuple(row[f.name]) for f in fields(Item) if isinstance(row.get(f.name), list)}
    return Item(**row | lists)
