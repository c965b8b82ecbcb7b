"""Every committed table says how it was made, by a command that its script takes, and is whole.

What pages do not have in common stands in the tables of exceptions, which must be those found.
"""

import table

import importlib
import re
import shlex
import sys
from pathlib import Path

import pytest
from tests import ROOT

PAGES = {path.name: table.read(path.name) for path in sorted(table.RESULTS.glob("*.md"))}

SAID = {
    "commit": r"^- commit [0-9a-f]{7}, ",
    "date": r"^- commit .*, \d{4}-\d\d-\d\d, ",
    "machine": r"^- (commit .*-\d\d, |machine: )[^,]+(, Python|$)",
    "Python": r"^- commit .*, Python \d+\.\d+\.\d+",
    "numpy": r"^- commit .*, numpy \d+\.\d+\.\d+",
    "seconds": r"^- commit .*, \d+ s\b",
    "seeds": r"^- .*\bseeds?\b",
    "command": r"^- command: `python benchmarks/\w+\.py",
}
BY_ROW = {"commit", "date", "Python", "numpy", "seconds"}
UNSAID = {
    "bound.md": {"seconds"}, "hybrids.md": {"numpy", "seconds"},  # not printed then
    "environments.md": {"seeds"}, "environments_newer.md": {"seeds"}, "recordings.md": {"seeds"},  # nothing is drawn
    "data_sheets.md": {"seeds"},
    "fuzz.md": BY_ROW, "fuzz_analysis.md": BY_ROW,  # rows are made one by one, and name their commit and date
}  # fmt: skip

COLUMNS = {"commit": r"[0-9a-f]{7}", "date": r"\d{4}-\d\d-\d\d"}
"""What cells below such headings are."""
NUMBER = re.compile(r"[+-]?\d+(\.\d+)?(e[+-]?\d+)?")
BESIDE_NUMBERS = {"<=", ">=", "±", "+-", "/", "..", "-", "ms", "s", "s,", "scatter"}
NO_FIGURES = {
    ("interruption.md", "over 10"): "it is not waited for the end",
    ("rate.md", "(staircase 0.0013)"): "what the paper has where the others have a bound",
    ("recordings.md", "nan"): "the model has no such term",
}
SIGNED = ("bias", "difference", "over the bound", "apart")
"""Beginnings of headings of percents that may be negative."""

KEYS = {
    "angle.md": 3, "bound.md": 4, "coefficients.md": 2, "comparison.md": 2, "comparison_ratio.md": 2,
    "compensation.md": 3, "consistency.md": 3, "coverage.md": 3, "curves.md": 5, "data_sheets.md": 3,
    "drift.md": (2, 2, 1), "environments.md": 2, "environments_newer.md": 2, "gaps.md": 3, "gaps_curves.md": 4,
    "hybrids.md": 4, "identification.md": 4, "limits.md": 4, "limits_quantization.md": 4,
    "methods.md": 5, "noise_identification.md": 4,
    "rate.md": (1, 1, 1, 1, 1, 2, 1), "real_sensors.md": 2, "recordings.md": 2, "robustness.md": (2, 4, 2),
    "selection.md": 3, "signals.md": 2, "simulation.md": 2, "slow_noise.md": 3, "stream.md": (1, 3), "terms.md": 3,
    "two_shapes.md": 3,
    "theoh_paper.md": (1, 1, 2, 2, 1, 2), "vertical.md": (1, 1, 3, 2, 1, 1, 1, 1), "web.md": 2, "window_moments.md": 2,
}  # fmt: skip
"""Number of the first columns that tell rows apart, where it is not one; of each table, where tables differ."""


def test_every_page_says_how_it_was_made():
    found = {
        name: {part for part, said in SAID.items() if not re.search(said, page.head, re.MULTILINE)}
        for name, page in PAGES.items()
    }
    assert {name: parts for name, parts in found.items() if parts} == UNSAID


def test_the_command_of_every_page_is_taken_by_its_script(monkeypatch):
    monkeypatch.setattr(table, "commit", sys.exit)  # asked for when the command line has been read
    for page in PAGES.values():
        for line in re.findall(r"^- command: .*", page.head, re.MULTILINE):
            now = re.findall(r"`([^`]+)`", line)[-1]  # behind one that an earlier commit took
            _, script, *options = shlex.split(now)
            assert (ROOT / script).is_file()
            monkeypatch.setattr(sys, "argv", [script, *options])
            with pytest.raises(SystemExit) as end:
                importlib.import_module(Path(script).stem).main()
            assert end.value.code is None, now


def cells(line):
    return [cell[1:-1] for cell in line.strip("|").split("|")]


def is_figure(cell):
    found = set(re.findall(r"[^\s()%]+", cell)) - BESIDE_NUMBERS
    return bool(found) and all(map(NUMBER.fullmatch, found))


def faults(heading, column):
    """Cells that are not what the heading says, text where most are figures, not finite, and negative percents."""
    yield from (cell for cell in column if not re.fullmatch(COLUMNS.get(heading, ".*"), cell))
    given = [cell for cell in column if cell not in ("", "-")]
    others = [cell for cell in given if not is_figure(cell)]
    yield from others if 2 * len(others) < len(given) else ()
    for cell in given:
        negative = "%" in heading + cell and not heading.startswith(SIGNED) and re.match(r"-\d", cell)
        if negative or re.fullmatch(r"[+-]?(nan|inf)", cell, re.IGNORECASE):
            yield cell


def test_every_table_is_whole():
    """Rows of as many cells, no two with the same key, and figures in columns of figures."""
    broken, no_figures = [], set()
    for name, page in PAGES.items():
        parts = re.split(r"\n\n+", page.text)
        blocks = [part.splitlines() for part in parts if re.search(r"^\|", part, re.MULTILINE)]
        keys = KEYS.get(name, 1)
        keys = keys if isinstance(keys, tuple) else (keys,) * len(blocks)
        assert len(blocks) == len(keys) > 0, name
        for (first, rule, *lines), key in zip(blocks, keys, strict=True):
            headings, rows = cells(first), [cells(line) for line in lines]
            said = [row[:key] for row in rows]
            broken += [(name, line) for line in (first, *lines) if not re.fullmatch(r"\| .* \|", line)]
            broken += [(name, row) for row in rows if len(row) != len(headings) or said.count(row[:key]) > 1]
            if rule != "|" + "---|" * len(headings) or len(set(headings)) < len(headings) or not rows:
                broken.append((name, first))
            for heading, column in zip(headings, zip(*rows, strict=False), strict=False):
                no_figures |= {(name, cell) for cell in faults(heading, column)}
    assert broken == []
    assert no_figures == set(NO_FIGURES)
