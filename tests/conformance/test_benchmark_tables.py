"""A part of each committed table is made again: as chance allows where records are fewer, else digit by digit."""

import table
from table import RESULTS, read

import importlib
import math
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from tests import ROOT
from tests.rows import rows
from tests.shares import binomial_tail

import allanite as al

again = pytest.mark.nightly("a part of a committed table made again")


def rows_of(name, section="", **where):
    """Rows of a committed table whose cells are as given."""
    every = (row for part in read(name).tables(section) for row in part)
    return [row for row in every if all(row.get(heading) == cell for heading, cell in where.items())]


def within(share, count, table_share, least, error=1e-4):
    """Whether a share of so many records, %, is one of a table's share, which is at least so far from 0 and 1."""
    p = min(max(float(table_share) / 100, least), 1 - least)
    return binomial_tail(round(float(share) * count / 100), count, p) > error


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


@again
@rows("sensor, terms", [(sensor, terms) for sensor in ("MEMS", "FOG", "RLG") for terms in ("auto", "known")])
def test_identification(sensor, terms):
    from identification import Job, identified, summary, symbols

    count = 25
    jobs = [Job(terms, sensor, 65536, seed) for seed in range(1, count + 1)]
    found = [identified(job) for job in jobs]
    expected = rows_of("identification.md", terms=terms, sensor=sensor, n="65536")
    assert [row["term"][0] for row in expected] == list(symbols(terms, sensor))
    for which, row in enumerate(expected):
        made = summary(jobs[0], row["term"][0], [record[which] for record in found])
        for column, heading in ((5, "claimed %"), (7, "cover %"), (8, "profile %")):
            assert within(made[column], count, row[heading], 0.002, 1e-5)
        assert made[4] == row["bound %"] or float(made[4]) == pytest.approx(float(row["bound %"]), rel=0.03)


@again
def test_selection():
    """False claims in 20 records of white noise: more than 5 of 3.5 % each have a probability of 1e-4."""
    from selection import PURE, claimed, fitted

    found = [fitted((PURE[0], seed)) for seed in range(1, 21)]
    assert all("N" in claimed(terms) for terms, _, _ in found)
    assert sum(bool(claimed(terms) - {"N", "R"}) for terms, _, _ in found) <= 5
    assert sum(p < 0.05 for _, p, _ in found) <= 6


@again
def test_growth():
    """The errors of every tau and of Theo1 for a shorter record, and the memory of one."""
    import speed

    for _, allan, theo in speed.errors(5000):
        assert max(allan, theo) < 1e-9
    assert speed.memory("oadev", "all", 400_000) < 20


@again
def test_noise_identification():
    """The same 200 seeds: two records may fall on the other side of a threshold by rounding."""
    import noise_identification as script

    committed = rows_of("noise_identification.md")
    for which in range(0, len(script.CELLS), 5):
        made = dict(zip(script.HEADINGS, script.made(script.CELLS[which], 200), strict=True))
        for k, heading in enumerate(script.HEADINGS):
            number = pytest.approx(float(committed[which][heading]), abs=1.0) if k > 4 else committed[which][heading]
            assert (float(made[heading]) if k > 4 else made[heading]) == number, (which, heading)


@again
@rows("noise, name", [("NK", "oadev"), ("QK", "theo1"), ("NBKR", "totdev"), ("K", "mtotdev")])
def test_coverage(noise, name):
    """The first 200 of the same seeds: within 5 standard errors of 200 records (one failure in a million)."""
    import confidence_coverage as script

    lines = script.made((noise, name), script.records_of(noise, 200))
    for line, row in zip(lines, rows_of("coverage.md", noise=noise, statistic=name), strict=True):
        made = dict(zip(script.HEADINGS, line, strict=True))
        assert made["edf"] == row["edf"]
        assert float(made["68 %"]) == pytest.approx(float(row["68 %"]), abs=17)
        assert float(made["95 %"]) == pytest.approx(float(row["95 %"]), abs=8)


def test_every_term_is_in_a_model_of_the_simulation():
    import simulation

    simulated = {term.symbol for text in simulation.MODELS.values() for term in al.Model(text)}
    assert set(al.terms.TERMS) == simulated, "add a model with each term to MODELS in benchmarks/simulation.py"
    again = "python benchmarks/simulation.py --write benchmarks/results/simulation.md"
    assert {row["noise"] for row in rows_of("simulation.md")} == set(simulation.MODELS), f"make it again: {again}"


@again
@rows("name", ["Q", "K", "all"])
def test_simulation(name):
    """The same 200 seeds: the same numbers but for rounding."""
    import simulation as script

    for line, row in zip(script.made(name, 200), rows_of("simulation.md", noise=name), strict=True):
        made = dict(zip(script.HEADINGS, line, strict=True))
        assert made["of"] == row["of"]
        for heading in script.HEADINGS[2:]:
            assert float(made[heading]) == pytest.approx(float(row[heading]), abs=0.02)


@again
@rows("which", [0, 1])
def test_compensation(which):
    import compensation as script

    count = 10
    cell = script.CELLS[which]
    lines = script.made(cell, [script.run_one((cell, seed)) for seed in range(1, count + 1)])
    expected = rows_of("compensation.md", noise=cell.noise, temperature=cell.drift)
    for line, row in zip(lines, expected, strict=True):
        made = dict(zip(script.HEADINGS, line, strict=True))
        for heading in ("false %", "ordinary %", "within 95 % limits"):
            assert within(made[heading], count, row[heading], 0.005)


@again
def test_check():
    import check

    expected = rows_of("check.md", "Defects")
    for number, defect in list(enumerate(check.DEFECTS))[::6]:
        row, found, named = check.defect_row(number, defect, 1)
        assert row[:2] == list(expected[number].values())[:2]
        assert (found, named) == (True, True)
    assert check.checked(check.RIGHT["pegasus"], np.random.default_rng((2, 2, 0)), "ga").agrees


def near(share, expected, count, more):
    """Whether a share lies within 5 standard errors of so many records."""
    return abs(share - expected) < 5 * math.sqrt(expected * (1 - expected) / count) + more


@again
@rows("model", ["N", "NK"])
def test_comparison(model):
    import comparison

    for _, test, share in comparison.verdict_rows(model, 30):
        (row,) = (row for row in read("comparison.md").tables()[0] if (row["model"], row["test"]) == (model, test))
        assert near(float(share) / 100, float(row["called different %"]) / 100, 30, 0.03)


@again
def test_comparison_of_ratios():
    import comparison

    made = {row[1]: row for row in comparison.ratio_rows("NK", 15)}
    for row in rows_of("comparison_ratio.md", model="NK"):
        assert made[row["tau, s"]][2] == row["edf"]
        for cell, expected in zip(made[row["tau, s"]][4:], list(row.values())[4:], strict=True):
            measured, predicted = map(float, cell.split(" / "))
            assert predicted == pytest.approx(float(expected.split(" / ")[1]), abs=0.1)
            assert near(measured / 100, min(max(predicted / 100, 0.01), 0.99), 15, 0.05)


@again
def test_limits():
    """Values and places of the truth of a few records, the numbers of a whole table being shares of many."""
    import limits

    found = [limits.coefficients_of(("edge K", i)) for i in range(3)]
    assert all(record["N"][3] for record in found)
    assert all(0.9 < record["N"][0] < 1.1 for record in found)
    assert sum(record["K"][4] for record in found) >= 2
    curves = [limits.curves_of(("N+weak K", 256, i)) for i in range(3)]
    assert sum(record["averaged", "oadev", 102].place[0] == 0 for record in curves) >= 2
    widths = [
        record["averaged", "totdev", 204].width[0] / record["selected", "totdev", 204].width[0] for record in curves
    ]
    assert np.median(widths) > 1.2


def test_the_efficiency_of_a_method_is_that_of_the_table():
    good = [row for row in rows_of("methods.md") if float(row["bound %"]) <= 12]
    for name, method in al.identification.METHODS.items():
        stated = re.fullmatch(r"([\d.]+) to ([\d.]+) times the Cramer-Rao bound", method.efficiency)
        errors = [float(row["rmse"]) for row in good if row["method"] == name]
        assert [float(number) for number in stated.groups()] == pytest.approx([min(errors), max(errors)], rel=0.01), (
            name
        )


@again
@rows("sensor", ["MEMS", "FOG", "RLG"])
def test_methods(sensor):
    """The first 10 records of well determined terms.

    The mean square of 10 lies within 0.1 and 4.5 times that of all (chi-square, 5e-5 on each side if errors are
    normal), and the mean within 5 standard errors.
    """
    import methods

    count = 10
    found = [methods.identified(methods.Job("known", sensor, 2**16, seed)) for seed in range(1, count + 1)]
    made = [dict(zip(methods.HEADINGS, row, strict=True)) for row in methods.rows_of(sensor, 2**16, found)]
    for new, row in zip(made, rows_of("methods.md", sensor=sensor, n="65536"), strict=True):
        assert list(new.values())[:5] == list(row.values())[:5]
        assert (new["cover %"] == "-") == (row["cover %"] == "-")
        if (
            float(row["bound %"]) > 12 or row["method"] == "slopes"
        ):  # which point a slope is read from is no normal error
            continue
        rmse, bias = float(row["rmse"]), float(row["bias"])
        assert 0.1 <= (float(new["rmse"]) / rmse) ** 2 <= 4.5
        scatter = np.sqrt(max(rmse**2 - bias**2, 0.0) + 0.02)
        assert abs(float(new["bias"]) - bias) <= 5 * scatter / np.sqrt(count)


@again
def test_rate():
    """The exact rows, the models that fit, when to average, and the run with seed 1: to the last printed digit."""
    import rate

    headings, lines = rate.efficiency()
    assert [dict(zip(headings, line, strict=True)) for line in lines] == rows_of("rate.md", "When to average")
    for row, deviation in zip(
        rows_of("rate.md", "The paper's experiment"), rate.deviations(rate.gl1_run(1)), strict=True
    ):
        assert row["exact covariance"] == f"{rate.exact(row['method']):.5f}"
        assert float(row["seed 1"]) == pytest.approx(deviation, abs=2e-5)


def test_the_example_of_the_page_on_rates_runs():
    page = (ROOT / "docs" / "rate_paper.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    said = []
    exec(code, {"print": said.append})  # noqa: S102 - our own page
    assert said == [line.strip().split("# ")[1] for line in code.splitlines() if "# " in line]


@again
def test_real_sensors():
    import real_sensors

    answers = [real_sensors.simulated(("MEMS", "2nd-order filter, fs/6", 2**15, i)) for i in range(4)]
    assert all(answer.filtered for answer in answers)
    assert sum(answer.terms["N"][1] for answer in answers) >= 3
