"""Committed tables hold what is claimed of them, and a part of each is made again."""

from table import RESULTS, read

import re

import pytest
from tests import thinned
from tests.shares import binomial_tail

import allanite as al
import compensation
import confidence_coverage
import growth
import noise_identification
import simulation
from identification import Job, identified, summary, symbols
from selection import PURE, claimed, fitted

SHORT = {
    ("known", "FOG", "262144", "B", "rmse"): "1.17 of the bound, standard error 0.04: K, whose bound is 39 %, is left "
    "out of half the models, and what it leaves goes to B",
}
"""Figures of identification.md that fall short, and why."""


def demanded(row):
    """Least and most of figures of a row, by their headings."""
    if row["term"].endswith("(absent)"):
        return {"claimed %": (0, 7)}
    bound = float(row["bound %"])
    return (
        ({"profile %": (91.5, 98)} if bound <= 40 else {})
        | ({"width": (0, 1.25)} if bound < 12 else {})
        | ({"rmse": (0, 1.15), "bias": (-0.3, 0.3)} if bound < 12 and row["terms"] == "known" else {})
        | ({"identified %": (98, 100)} if bound <= 10 else {})
    )


def test_identification_meets_its_demands():
    assert {
        (*list(row.values())[:4], heading)
        for row in read("identification.md").rows()
        for heading, (least, most) in demanded(row).items()
        if not least <= float(row[heading]) <= most
    } == set(SHORT)


def test_every_sensor_length_and_term_is_there():
    found = {(r["sensor"], r["n"], r["term"][0]) for r in read("identification.md").rows() if r["terms"] == "auto"}
    sizes = ("65536", "262144")
    assert found == {(s, n, t) for s in ("MEMS", "FOG", "RLG") for n in sizes for t in "QNBKR"}


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("terms", ["auto", "known"])
@pytest.mark.parametrize("sensor", thinned(["MEMS", "FOG", "RLG"], 1, "a part of a committed table made again"))
def test_a_part_made_again_agrees(sensor, terms):
    """The first 25 records of each sensor; each count within the table's share at an error probability of 1e-5."""
    records = 25
    jobs = [Job(terms, sensor, 65536, seed) for seed in range(1, records + 1)]
    found = [identified(job) for job in jobs]
    where = (terms, sensor, "65536")
    table = [row for row in read("identification.md").rows() if (row["terms"], row["sensor"], row["n"]) == where]
    assert [row["term"][0] for row in table] == list(symbols(terms, sensor))
    for which, row in enumerate(table):
        made = summary(jobs[0], row["term"][0], [record[which] for record in found])
        for column, heading in ((5, "claimed %"), (7, "cover %"), (8, "profile %")):
            share = min(max(float(row[heading]) / 100, 0.002), 0.998)
            assert binomial_tail(round(float(made[column]) * records / 100), records, share) > 1e-5
        assert made[4] == row["bound %"] or float(made[4]) == pytest.approx(float(row["bound %"]), rel=0.03)


UNMET = {("goodness of fit p < 5 %", "FOG"): "9.5 ± 2.1 %; of 400 records in robustness.md 9.5 ± 1.5 %"}
"""Rows of selection.md that fall short."""


def met(row):
    value = float(row["value"].split()[0])
    bounds = [float(x) for x in re.findall(r"[\d.]*\d", row["demand"])]
    if row["demand"].startswith("<="):
        return value <= bounds[0]
    if row["demand"].startswith(">="):
        return value >= bounds[0]
    return bounds[0] <= value <= bounds[1]


def test_selection_meets_its_demands():
    rows = [row for row in read("selection.md").rows() if row["demand"]]
    assert {(row["what"], row["model"]) for row in rows if not met(row)} == set(UNMET)


@pytest.mark.slow("takes more than half a second")
def test_a_part_of_the_selection_made_again_agrees():
    """False claims in the first 20 records of white noise: more than 5 of 3.5 % each have a probability of 1e-4."""
    found = [fitted((PURE[0], seed)) for seed in range(1, 21)]
    assert all("N" in claimed(terms) for terms, _, _ in found)
    assert sum(bool(claimed(terms) - {"N", "R"}) for terms, _, _ in found) <= 5
    assert sum(p < 0.05 for _, p, _ in found) <= 6


GROWN = {"oadev, every tau of 3.6e6 [s]", "theo1, 100 m of 720000 [s]", "oadev, 100 tau of 3.6e6 with integration"}
"""Beginnings of the rows that are missed: made under a load of 7 to 9 on 2 cores, and by what the page says."""


def test_growth_meets_its_demands():
    rows = [list(row.values()) for row in read("growth.md").rows()]
    missed = {row[0].split(":")[0] for row in rows if row[5] != "met"}
    assert missed == GROWN
    assert (RESULTS / "growth.svg").stat().st_size > 10_000


@pytest.mark.slow("a part of a committed table made again")
def test_a_part_of_the_growth_made_again_agrees():
    """The errors of every tau and of Theo1 for a shorter record, and the memory of one."""
    for _, allan, theo in growth.errors(5000):
        assert allan < 1e-9
        assert theo < 1e-9
    assert growth.memory("oadev", "all", 400_000) < 20


# what the autocorrelation is known to reach, in percent at so many points, less three standard errors of 200 records
KNOWN = {
    ("oadev", "WFM"): {4097: 98, 513: 98, 129: 95, 65: 87, 33: 68},
    ("oadev", "FFM"): {4097: 98, 513: 98, 129: 95, 65: 80, 33: 46},
    ("oadev", "RWFM"): {4097: 98, 513: 98, 129: 98, 65: 93, 33: 82},
    ("ohdev", "RWFM"): {257: 98, 129: 92, 65: 87},
    ("ohdev", "FWFM"): {257: 98, 129: 94, 65: 88},
    ("ohdev", "RRFM"): {257: 98, 129: 98, 65: 95},
}


IDENTIFIED = read("noise_identification.md").rows()


def test_noise_is_identified_as_often_as_it_can_be():
    rows = [row for row in IDENTIFIED if (row["row"], row["noise"]) in KNOWN]
    assert {(row["row"], row["noise"]) for row in rows} == set(KNOWN)
    least = [KNOWN[row["row"], row["noise"]].get(int(row["points"]), 50) for row in rows]
    assert [row for row, share in zip(rows, least, strict=True) if float(row["found %"]) < share] == []


def test_plain_rounding_takes_flicker_for_random_walk():
    rows = [row for row in IDENTIFIED if (row["row"], row["noise"]) == ("oadev", "FFM")]
    for row in rows:
        assert float(row["plain rounding %"]) < float(row["found %"]) - 10


@pytest.mark.parametrize("which", range(0, len(IDENTIFIED), 5))
def test_a_part_of_noise_identification_made_again_agrees(which):
    """The same 200 seeds: two records may fall on the other side of a threshold by rounding."""
    script = noise_identification
    row = IDENTIFIED[which]
    made = dict(zip(script.HEADINGS, script.made(script.CELLS[which], 200), strict=True))
    for heading in script.HEADINGS[:5]:
        assert made[heading] == row[heading]
    for heading in script.HEADINGS[5:]:
        assert float(made[heading]) == pytest.approx(float(row[heading]), abs=1.0)


def test_confidence_limits_cover_in_every_cell_of_the_table():
    rows, script = read("coverage.md").rows(), confidence_coverage
    assert {(row["noise"], row["statistic"]) for row in rows} <= set(script.CELLS)
    assert len({row["statistic"] for row in rows}) == len(script.FACTORS)
    missed = [row for row in rows if not script.within(tuple(row.values()))]
    # the upper limit of the folded statistic is wide under white noise of the angle, and not only that
    assert {row["statistic"] for row in missed} == {"totdev"}
    assert all("Q" in row["noise"] and 0 < float(row["above"]) < 1 for row in missed)
    assert len(missed) <= 5


@pytest.mark.parametrize(("noise", "name"), [("NK", "oadev"), ("QK", "theo1"), ("NBKR", "totdev"), ("K", "mtotdev")])
def test_a_part_of_the_coverage_made_again_agrees(noise, name):
    """The first 200 of the same seeds: within 5 standard errors of 200 records (one failure in a million)."""
    script = confidence_coverage
    again = script.made((noise, name), script.records_of(noise, 200))
    rows = [row for row in read("coverage.md").rows() if (row["noise"], row["statistic"]) == (noise, name)]
    for line, row in zip(again, rows, strict=True):
        made = dict(zip(script.HEADINGS, line, strict=True))
        assert made["edf"] == row["edf"]
        assert float(made["68 %"]) == pytest.approx(float(row["68 %"]), abs=17)
        assert float(made["95 %"]) == pytest.approx(float(row["95 %"]), abs=8)


def test_simulated_records_have_the_expected_curve_and_spectrum():
    """Within 3 standard errors of 200 records at every octave, of every term and mixture."""
    rows, script = read("simulation.md").rows(), simulation
    again = "python benchmarks/simulation.py --write benchmarks/results/simulation.md"
    assert {row["noise"] for row in rows} == set(script.MODELS), f"make the table again: {again}"
    simulated = {t.symbol for text in script.MODELS.values() for t in al.Model(text)}
    assert set(al.TERMS) == simulated, "add a model with each term to MODELS in benchmarks/simulation.py"
    assert all(float(row["largest"]) < 3 for row in rows)


@pytest.mark.parametrize("name", ["Q", "K", "all"])
def test_a_part_of_the_simulation_made_again_agrees(name):
    """The same 200 seeds: the same numbers but for rounding."""
    script = simulation
    again = script.made(name, 200)
    for line, row in zip(again, [row for row in read("simulation.md").rows() if row["noise"] == name], strict=True):
        made = dict(zip(script.HEADINGS, line, strict=True))
        assert made["of"] == row["of"]
        for heading in script.HEADINGS[2:]:
            assert float(made[heading]) == pytest.approx(float(row[heading]), abs=0.02)


def compensated(row):
    """Whether false effects, limits and promises are as demanded."""
    demanded, (false, within) = row["noise"] == "table 2", map(float, (row["false %"], row["within 95 % limits"]))
    most = 99 if demanded else 100
    if not (2.5 * demanded <= false <= 8 and 92 <= within <= most):
        return False
    if not row["gain met %"]:
        return True
    surplus, error = map(float, row["surplus"].split(" +- "))
    bold = surplus <= -0.1 - 3 * error or (demanded and surplus >= 0.15 + 3 * error)
    return 92 <= float(row["gain met %"]) <= most and not bold


def test_compensation_meets_its_demands():
    """Of 400 records: false effects, limits and promises under the noise of table 2; never too bold under any."""
    assert [row for row in read("compensation.md").rows() if not compensated(row)] == []


def test_ordinary_least_squares_sees_what_is_not_there():
    slow = [r for r in read("compensation.md").rows() if r["noise"] != "white" and r["regressor"] == "temp"]
    assert len(slow) == 9
    assert all(float(row["ordinary %"]) > 20 for row in slow)
    assert all(3 <= float(row["noise known %"]) <= 8 for row in slow)


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.slow("a part of a committed table made again")
def test_a_part_of_the_compensation_made_again_agrees(which):
    """The first 10 of the same seeds; each count within the table's share at an error probability of 1e-4."""
    script, records = compensation, 10
    cell = script.CELLS[which]
    lines = script.made(cell, [script.run_one((cell, seed)) for seed in range(1, records + 1)])
    table = [r for r in read("compensation.md").rows() if (r["noise"], r["temperature"]) == (cell.noise, cell.drift)]
    for line, row in zip(lines, table, strict=True):
        made = dict(zip(script.HEADINGS, line, strict=True))
        for heading in ("false %", "ordinary %", "within 95 % limits"):
            share = min(max(float(row[heading]) / 100, 0.005), 0.995)
            assert binomial_tail(round(float(made[heading]) * records / 100), records, share) > 1e-4
