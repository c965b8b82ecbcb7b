"""The committed tables hold what is claimed of them, and a part of them can be made again."""

from table import RESULTS, read

import math
import re

import pytest

import allanite as al
import compensation
import confidence_coverage
import growth
import noise_identification
import simulation
from fuzz_readers import SEEDS
from identification import Job, identified, summary, symbols


@pytest.mark.parametrize(
    "name",
    [
        "identification.md",
        "simulation.md",
        "bound.md",
        "noise_identification.md",
        "speed.md",
        "growth.md",
        "angle.md",
        "coverage.md",
        "compensation.md",
    ],
)
def test_tables_say_how_they_were_made(name):
    head = read(name).head
    assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d", head)
    assert "seed" in head
    assert "command: `python benchmarks/" in head


SHORT = {
    "known-FOG-262144-B": "1.17 of the bound, standard error 0.04: K, whose bound is 39 %, is left out of half the "
    "models, and what it leaves goes to B",
}
"""Rows of identification.md that fall short, and why."""


def demanded(row):
    name = "-".join(list(row.values())[:4])
    return pytest.param(row, id=name, marks=[pytest.mark.xfail(reason=SHORT[name])] if name in SHORT else [])


@pytest.mark.parametrize("row", [demanded(row) for row in read("identification.md").rows()])
def test_identification_meets_its_demands(row):
    if row["term"].endswith("(absent)"):
        assert float(row["claimed %"]) <= 7
        return
    bound = float(row["bound %"])
    if bound <= 40:
        assert 91.5 <= float(row["profile %"]) <= 98
    if bound < 12:
        assert float(row["width"]) <= 1.25
    if bound < 12 and row["terms"] == "known":
        assert float(row["rmse"]) <= 1.15
        assert abs(float(row["bias"])) <= 0.3
    if bound <= 10:
        assert float(row["identified %"]) >= 98


def test_every_sensor_length_and_term_is_there():
    found = {(r["sensor"], r["n"], r["term"][0]) for r in read("identification.md").rows() if r["terms"] == "auto"}
    sizes = ("65536", "262144")
    assert found == {(s, n, t) for s in ("MEMS", "FOG", "RLG") for n in sizes for t in "QNBKR"}


def binomial_tail(k, n, p):
    """Smaller of P(X <= k) and P(X >= k)."""
    terms = [math.comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(n + 1)]
    return min(sum(terms[: k + 1]), sum(terms[k:]))


@pytest.mark.parametrize("terms", ["auto", "known"])
@pytest.mark.parametrize("sensor", ["MEMS", "FOG", "RLG"])
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


SLOW = {
    "oadev at 100 tau": "0.79 of the in-cache bound instead of 0.8 (0.88 in a run before): averaging factors above "
    "32768 read every sample again from the third-level cache",
    "mdev at 100 tau": "0.50 of the in-cache bound instead of 0.8: running sums are made anew every three octaves",
    "whole analysis": "10.1 times instead of 6: 7.8 before the overlapped Allan became faster",
}
"""Rows of the table that are missed, and why."""


def demand(row):
    reason = next((why for what, why in SLOW.items() if row["what"].startswith(what)), None)
    return pytest.param(row, marks=[pytest.mark.xfail(reason=reason, strict=True)] if reason else [])


@pytest.mark.parametrize("row", [demand(row) for row in read("speed.md").rows()], ids=lambda row: row["what"][:30])
def test_speed_meets_its_demands(row):
    assert list(row.values())[3] == "met"


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


def test_damaged_files_of_every_format_are_read_or_refused():
    head = read("fuzz.md").head
    assert "command: `python benchmarks/fuzz_readers.py" in head
    assert "seed" in head
    rows = {row["file"]: row for row in read("fuzz.md").rows()}
    assert set(rows) == set(SEEDS)
    for name, row in rows.items():
        assert re.fullmatch(r"[0-9a-f]{7}", row["commit"])
        assert int(row["read"]) + int(row["refused"]) == int(row["mutations"]) >= min(8000, SEEDS[name].count)
        assert (int(row["failures"]), int(row["slowest ms"]) < 2000, int(row["memory MB"]) < 100) == (0, True, True)


@pytest.mark.parametrize("name", ["signals.md", "interruption.md"])
def test_programs_that_are_ended_leave_nothing(name):
    rows = read(name).rows()
    assert {row["job"]: row["failures"] for row in rows if row["failures"] != "0"} == {}
    assert all(int(row["runs"]) >= 2 for row in rows)


def test_every_version_of_the_dependencies_passes():
    rows = read("environments.md").rows()
    assert {row["dependencies"] for row in rows} == {"oldest", "newest"}
    assert all(re.match(r"\d+ passed", row["tests"]) for row in rows), rows


# what the autocorrelation is known to reach, in percent at so many points, less three standard errors of 200 records
KNOWN = {
    ("oadev", "WFM"): {4097: 98, 513: 98, 129: 95, 65: 87, 33: 68},
    ("oadev", "FFM"): {4097: 98, 513: 98, 129: 95, 65: 80, 33: 46},
    ("oadev", "RWFM"): {4097: 98, 513: 98, 129: 98, 65: 93, 33: 82},
    ("ohdev", "RWFM"): {257: 98, 129: 92, 65: 87},
    ("ohdev", "FWFM"): {257: 98, 129: 94, 65: 88},
    ("ohdev", "RRFM"): {257: 98, 129: 98, 65: 95},
}


@pytest.mark.parametrize("case", KNOWN, ids="-".join)
def test_noise_is_identified_as_often_as_it_can_be(case):
    rows = [r for r in read("noise_identification.md").rows() if (r["row"], r["noise"]) == case]
    for row in rows:
        assert float(row["found %"]) >= KNOWN[case].get(int(row["points"]), 50)


def test_plain_rounding_takes_flicker_for_random_walk():
    rows = [r for r in read("noise_identification.md").rows() if (r["row"], r["noise"]) == ("oadev", "FFM")]
    for row in rows:
        assert float(row["plain rounding %"]) < float(row["found %"]) - 10


@pytest.mark.parametrize("which", range(0, len(read("noise_identification.md").rows()), 5))
def test_a_part_of_noise_identification_made_again_agrees(which):
    """The same 200 seeds: two records may fall on the other side of a threshold by rounding."""
    script = noise_identification
    row = read("noise_identification.md").rows()[which]
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


def test_hybrids_have_the_degrees_of_freedom_of_the_simulation():
    """Within 15 %, on seeds that the factors were not taken from."""
    for row in read("hybrids.md").rows():
        assert float(row["edf / simulated"]) == pytest.approx(1, abs=0.15), row
        assert 92.5 <= float(row["95 %"]) <= 97.5, row


def test_simulated_records_have_the_expected_curve_and_spectrum():
    """Within 3 standard errors of 200 records at every octave, of every term and mixture."""
    rows, script = read("simulation.md").rows(), simulation
    assert {row["noise"] for row in rows} == set(script.MODELS)
    assert {t.symbol for text in script.MODELS.values() for t in al.parse_model(text)} == set(al.TERMS)
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


def test_the_bound_is_that_of_full_matrices():
    rows = read("bound.md").rows()
    assert {row["model"] for row in rows} >= set(al.SENSORS)
    assert {row["ramp"] for row in rows} == {"none", "unknown"}
    assert all(abs(float(row["ratio"]) - 1) < 0.002 for row in rows)


@pytest.mark.parametrize(
    "row", read("compensation.md").rows(), ids=lambda r: f"{r['noise']}-{r['temperature']}-{r['regressor']}"
)
def test_compensation_meets_its_demands(row):
    """Of 400 records: false effects, limits and promises under the noise of table 2; never too bold under any."""
    demanded = row["noise"] == "table 2"
    assert (3 if demanded else 0) <= float(row["false %"]) <= 8
    assert 92 <= float(row["within 95 % limits"]) <= (98 if demanded else 100)
    if row["gain met %"]:
        assert 92 <= float(row["gain met %"]) <= (98 if demanded else 100)
        gain, error = map(float, row["gain / expected"].split(" +- "))
        assert gain > 0.9 - 3 * error
        assert not demanded or gain < 1.15 + 3 * error


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
