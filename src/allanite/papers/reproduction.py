"""The numbers of a paper beside those of the files that its commands have written."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from allanite.core.plain import Value
from allanite.core.units import unit_of
from allanite.phrases.phrase import say

from .cells import READ, number
from .paper import AGREES, DIFFERS, DRAWN, Item, Paper


@dataclass(frozen=True, repr=False)
class Compared(Value):
    """An item of a paper, what was found here, and the verdict."""

    # item, claim, paper: where it stands, what is compared, and what the paper prints
    item: str
    claim: str
    paper: str
    here: str  # what was found here
    found: tuple[float, ...]  # the same as numbers
    verdict: str  # one of `paper.VERDICTS`
    why: str
    expected: bool = True  # whether that is the verdict that is expected


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

    def __str__(self) -> str:
        return self.title


def compare(paper: Paper, folder: Path) -> Reproduction:
    """The items of a paper beside the files in a folder, where its commands have run."""
    items = tuple(compared(item, folder) for item in paper.items)
    commands = tuple(f"allanite {command}" for command in paper.commands)
    return Reproduction(
        paper.name, paper.title, paper.source, paper.data, items, paper.captions, str(folder), commands
    )  # fmt: skip


def compared(item: Item, folder: Path) -> Compared:
    """An item beside the files in a folder."""
    places = [place.partition(": ")[::2] for place in item.here]
    scale = unit_of(item.unit).factor if item.unit else 1.0
    found = READ[item.read](*(number(folder / name, cell) / scale for name, cell in places if cell))
    drawn = [name for name, cell in places if not cell]
    for name in drawn:
        (folder / name).stat()  # raises if it was not written
    verdict, expected = _verdict(item, found)
    shown = [item.form.format(*found) if item.form else " ".join(f"{each:.4g}" for each in found)] if found else []
    why = item.why or (say("within {share} %", share=f"{100 * item.tolerance:g}") if item.tolerance else "")
    here = "; ".join([*shown, *drawn])
    return Compared(item.item, item.claim, item.paper, here, tuple(found), verdict, why, expected)


def _verdict(item: Item, found: Sequence[float]) -> tuple[str, bool]:
    """The verdict on an item, and whether it is the expected one."""
    replaced = not item.ours or _near(found, item.ours, 0.01)
    if not item.numbers:
        return item.verdict or DRAWN, replaced
    agrees, wanted = _near(found, item.numbers, item.tolerance), item.verdict or AGREES
    return AGREES if agrees else wanted if wanted != AGREES else DIFFERS, (agrees == (wanted == AGREES)) and replaced


def _near(found: Sequence[float], numbers: Sequence[float], tolerance: float) -> bool:
    return all(
        math.isclose(ours, theirs, rel_tol=tolerance, abs_tol=0.0 if theirs else tolerance)
        for ours, theirs in zip(found, numbers, strict=True)
    )
