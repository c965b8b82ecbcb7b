"""A paper: the commands that reproduce it, and its numbers beside those of the files that they write."""

import csv
import io
import json
import math
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

from allanite.core.names import row_alike
from allanite.core.plain import Value
from allanite.core.units import unit_of
from allanite.interpretation.glossary import Word
from allanite.phrases.phrase import say

READ: dict[str, Callable[..., list[float]]] = {
    "": lambda *numbers: list(numbers),
    "ratio": lambda *numbers: [a / b for a, b in zip(numbers[::2], numbers[1::2], strict=True)],
    "ratios": lambda *numbers: [number / numbers[-1] for number in numbers[:-1]],
    "difference": lambda one, other: [one - other], "reduction": lambda after, before: [100 * (1 - after / before)],
    "slope": lambda *numbers: [math.log10(b / a) for a, b in zip(numbers[::2], numbers[1::2], strict=True)],
    "mu": lambda *numbers: [round(2 * slope, 2) + 0.0 for slope in READ["slope"](*numbers)],
    "flatness": lambda late, tau, first: [(late / first) ** 2 * tau],
    "ramp": lambda allan, hadamard, tau: [math.sqrt(2 * (allan**2 - hadamard**2)) / tau],
    "white": lambda allan, tau: [allan * math.sqrt(tau)], "trend": lambda allan, tau: [allan * math.sqrt(2) / tau],
    "walk": lambda hadamard, tau: [hadamard * math.sqrt(6 / tau)],
    "percent": lambda *edf: [100 / math.sqrt(2 * each) for each in edf],
}  # fmt: skip
"""What is made of the numbers of cells: slopes of pairs over a decade (`mu` of the variance), a ramp from two
deviations, the variance times tau over that at 1 s, a coefficient from the deviation at one tau, percent from edf."""


def number(path: Path, cell: str) -> float:
    """The number of a cell in a CSV or JSON file."""
    text = path.read_text("utf-8")
    if cell.startswith("/"):
        value: Any = json.loads(text)
        for key in cell[1:].split("/"):
            value = value[int(key) if isinstance(value, list) else key]
        return float(value)
    rows = list(csv.DictReader(io.StringIO(text)))
    column, _, where = cell.removeprefix("rms ").partition(" @ ")
    if " of " in column:
        share, size, m, column = (word.strip() for word in column.split(" of "))
        return _scatter([float(row[column]) for row in rows], int(m), int(size), float(share))
    wanted = dict(pair.split("=") for pair in where.split(" & ")) if where not in ("", "last") else {}
    cells = [row[column] for row in rows if all(_alike(row[key], value) for key, value in wanted.items())]
    if not cells:
        raise LookupError(f"{path.name} has no row {where}")
    if cell.startswith("rms "):
        return math.hypot(*map(float, cells)) / math.sqrt(len(cells))
    return float(cells[-1 if where == "last" else 0])


def _scatter(numbers: Sequence[float], m: int, size: int, share: float) -> float:
    """A quantile of the standard deviations of `size` means over `m` numbers each."""
    means = [fmean(numbers[at : at + m]) for at in range(0, len(numbers), m)]
    scatters = sorted(stdev(means[at : at + size]) for at in range(0, len(means), size))
    return scatters[round(share * (len(scatters) - 1))]


def _alike(shown: str, wanted: str) -> bool:
    try:
        return math.isclose(float(shown), float(wanted), rel_tol=1e-9)
    except ValueError:
        return shown == wanted


AGREES, DIFFERS, DRAWN = "agrees", "differs", "drawn"  # verdicts that are found
SHOWN, MISSING = "shown", "not built"  # verdicts of rows that hold no number

VERDICTS = {AGREES: say("agrees"), DIFFERS: say("differs"), DRAWN: say("drawn"), "misprint": say("misprint"),
            "not resolved": say("not resolved"), "computed": say("computed"), SHOWN: say("shown"),
            MISSING: say("not built")}  # fmt: skip
"""All of them, as they are shown; the others stand in the file of the paper, each with its reason."""


@dataclass(frozen=True)
class Item:
    """A table, a figure or a claim of a paper."""

    item: str  # where it stands: "Table 3", "Fig. 2", "eq. 5".
    claim: str  # what is compared
    paper: str = ""  # as the paper prints it
    source: str = ""  # what another source prints, and its name, where the paper prints no number: "3139, SP 1065"
    numbers: tuple[float, ...] = ()  # what the paper prints, or else the source, as numbers that are compared
    # where ours stand: "file: cell", one a number. A cell is a column of a CSV file and the row it is read in
    # (``value @ term=N``, ``tau_s @ last``; of all such rows ``rms deviation @ m=1``), or from ``/`` a path into a
    # JSON file. ``0.5 of 24 of 5 of rate`` is the median of the standard deviations of 24 means of 5 rows each. Of a
    # figure, its file alone.
    here: tuple[str, ...] = ()
    tolerance: float = 0.0  # relative; of a number that is zero, absolute
    # numbers that replace those of the paper, within 1 %, or that are computed where it has none
    ours: tuple[float, ...] = ()
    unit: str = ""  # that of ours where the file has SI units
    factor: float = 1.0  # what ours are multiplied with, where the paper has a relative unit
    read: str = ""  # a key of `READ`: what is made of the numbers of the cells
    form: str = ""  # how ours are written, with {} for each number; without it, four digits and the unit
    verdict: str = ""  # one of `VERDICTS` that is expected: without it, that numbers agree and that figures are drawn
    why: str = ""  # the reason of a difference, or what the agreement rests on


SPOKEN = ("item", "claim", "paper", "source", "form", "why")  # texts of an item that another language replaces


@dataclass(frozen=True)
class Paper:
    """What a file says of a paper."""

    # name, title, source: number on the command line, what it is about, authors and journal
    name: str
    title: str
    source: str
    data: str  # what stands in for the paper's records
    commands: tuple[str, ...]  # without the word allanite; they write their files into the current folder
    captions: dict[str, str]  # figures of the page in their order: file -> caption
    items: tuple[Item, ...]
    spoken: dict[str, dict[str, str]]  # language -> what its texts are there
    short: str = ""  # its other name on the command line, and the folder where none is given
    synonyms: tuple[str, ...] = ()  # other names by which it is asked for; they are suggested, not taken
    topics: tuple[str, ...] = ()  # terms and statistics that it is about
    own: tuple[str, ...] = ()  # what applies it to a recording of one's own, without the word allanite
    page: str = ""  # its address

    @property
    def word(self) -> Word:
        """What ``allanite explain`` says of it."""
        return Word(self.title, (self.short, self.name), self.source)

    def within(self, lang: str) -> "Paper":
        """With its texts in another language, as far as the file has it."""
        known = self.spoken.get(lang, {})

        def tr(text: str) -> str:
            return known.get(text, text)

        spoken: list[dict[str, Any]] = [{key: tr(getattr(i, key)) for key in SPOKEN} for i in self.items]
        items = tuple(replace(i, **texts) for i, texts in zip(self.items, spoken, strict=True))
        captions = {name: tr(text) for name, text in self.captions.items()}
        return replace(self, title=tr(self.title), data=tr(self.data), captions=captions, items=items)


_FOLDER = files("allanite.papers")

PAPERS: tuple[str, ...] = tuple(sorted(path.name[:-5] for path in _FOLDER.iterdir() if path.name.endswith(".toml")))
"""Names of the papers."""


def paper(name: str) -> Paper:
    """The paper of this number or short name, in upper case or lower; an unknown one lists them."""
    return row_alike("paper", name, papers())


@cache
def papers() -> dict[str, Paper]:
    """The papers by their numbers and by their short names."""
    rows = [read_paper(name, _FOLDER.joinpath(f"{name}.toml").read_text("utf-8")) for name in PAPERS]
    return {row.name: row for row in rows} | {row.short: row for row in rows}


def read_paper(name: str, text: str) -> Paper:
    """The paper of a file; ``{word}`` in its commands is an entry of its table `words`."""
    data = tomllib.loads(text)
    words = data.pop("words", {})
    commands = [" ".join(command.split()) for command in data.pop("commands")]
    for word, meant in words.items():
        commands = [command.replace(f"{{{word}}}", meant) for command in commands]
    items = tuple(Item(**_tuples(row)) for row in data.pop("items"))
    return Paper(name, commands=tuple(commands), items=items, **{"spoken": {}} | _tuples(data))


def _tuples(row: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}


@dataclass(frozen=True, repr=False)
class Compared(Value):
    """An item of a paper, what was found here, and the verdict."""

    # item, claim, paper, source: where it stands, what is compared, what the paper and another source print
    item: str
    claim: str
    paper: str
    source: str
    here: str  # what was found here
    found: tuple[float, ...]  # the same as numbers
    verdict: str  # one of `paper.VERDICTS`
    why: str
    expected: bool = True  # whether that is the verdict that is expected
    printed: bool = False  # whether numbers are compared, which paper or source print


@dataclass(frozen=True, repr=False)
class Reproduction(Value):
    """A paper beside what was found here."""

    # name, title, source, data: as of `Paper`
    name: str
    title: str
    source: str
    data: str
    items: tuple[Compared, ...]
    figures: dict[str, str]  # file of a figure -> caption
    folder: str  # where the files are
    commands: tuple[str, ...]
    own: tuple[str, ...]  # commands for a recording of one's own

    def __str__(self) -> str:
        return self.title


def compare(paper: Paper, folder: Path) -> Reproduction:
    """The items of a paper beside the files in a folder, where its commands have run."""
    items = tuple(compared(item, folder) for item in paper.items)
    commands, own = (tuple(f"allanite {line}" for line in lines) for lines in (paper.commands, paper.own))
    return Reproduction(paper.name, paper.title, paper.source, paper.data, items, paper.captions, str(folder), commands,
                        own)  # fmt: skip


def compared(item: Item, folder: Path) -> Compared:
    """An item beside the files in a folder."""
    places = [place.partition(": ")[::2] for place in item.here]
    scale = (unit_of(item.unit).factor if item.unit else 1.0) / item.factor
    numbers = READ[item.read](*(number(folder / name, cell) / scale for name, cell in places if cell))
    drawn = [name for name, cell in places if not cell]
    for name in drawn:
        (folder / name).stat()  # raises if it was not written
    verdict, expected = verdict_on(item, numbers)
    shown = item.form.format(*numbers) if item.form else " ".join(f"{each:.4g}" for each in numbers)
    why = item.why or (say("within {share} %", share=f"{100 * item.tolerance:g}") if item.tolerance else "")
    here = "; ".join(filter(None, (shown, *drawn)))
    return Compared(item.item, item.claim, item.paper, item.source, here, tuple(numbers), verdict, why, expected,
                    bool(item.numbers))  # fmt: skip


def verdict_on(item: Item, found: Sequence[float]) -> tuple[str, bool]:
    """The verdict on an item, and whether it is the expected one."""
    replaced = not item.ours or _near(found, item.ours, 0.01)
    if not item.numbers:
        return item.verdict or DRAWN, replaced
    agrees, wanted = _near(found, item.numbers, item.tolerance), item.verdict or AGREES
    return AGREES if agrees else wanted if wanted != AGREES else DIFFERS, (agrees == (wanted == AGREES)) and replaced


def _near(found: Sequence[float], numbers: Sequence[float], tolerance: float) -> bool:
    pairs = zip(found, numbers, strict=True)
    return all(abs(ours - theirs) <= tolerance * (abs(theirs) or 1.0) for ours, theirs in pairs)
