"""An engineer with a ring laser gyro: which method, how accurate, where is north."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from tests import commands
from tests.commands import ends, of_verb
from tests.rows import rows

import allanite as al
from allanite.core.syntax import toml
from allanite.reporting import table
from allanite.simulation.record import GL1

HOW = ("--rate", "400", "--unit", "arcsec", "--kind", "count", "--scale", "0.32795")
NOISE = ("--noise", "N 0.000292 deg/sqrt(h), Q 0.2545 arcsec")


def counts(path, turning, seconds, seed=1, gyro=GL1):
    n = int(400 * seconds)
    record = al.simulation.simulate_ring_laser(gyro, turning, n, 400.0, rng=np.random.default_rng(seed))
    np.savetxt(path, record.values, fmt="%d", header="z", comments="")
    return str(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("rate")


@pytest.fixture(scope="module")
def vertical(folder):
    """20 minutes."""
    return counts(folder / "vertical.csv", 12.4392, 1200)


@pytest.fixture(scope="module")
def brief(folder):
    """4 minutes."""
    return counts(folder / "brief.csv", 12.4392, 240)


run = of_verb("rate")


@pytest.mark.slow("takes more than half a second")
def test_counts_are_analyzed_over_a_second(vertical):
    said = [commands.run("analyze", vertical, *HOW, *more).stdout for more in ((), ("--average", "1"))]
    assert [words in said[0] for words in ("quantization errors are not white", "Try --average 1")] == [True, True]
    assert ("model fits" in said[1], "Try" in said[1]) == (True, False)


@pytest.mark.slow("ensemble")
@pytest.mark.usefixtures("details")
def test_which_method(vertical):
    result = run(vertical, *HOW, *NOISE, "--latitude", "55.7936", "--bias", "-0.0948", "--no-times", code=0)
    assert "in 2 min: use optimal: 2.11 times better than averaging, and 8.9 % better than regression" in result.stdout
    assert "10 intervals of 2 min; errors against the true rate, 12.4392 °/h" in result.stdout
    for method in al.constant_rate.RATE_ESTIMATORS:
        assert f"\n  {method}" in result.stdout
    assert max(map(len, result.stdout.splitlines())) <= 120


@pytest.mark.slow("takes more than half a second")
@pytest.mark.usefixtures("details")
def test_the_noise_is_identified_where_none_is_given(vertical):
    result = run(vertical, *HOW, "--interval", "60", "--methods", "mean,regression")
    assert "the noise was identified from counts over 1 s" in result.stdout
    assert "Q = 0.2" in result.stdout


@pytest.mark.slow("ensemble")
@pytest.mark.usefixtures("details")
def test_the_scatter_against_the_measuring_time_is_a_table(vertical, tmp_path):
    page, numbers = tmp_path / "rate.html", tmp_path / "rate.csv"
    options = ("--methods", "mean,staircase", "--durations", "3,10", "--report", page, "--csv", numbers)
    result = run(vertical, *HOW, *NOISE, *options)
    lines = result.stdout.splitlines()
    rows = {(r["method"], float(r["duration_s"])): r for r in csv.DictReader(numbers.read_text().splitlines())}
    first, second = (lines.index(f"  {title} [°/h]") for title in (
        "std against the measuring time", "predicted std against the measuring time",
    ))  # fmt: skip
    for i, (name, duration) in enumerate((("3 s", 3.0), ("10 s", 10.0), ("2 min", 120.0)), 2):
        mean, staircase = (rows[method, duration] for method in ("mean", "staircase"))
        for line, key, more in ((first, "std", [mean["intervals"]]), (second, "predicted", [])):
            cells = (f"{float(row[key]):.3g}" for row in (mean, staircase))
            assert lines[line + i].split() == [*name.split(), *cells, *more]
    assert page.read_text(encoding="utf-8").count("td against the measuring time") == 2


@pytest.mark.slow("takes more than half a second")
@pytest.mark.usefixtures("details")
def test_one_short_record_gives_estimates(folder):
    path = counts(folder / "short.csv", 12.4392, 120, seed=3)
    result = run(path, *HOW, *NOISE, "--bias", "-0.0948")
    line = next(line for line in result.stdout.splitlines() if line.startswith("  optimal"))
    value, low, high = (float(line.replace("(", "").replace(")", "").split()[i]) for i in (1, 2, 4))
    assert low < value < high
    assert low - 0.003 < 12.4392 < high + 0.003


@pytest.mark.usefixtures("details")
def test_a_staircase_without_noise_has_certain_limits(folder):
    quiet = replace(GL1, lock_in=0.0, residual=0.0, bias=0.0)
    path = counts(folder / "quiet.csv", 12.4392, 120, gyro=quiet)
    result = run(path, *HOW, "--methods", "staircase", "--noise", "Q 0.0947 arcsec")
    line = next(line for line in result.stdout.splitlines() if line.startswith("  staircase"))
    low, high = (float(line.replace("(", "").replace(")", "").split()[i]) for i in (2, 4))
    assert low <= 12.4392 <= high
    assert high - low < 2e-5


WANDERING = "N 0.001 deg/sqrt(h), K 1 deg/h/sqrt(h)"
BAD = {
    "no latitude": (("--horizontal",), 2, "finding north needs the latitude"),
    "two references": (("--latitude", "50", "--reference", "3"), 2, "given twice"),
    "an unknown method": (("--methods", "mean,median"), 2, "Known rate estimators: mean, hamming"),
    "a term without unit": (("--noise", "N 0.003"), 2, "N must be followed by a number and a unit"),
    "a term that is no number": (("--noise", "N much deg/sqrt(h)"), 2, "expected a number"),
    "a bias in degrees": (("--bias", "3 deg"), 2, "has a unit such as deg/h"),
    "a bias of another sensor": (("--bias", "3 ug"), 3, "belongs to another type of sensor: accelerometer"),
    "no seconds": (("--interval", "0"), 2, "between 1e-15 and 1e+12 s"),
    "dither that folds onto zero": (("--dither", "400"), 2, "cannot be separated from a rate"),
    "no intervals": (("--most", "0"), 2, "must be between 1 and"),
    "too many lines": (("--lines", "60000"), 2, "do not fit into 48000 samples"),
    "an unknown target": (("--target", "end"), 2, "unknown target 'end'"),
    "a constant that wanders": (("--target", "constant", "--noise", WANDERING), 2, "drift is unbounded"),
    "a rate that the earth does not have": (("--horizontal", "--latitude", "80"), 3, "more than the earth turns"),
    "a second file that is the output": (("--second", "x.json", "--json", "x.json"), 2, "would overwrite"),
}


@rows("what", BAD)
def test_bad_choices_end_with_a_sentence(brief, what):
    options, code, words = BAD[what]
    noise = () if "--noise" in options else NOISE
    ends(run(brief, *HOW, *noise, "--no-times", *options), code, words)


@pytest.mark.usefixtures("details")
def test_lost_readings_are_named_or_split(folder):
    path = folder / "gaps.csv"
    values = np.random.default_rng(1).standard_normal(4000)
    text = ["z"] + [("nan" if i == 1234 else f"{v:.6f}") for i, v in enumerate(values)]
    path.write_text("\n".join(text) + "\n")
    how = ("--rate", "10", "--unit", "deg/h", "--kind", "rate", "--noise", "N 0.0053 deg/sqrt(h)", "--interval", "60")
    ends(run(path, *how), 3, "1 of 4000 samples of 'z' are not finite, the first at sample 1234")
    ends(run(path, *how, "--split-gaps"), 0, "1 sample missing")


@pytest.mark.slow("takes more than half a second")
def test_the_recipe_repeats_the_run(brief, tmp_path):
    """Whatever was chosen stands in the recipe, under the names of the command line."""
    own = (
        "--until", "200", "--interval", "30", "--methods", "mean,conditional", "--lines", "40", "--allowed", "1 deg/h",
        "--dither", "30.5", "--durations", "1,3", "--most", "6", "--reference", "12.4 deg/h", "--bias", "-0.0948",
        "--second", brief,
    )  # fmt: skip
    first = run(brief, *HOW, *NOISE, *own, "--json", "-")
    assert (first.exit_code, json.loads(first.stdout)["type"]) == (0, "RateStudy"), first.stderr
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(toml(json.loads(first.stdout)["recipe"]))
    assert run(brief, "--recipe", recipe, "--json", "-").stdout == first.stdout


def test_a_noise_that_explains_nothing_is_not_used():
    """The level of the noise doubles half way: no model explains it, at any rate of readings."""
    values = np.random.default_rng(1).standard_normal(20_000)
    values[10_000:] *= 2
    record = al.Record(values, rate=10.0, unit="deg/h", name="z")
    study = al.constant_rate.measure_rates(record)
    (channel,) = study.channels
    assert channel.noise.validity == "unexplained"
    assert channel.experiment.ranking is None
    assert "no predictions and no optimal method" in channel.alerts[0]
    assert "optimal is left out: it needs a noise model" in table(study)
    assert np.isnan(channel.experiment.predicted).all()
    stored = study.to_dict()["channels"][0]
    assert (stored["validity"], {term["status"] for term in stored["fit"]["terms"]}) == ("unexplained", {"not valid"})
    assert "in 2 min: use mean: in 16 intervals no other scatters less by more than 2 %" in table(study)


def test_counts_in_other_forms(brief, folder):
    """Whole numbers with a scale; with missing ones; their sum, which is no count; a pattern, which is no id."""
    how = ("--rate", "400", "--unit", "arcsec", "--scale", "0.32795", "--methods", "mean,staircase", "--no-times")
    values = np.loadtxt(brief, skiprows=1, dtype=int)
    path = folder / "other.csv"
    for cells, words in (
        (values, "read as count in arcsec"), (["nan", *values[1:]], "read as increment in arcsec"),
        (np.cumsum(values), "does not determine what a sample is"),
        (np.arange(96_000) % 2, "too few intervals to compare methods"),
    ):  # fmt: skip
        path.write_text("\n".join(map(str, ["z", *cells])))
        found = run(path, *how, *NOISE[: 2 * (words != "too few intervals to compare methods")], "--split-gaps")
        assert words in found.output
        assert found.exit_code or "\nstaircase " in found.stdout


def test_the_total_error_of_a_reversal(vertical, folder):
    """Two minutes in each of two positions, beside the rate that was simulated."""
    down, numbers = counts(folder / "down.csv", -12.4392, 1200, seed=2), folder / "reversal.csv"
    how = (*HOW, *NOISE, "--methods", "mean,regression", "--no-times", "--reference", "12.4392 deg/h")
    found = run(vertical, *how, "--second", down, "--csv", numbers)
    assert "total error" in found.stdout, found.output
    cells = {row["method"]: row for row in csv.DictReader(numbers.read_text().splitlines()) if row["intervals"] == "10"
             and row["positions"] == "2"}  # fmt: skip
    for row in cells.values():
        mean, std, total = (float(row[key]) for key in ("mean_error", "std", "total_error"))
        assert (row["duration_s"], total) == ("240.0", pytest.approx(np.hypot(mean, std * np.sqrt(0.9))))
        assert total < 2 * float(row["predicted"])
