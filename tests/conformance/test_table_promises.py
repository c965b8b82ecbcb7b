"""What is claimed of the committed tables that no test makes again, a part of them included."""

from table import read

import re
from statistics import mean

import pytest
from tests.shares import chance, first, records

import allanite as al
import consistency
import gaps
import slow_noise
import terms
from aided import OUTAGES
from fuzz_readers import SEEDS

SLOW = {
    "oadev at 100 tau": "0.64 of the in-cache bound instead of 0.8 (0.79 and 0.88 on other machines; code of "
    "the first has 0.65 on this one): averaging factors above 32768 read every sample again from the third-level cache",
    "mdev at 100 tau": "0.41 of the in-cache bound instead of 0.8 (0.50): running sums are made anew in seven passes",
    "ohdev at 100 tau": "0.72 of the in-cache bound instead of 0.8 (0.82; code that had it has 0.61 here), as oadev",
    "identification: transform": "1.19 times the overlapped Allan instead of 1: 122 ms, 116 before, beside an "
    "overlapped Allan that takes 103 to 140 ms on this machine from run to run",
    "whole analysis of one channel over the overlapped Allan": "14.0 times instead of 6: 1.44 s, 1.38 before, "
    "beside the same; the coefficients take 0.3 to 0.45 s instead of 0.2, as their limits weigh more time constants",
}
"""Beginnings of the rows that are missed, and why."""


def test_speed_meets_its_demands():
    assert {row["what"].split(",")[0] for row in read("speed.md").rows() if row[""] != "met"} == set(SLOW)


def test_damaged_files_of_every_format_are_read_or_refused():
    rows = {row["file"]: row for row in read("fuzz.md").rows()}
    assert set(rows) == set(SEEDS)
    for name, row in rows.items():
        assert int(row["read"]) + int(row["refused"]) == int(row["mutations"]) >= min(8000, SEEDS[name].count)
        assert (int(row["failures"]), int(row["slowest ms"]) < 2000, int(row["memory MB"]) < 100) == (0, True, True)


def test_programs_that_are_ended_leave_nothing():
    rows = [*read("signals.md").rows(), *read("interruption.md").rows()]
    assert [row for row in rows if row["failures"] != "0" or int(row["runs"]) < 2] == []


def test_every_version_of_the_dependencies_passes():
    rows = read("environments.md").rows()
    assert {row["dependencies"] for row in rows} == {"oldest", "newest"}
    assert all(re.match(r"\d+ passed", row["tests"]) for row in rows), rows


def test_hybrids_have_the_degrees_of_freedom_of_the_simulation():
    """Within 15 %, on seeds that the factors were not taken from."""
    for row in read("hybrids.md").rows():
        assert float(row["edf / simulated"]) == pytest.approx(1, abs=0.15), row
        assert 92.5 <= float(row["95 %"]) <= 97.5, row


def test_the_bound_is_that_of_full_matrices():
    rows = read("bound.md").rows()
    assert {row["model"] for row in rows} >= set(al.SENSORS)
    assert {row["ramp"] for row in rows} == {"none", "unknown"}
    assert all(abs(float(row["ratio"]) - 1) < 0.002 for row in rows)


COEFFICIENTS, CURVES = read("gaps.md"), read("gaps_curves.md")
LARGE = {
    "RLG": "where N is claimed too large, in 3 of 60 records at 30 %, the joints pass for N: the curve is up to 9 "
    "times too large instead of refused; at 1 % limits hold in 85 to 95 %",
}
"""Sensors whose limits of curves hold too rarely."""


def covered(rows):
    return [float(row["95"].split()[0]) for row in rows if row["95"]]


def test_every_sensor_has_every_pattern_of_gaps():
    for page in (COEFFICIENTS, CURVES):
        cells = {(row["sensor"], row["lost"]) for row in page.rows()}
        assert cells == {(sensor, lost) for sensor in gaps.SENSORS for lost in gaps.LOSSES}


def test_limits_of_coefficients_hold_with_gaps():
    rows = COEFFICIENTS.rows()
    assert min(covered(rows)) >= 92 - chance(92, records(COEFFICIENTS))
    for symbol in "QNBK":
        assert 92 <= mean(covered(row for row in rows if row["term"] == symbol)) <= 99


def test_what_is_explained_stays_so_with_gaps():
    assert min(float(row["explained"]) for row in COEFFICIENTS.rows() if row["explained"]) >= 95


def test_limits_of_curves_with_gaps_hold_or_the_curve_is_refused():
    found = {sensor: covered(row for row in CURVES.rows() if row["sensor"] == sensor) for sensor in gaps.SENSORS}
    least = 92 - chance(92, records(CURVES))
    assert {sensor for sensor, of in found.items() if min(of) < least or not 92 <= mean(of) <= 98} == set(LARGE)


def test_curves_reach_four_tenths_of_the_record_where_one_reading_in_a_hundred_is_lost():
    rows = [row for row in CURVES.rows() if (row["lost"], row["statistic"], row["tau / T"]) == ("1 %", "oadev", "0.4")]
    assert {row["sensor"] for row in rows if row["there"] == "100"} >= {"MEMS", "FOG"}


SLOW_THINGS, PLAIN = (read("slow_noise.md").rows(part) for part in ("Slow", "Clean"))
HUNDRED = records(read("slow_noise.md"))


def test_every_slow_thing_is_there():
    found = [(row["record"], row["noise"], int(row["n"])) for row in (*SLOW_THINGS, *PLAIN)]
    assert found == sorted(slow_noise.CELLS, key=lambda cell: cell[0] == "clean")


def test_three_in_five_slow_things_are_named_and_what_is_advised_helps():
    names = {"w": "warm-up", "f": "flicker exponent", "b": "popcorn"}
    least = 60 - chance(60, HUNDRED)
    assert [row for row in SLOW_THINGS if float(row[f"{names[row['record'][0]]} %"]) < least] == []
    assert [row for row in SLOW_THINGS if float(row["cured %"]) < 80] == []


def test_noise_alone_is_seldom_called_slow_things():
    most = 1 + chance(1, HUNDRED)
    assert [row for row in PLAIN if any(float(row[f"{name} %"]) > most for name in slow_noise.NAMES)] == []


TERMS, TWO = read("terms.md").rows(), read("two_shapes.md").rows()


def test_limits_of_terms_that_are_asked_for_cover():
    """95 % within what the records in which the term was found show of 93 %."""
    assert {row["cell"] for row in (*TERMS, *TWO)} == {str(cell.model) for cell in (*terms.ONE, *terms.TWO)}
    least = [93 - chance(93, int(row["records"]) * first(row["found, %"]) / 100) for row in (*TERMS, *TWO)]
    assert [row for row, share in zip((*TERMS, *TWO), least, strict=True) if first(row["coverage, %"]) < share] == []


def test_terms_that_are_asked_for_are_found_where_they_are_and_nowhere_else():
    rows = [row for row in (*TERMS, *TWO) if row["false, %"]]
    assert [row["parameter"] for row in rows] == [cell.extra.symbol for cell in (*terms.ONE, *terms.TWO)]
    # beside B and K, which can take its place, a second process is not always found
    hard = [row for row in rows if first(row["found, %"]) < 95]
    assert [(row["parameter"], first(row["found, %"]) > 80) for row in hard] in ([], [("GML", True)])
    assert [row for row in rows if abs(float(row["bias, %"])) > 5] == []
    assert [row for row in rows if first(row["false, %"]) > 5 + chance(5, int(row["records"]) // 3)] == []


VERTICAL = read("vertical.md")


def test_predicted_errors_of_a_vertical_are_the_simulated_ones():
    rows = VERTICAL.rows("Predicted against simulated")
    assert len(rows) == 60
    assert max(abs(float(row["difference"].removesuffix(" %"))) for row in rows) < 5
    for row in VERTICAL.rows("Flicker and random walk"):
        assert float(row["simulated [arcsec]"]) == pytest.approx(float(row["predicted [arcsec]"]), rel=0.05)


def test_no_filter_is_better_than_the_bound():
    rows = VERTICAL.rows("Loss")
    assert all(float(row["bound"]) <= float(row["first order"]) for row in rows)
    assert max(float(row["loss"].removesuffix(" %")) for row in rows) > 40


def test_scenarios_and_coning_are_those_of_the_prototype():
    for row in VERTICAL.rows("Scenarios"):
        for name in ("fixed base", "acceleration", "oscillation"):
            if row[f"{name} expected"] != "-":
                assert float(row[f"{name} instant"]) == pytest.approx(float(row[f"{name} expected"]), rel=0.2)
    for row in VERTICAL.rows("Coning"):
        assert float(row["here"]) == pytest.approx(float(row["expected"]), rel=0.2)


def test_the_oscillation_is_that_of_the_closed_form():
    rows = VERTICAL.rows("Oscillation in closed form")
    assert len(rows) == 3
    for row in rows:
        for how in ("mean", "instant"):
            assert float(row[f"{how} simulated"]) == pytest.approx(float(row[f"{how} derived"]), rel=0.05)
        assert float(row["instant derived"]) == pytest.approx(float(row["expected"]), rel=0.2)


def test_a_vertical_takes_less_than_three_seconds_for_a_million_samples():
    assert max(float(row["s for 1e6 samples"]) for row in VERTICAL.rows("Speed")) < 3


CONSISTENCY = read("consistency.md")
WALK, MARKOV = "kalibr", "navego"
"""A target whose bias is a random walk, and one whose bias has a correlation time."""


def of_files(part, cover, target):
    """First numbers by outage, of each sensor: of the files of a target, with an accurate aid."""
    rows = CONSISTENCY.rows(f"{part}, aid to 0.1 deg")
    found = {row["sensor"]: row for row in rows if row["cover"] == cover and target in row["targets"].split(", ")}
    return {sensor: {t: first(row[f"{t} s"]) for t in OUTAGES} for sensor, row in found.items()}


def test_every_sensor_is_exported_to_every_target():
    for name, row in al.EXPORTS.items():
        for cover, (_, asked_of) in consistency.COVERS.items():
            found = of_files("Consistency", cover, name)
            assert not found or set(consistency.SENSORS) < set(found)
            assert bool(found) == bool(row.fields and asked_of(row)), (name, cover)
    assert {row["refused"] for row in CONSISTENCY.rows("Consistency, aid to 0.1 deg")} == {"0"}


def test_simulated_errors_of_filters_are_those_of_the_covariance():
    (off,) = re.search(r"is ([\d.]+) of its standard errors off", CONSISTENCY.head).groups()
    assert float(off) < 4


def test_filters_are_over_confident_without_a_cover():
    assert min(max(ratios.values()) for ratios in of_files("Consistency", "no", WALK).values()) > 1.3


@pytest.mark.parametrize(
    ("cover", "target", "until", "least"),
    # a random walk is not tight over three decades
    [
        ("default", WALK, 60, 0.7),
        ("default", MARKOV, 300, 0.7),
        ("1,100", WALK, 60, 0.7),
        ("1,100", MARKOV, 60, 0.7),
        ("1,1000", WALK, 1000, 0.55),
        ("1,1000", MARKOV, 1000, 0.7),
    ],
)
def test_errors_of_filters_are_those_that_are_predicted_on_the_span_of_the_cover(cover, target, until, least):
    for sensor, ratios in of_files("Consistency", cover, target).items():
        on = [ratio for t, ratio in ratios.items() if t <= until]
        assert least <= min(on) <= max(on) <= 1.1, (sensor, on)


@pytest.mark.parametrize(("cover", "most"), [("default", 1.04), ("1,100", 1.04), ("1,1000", 1.12)])
def test_a_cover_costs_little_soon_after_the_last_aid(cover, most):
    for target in (WALK, MARKOV):
        for sensor, losses in of_files("Accuracy", cover, target).items():
            assert max(losses[1], losses[10]) <= most, (sensor, losses)
