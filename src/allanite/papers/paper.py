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
    """A table, a figure or a claim of a paper.

    Attributes
    ----------
    item : str
        Where it stands: "Table 3", "Fig. 2", "eq. 5".
    claim : str
        What is compared.
    paper : str
        As the paper prints it.
    numbers : tuple of float
        The same as numbers, where they are compared.
    here : tuple of str
        Where ours stand: "file: cell", one a number. A cell is a column of a CSV file and the row it is read in
        (``value @ term=N``, ``tau_s @ last``), or from ``/`` a path into a JSON file. Of a figure, its file alone.
    tolerance : float
        Relative; of a number that is zero, absolute.
    ours : tuple of float
        Numbers that replace those of the paper, within 1 %, or that are computed where it has none.
    unit : str
        That of ours where the file has SI units.
    read : str
        A key of `cells.READ`: what is made of the numbers of the cells.
    form : str
        How ours are written, with {} for each number; without it, four digits and the unit.
    verdict : str
        One of `VERDICTS` that is expected: without it, that numbers agree and that figures are drawn.
    why : str
        The reason of a difference, or what the agreement rests on.
    """

    item: str
    claim: str
    paper: str
    numbers: tuple[float, ...] = ()
    here: tuple[str, ...] = ()
    tolerance: float = 0.0
    ours: tuple[float, ...] = ()
    unit: str = ""
    read: str = ""
    form: str = ""
    verdict: str = ""
    why: str = ""


@dataclass(frozen=True)
class Paper:
    """What a file says of a paper.

    Attributes
    ----------
    name, title, source : str
        Name on the command line, what it is about, authors and journal.
    data : str
        What stands in for the paper's records.
    commands : tuple of str
        Without the word allanite; they write their files into the current folder.
    captions : dict
        Figures of the page in their order: file -> caption.
    items : tuple of Item
    spoken : dict
        Language -> what its texts are there.
    """

    name: str
    title: str
    source: str
    data: str
    commands: tuple[str, ...]
    captions: dict[str, str]
    items: tuple[Item, ...]
    spoken: dict[str, dict[str, str]]

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

    Raises
    ------
    UsageError
        There is none.

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
