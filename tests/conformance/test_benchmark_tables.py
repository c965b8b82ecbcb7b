"""Committed tables are of the scripts and methods of today; a part of that of the methods is made again.

Parts of other tables are made again by their scripts: `PARTS` of tools/nightly.py.
"""

import table
from table import RESULTS, read

import importlib
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from tests import ROOT
from tests.rows import rows

import allanite as al


def rows_of(name, section="", **where):
    """Rows of a committed table whose cells are as given."""
    every = (row for part in read(name).tables(section) for row in part)
    return [row for row in every if all(row.get(heading) == cell for heading, cell in where.items())]


@pytest.mark.slow("loads every script")
def test_the_command_of_every_table_is_taken_by_its_script(monkeypatch):
    monkeypatch.setattr(table, "commit", sys.exit)  # asked for when the command line has been read
    for page in map(read, (path.name for path in RESULTS.glob("*.md"))):
        now = re.findall(r"`(python [^`]+)`", re.search(r"^- command: .*", page.head, re.MULTILINE)[0])[-1]
        _, script, *options = shlex.split(now)
        monkeypatch.setattr(sys, "argv", [script, *options])
        assert (ROOT / script).is_file(), now
        with pytest.raises(SystemExit) as end:
            importlib.import_module(Path(script).stem).main()
        assert end.value.code is None, now


def test_every_term_is_in_a_model_of_the_simulation():
    import simulation

    simulated = {term.symbol for text in simulation.MODELS.values() for term in al.Model(text)}
    assert set(al.terms.TERMS) == simulated, "add a model with each term to MODELS in benchmarks/simulation.py"
    command = "python benchmarks/simulation.py --write benchmarks/results/simulation.md"
    assert {row["noise"] for row in rows_of("simulation.md")} == set(simulation.MODELS), f"make it again: {command}"


def test_the_efficiency_of_a_method_is_that_of_the_table():
    good = [row for row in rows_of("methods.md", "Each method") if float(row["bound %"]) <= 12]
    for name, method in al.identification.METHODS.items():
        stated = re.fullmatch(r"([\d.]+) to ([\d.]+) times the Cramer-Rao bound", method.efficiency).groups()
        errors = [float(row["rmse"]) for row in good if row["method"] == name]
        assert [*map(float, stated)] == pytest.approx([min(errors), max(errors)], rel=0.01), name


@pytest.mark.nightly("a part of a committed table made again")
@rows("sensor", ["MEMS", "FOG", "RLG"])
def test_methods(sensor):
    """The first 10 records of well determined terms.

    The mean square of 10 lies within 0.1 and 4.5 times that of all (chi-square, 5e-5 on each side if errors are
    normal), and the mean within 5 standard errors.
    """
    import methods

    count = 10
    found = [methods.identified(("Each method", sensor, 2**16, number)) for number in range(count)]
    made = [dict(zip(methods.HEADINGS, row, strict=True)) for row in methods.rows_of(sensor, 2**16, found)]
    for new, row in zip(made, rows_of("methods.md", "Each method", sensor=sensor, n="65536"), strict=True):
        assert list(new.values())[:5] == list(row.values())[:5]
        assert (new["cover %"] == "-") == (row["cover %"] == "-")
        if float(row["bound %"]) <= 12 and row["method"] != "slopes":  # from which point is no normal error
            rmse, bias = float(row["rmse"]), float(row["bias"])
            assert 0.1 <= (float(new["rmse"]) / rmse) ** 2 <= 4.5
            scatter = np.sqrt(max(rmse**2 - bias**2, 0.0) + 0.02)
            assert abs(float(new["bias"]) - bias) <= 5 * scatter / np.sqrt(count)
