"""Sensors times disturbances times lengths: how often the whole answer to a bare record is right, and what else it is.

    python benchmarks/grid.py make [--rounds N] [--write benchmarks/results/grid.md]
    python benchmarks/grid.py again [--share 0.02] [--night 20270101]

`make` adds rounds to benchmarks/results/grid.csv, a record of each cell in each, until there are N: a run that was
broken off goes on where it was, and begins again if the code has changed. Records come from judge.py; seeds are the
CRC-32 of the cell's name and the number of the record. `again` makes new records, beyond those counted, of some of
the cells, chosen by the date, and ends with exit code 1 if a share of an answer has moved by more than its error.
"""

from table import RESULTS, ROOMS, Row, begin, moved, section, unchanged

import csv
import math
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import product
from multiprocessing import Pool
from typing import Any
from zlib import crc32

import numpy as np
from scipy.special import bdtrc

import allanite as al
from shapes import DISTURBANCES, REASONS, SENSORS, TERMS, record_of

LENGTHS = (2**12, 2**14, 2**16)
COUNTS = RESULTS / "grid.csv"
LEVEL, SURE = 0.95, 0.9973
"""Level of the limits whose coverage is counted, and of those (three standard errors) beyond which a claim is wrong."""

ASSERTED = frozenset(
    ("lines", "wave", "steps", "warm-up", "popcorn", "vibration", "heavy tails", "held", "no dither", "level", "slope")
)
"""Findings that assert something of a record; others (that it is short, where terms can be had) assert nothing."""


CODES = {
    "in": "claimed, its 95 % interval holds the truth", "edge": "claimed, only its 99.7 % interval does",
    "wrong": "claimed, the truth is outside of both", "low": "not claimed, though present, its 95 % limit holds",
    "miss": "not claimed, its limit does not hold", "refused": "present, and no number is given",
    "false": "claimed, though absent", "none": "absent, not claimed", "either": "nobody can tell",
    "upper": "present, its one-sided 95 % limit holds, claimed or not",
}  # fmt: skip
"""What may be said of a term."""

VERDICTS = {
    "right": "every claim holds, and no sentence says what is not so",
    "refused": "the record is refused with a reason: no model explains it",
    "wrong": "a term that is there is claimed with a 99.7 % interval that does not hold it",
    "false": "a term is claimed that is not there",
    "misleading": "the terms are right, a sentence is not",
}
"""What may be said of an answer, the first that holds from the second on, else it is right."""


def codes_of(fit: Any, symbol: str, truth: float | None) -> list[str]:
    """What is said of a term."""
    estimate = next((e for e in fit if e.symbol == symbol), None)
    if truth is None:
        return ["either"]
    claimed = estimate is not None and estimate.claimed
    if truth == 0.0:
        return ["false" if claimed else "none"]
    if estimate is None or estimate.status in ("not valid", "not observable"):
        return ["low" if symbol == "GM" else "refused"]  # noise of a given shape is not bounded unless asked for
    size = math.radians(truth)
    (low, high), (lowest, highest) = estimate.interval(LEVEL), estimate.interval(SURE)
    upper = ["upper"] if estimate.upper is not None and size <= estimate.upper else []
    if not claimed:
        return ["low" if estimate.upper is None or size <= estimate.upper else "miss", *upper]
    return ["in" if low <= size <= high else "edge" if lowest <= size <= highest else "wrong", *upper]


def answer(job: tuple[str, str, int, int]) -> tuple[str, dict[str, list[str]], list[str]]:
    """Verdict, codes of the terms and sentences that are not so, of a record as the bare command analyzes it."""
    sensor, disturbance, n, number = job
    rng = np.random.default_rng((crc32(f"{sensor}/{disturbance}/{n}".encode()), number))
    record, truth = record_of(sensor, disturbance, n, rng)
    channel = al.analyze(record).channels[0]
    fit = channel.fit
    if fit is None or fit.validity == "unexplained":
        return "refused", {}, []
    names = {f.name for f in (*channel.warnings, *fit.findings)} | ({"lines"} if fit.lines else set())
    misleading = sorted((names & ASSERTED) - DISTURBANCES[disturbance].names)
    codes = {symbol: codes_of(fit, symbol, truth[symbol]) for symbol in TERMS}
    every = {code for each in codes.values() for code in each}
    verdict = next((v for v in ("wrong", "false") if v in every), "misleading" if misleading else "right")
    return verdict, codes, misleading


@dataclass
class Cell:
    """What is counted of a cell."""

    name: tuple[str, str, int]
    records: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    codes: Counter[str] = field(default_factory=Counter)  # term and code
    names: Counter[str] = field(default_factory=Counter)

    def add(self, verdict: str, codes: dict[str, list[str]], misleading: list[str]) -> None:
        """Count an answer."""
        self.records += 1
        self.verdicts[verdict] += 1
        self.codes.update(f"{term} {code}" for term, each in codes.items() for code in each)
        self.names.update(misleading)

    def shares(self) -> Iterator[tuple[str, int]]:
        """What may move: verdicts, and claims of terms that are absent."""
        yield from ((v, self.verdicts[v]) for v in VERDICTS)
        yield from ((f"{t} false", self.codes[f"{t} false"]) for t in TERMS)


def _text(counts: Counter[str]) -> str:
    return "; ".join(f"{key} {number}" for key, number in sorted(counts.items()))


def _counts(text: str) -> Counter[str]:
    return Counter({key: int(number) for key, _, number in (part.rpartition(" ") for part in text.split("; ") if part)})


CELLS = list(product(SENSORS, DISTURBANCES, LENGTHS))


def read_counts(commit: str) -> list[Cell]:
    """The cells with what was counted; nothing if there is no file, or, for counts of a commit, it is of other code."""
    if not COUNTS.exists():
        return [Cell(name) for name in CELLS]
    stamp, *lines = COUNTS.read_text("utf-8").splitlines()
    if commit and not unchanged(stamp.removeprefix("# commit "), ROOMS["grid"]):
        print(f"begun again: {COUNTS.name} has counts of {stamp[2:]}, and the code has changed", file=sys.stderr)
        return [Cell(name) for name in CELLS]
    rows = {(r[0], r[1], int(r[2])): r[3:] for r in csv.reader(lines[1:])}
    return [Cell(name, int(r[0]), *map(_counts, r[1:])) for name, r in ((n, rows[n]) for n in CELLS)]


def write_counts(cells: Iterable[Cell], commit: str) -> None:
    """Write what was counted."""
    with COUNTS.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# commit {commit}\n")
        out = csv.writer(file, lineterminator="\n")
        out.writerow(("sensor", "disturbance", "samples", "records", "verdicts", "terms", "misleading"))
        out.writerows((*c.name, c.records, _text(c.verdicts), _text(c.codes), _text(c.names)) for c in cells)


def make(cells: list[Cell], rounds: int, commit: str) -> None:
    """Add rounds until each cell has so many records; each is written when it is complete."""
    with Pool() as pool:
        for number in range(rounds):
            due = [cell for cell in cells if cell.records == number]
            for cell, made in zip(due, pool.imap(answer, [(*c.name, number) for c in due], chunksize=4), strict=True):
                cell.add(*made)
            if due:
                write_counts(cells, commit)


def again(cells: list[Cell], share: float, night: int) -> int:
    """Make new records of some cells, and print what has moved; how many."""
    rng = np.random.default_rng(night)
    chosen = [cells[i] for i in sorted(rng.choice(len(cells), max(1, round(share * len(cells))), replace=False))]
    count = 0
    with Pool() as pool:
        for old in chosen:
            new = Cell(old.name)
            first = 10**6 + night % 10**6 * 1000  # of the records that no table counts
            for made in pool.imap(answer, [(*old.name, first + i) for i in range(old.records)], chunksize=4):
                new.add(*made)
            for (what, a), (_, b) in zip(old.shares(), new.shares(), strict=True):
                if moved(a, old.records, b, new.records):
                    count += 1
                    print(f"moved: {', '.join(map(str, old.name))}: {what} {a} of {old.records}, now {b}")
    print(f"{len(chosen)} cells made again, {count} shares moved")
    return count


def percent(count: int, of: int) -> str:
    """A share, %."""
    return f"{100 * count / of:.1f}" if of else "-"


def verdicts_row(label: Iterable[object], cells: Iterable[Cell]) -> Row:
    """Records, and the share of each verdict."""
    total, records = Counter[str](), 0
    for cell in cells:
        total.update(cell.verdicts)
        records += cell.records
    return (*map(str, label), str(records), *(percent(total[v], records) for v in VERDICTS))


def term_row(term: str, cells: list[Cell]) -> Row:
    """How a term fares where it is present, and how often it is claimed where it is not."""
    total = sum((cell.codes for cell in cells), Counter[str]())
    n = {code: total[f"{term} {code}"] for code in CODES}
    claimed = n["in"] + n["edge"] + n["wrong"]
    known = claimed + n["low"] + n["miss"]
    bounded = known if term != "GM" else 0
    return (
        term, str(known + n["refused"]), percent(claimed, known + n["refused"]),
        percent(n["in"], claimed), percent(n["in"] + n["low"], bounded), percent(n["wrong"], claimed),
        percent(n["upper"], bounded),
        percent(n["low"], n["low"] + n["miss"] if term != "GM" else 0),
        percent(n["refused"], known + n["refused"]), percent(n["false"], n["false"] + n["none"]),
    )  # fmt: skip


def reasons(cell: Cell) -> str:
    """Which claims are wrong or false, and which sentences are misleading."""
    codes = {key: count for key, count in cell.codes.items() if key.split()[1] in ("wrong", "false")}
    return _text(Counter(codes) + cell.names)


WRONG, FALSE = 0.06, 0.06
"""Shares of wrong answers and of false claims above which a cell is named."""

RATES = 0.023, 0.003  # of an absent term that is claimed (docs/derivations.md), of a truth beyond 99.7 % limits


def why(cell: Cell) -> str:
    """Why terms are so often wrong, or claimed though they are not there, or by what chance without a cause."""
    causes = [REASONS[name] for name in cell.name[:2] if name in REASONS]
    counts = {term: cell.codes[f"{term} false"] + cell.codes[f"{term} wrong"] for term in TERMS}
    often = [term for term, count in counts.items() if count > FALSE * cell.records]
    known = {text: None for term in often for terms, text in causes if term in terms}
    left = [term for term in often if not any(term in terms for terms, _ in causes)]
    chances = {term: bdtrc(counts[term] - 1, cell.records, RATES[cell.codes[f"{term} wrong"] > 0]) for term in left}
    return "; ".join([*known, *(f"{term}: by chance {100 * p:.2g} %" for term, p in chances.items())])


def named_cells(cells: list[Cell]) -> Iterator[Row]:
    """The cells that answer wrongly, or claim a term falsely, more often than they should; the worst first."""

    def worst(cell: Cell) -> float:
        false = max(cell.codes[f"{term} false"] for term in TERMS)
        return max(cell.verdicts["wrong"] / WRONG, false / FALSE) / max(cell.records, 1)

    for cell in sorted(cells, key=worst, reverse=True):
        if worst(cell) > 1:
            yield (*map(str, cell.name), *verdicts_row((), [cell])[1:], reasons(cell), why(cell))


def tables(cells: list[Cell]) -> list[str]:
    """The page."""
    heads = ("records", *(f"{v} %" for v in VERDICTS))
    groups = {"Overall": (2, "samples", LENGTHS), "By disturbance": (1, "disturbance", DISTURBANCES),
              "By sensor": (0, "sensor", SENSORS)}  # fmt: skip
    body = []
    for title, (place, head, names) in groups.items():
        rows = [verdicts_row([name], [c for c in cells if c.name[place] == name]) for name in names]
        body += section(title, (head, *heads), rows + [verdicts_row(["all"], cells)] * (place == 2))
    body += section(
        "Terms",
        ("term", "present", "claimed where present %", "covers %", "interval or limit holds %", "wrong %",
         "upper limit holds %", "limit holds where not claimed %", "refused %", "claimed where absent %"),
        [term_row(term, cells) for term in TERMS],
    )  # fmt: skip
    return body + section(
        "Worst cells", ("sensor", "disturbance", "samples", *heads[1:], "what", "why"), named_cells(cells),
        f"Of {len(CELLS)} cells those with more than {100 * WRONG:.0f} % wrong or {100 * FALSE:.0f} % false answers of "
        f"a term, the cause, or the chance of so many at {100 * RATES[0]:.1f} % false, {100 * RATES[1]:.1f} % wrong.",
    )  # fmt: skip


def main() -> int:
    """Make the counts and their page, or a part of them again."""
    run = begin(__doc__ or "", way=("make", "again"), rounds=100, share=0.02, night=20270101)
    asked = run.asked
    if asked.way == "again":
        return int(again(read_counts(""), asked.share, asked.night) > 0)
    cells = read_counts(run.commit)
    make(cells, asked.rounds, run.commit)
    told = (f"{what}: {meaning}" for what, meaning in VERDICTS.items())
    run.publish("Sensors, disturbances, lengths", (NOTE, *told), tables(cells))
    return 0


NOTE = (
    "seeds: the CRC-32 of `SENSOR/DISTURBANCE/SAMPLES`, and the number of the record, from 0; 100 Hz; records of a "
    "simulator of its own (benchmarks/judge.py), analyzed as the bare command does; standard error of a share p of n "
    "records: sqrt(p (1 - p) / n)"
)

if __name__ == "__main__":
    raise SystemExit(main())
