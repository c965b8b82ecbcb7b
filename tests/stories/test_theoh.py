"""TheoH to its end: the options of a curve, what they change, and what is refused."""

import csv
import io
import json

import numpy as np
import pytest
from tests import commands
from tests.commands import ends
from tests.rows import rows
from tests.verbs import run

import allanite as al

MIXTURE = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h), R 5 deg/h^2"
WHITE = "--model 'N 0.1 deg/sqrt(h)' --rate 1"


def shown(path, line):
    """What a command says of the deviation of a file."""
    return run(f"deviation '{path}' {line}").stdout


def cells(path, line):
    return list(csv.DictReader(io.StringIO(shown(path, f"{line} --csv -"))))


def column(path, line, name="deviation", kind=float):
    return [kind(row[name]) for row in cells(path, line)]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "fog.csv"
    run(f"simulate '{path}' --model '{MIXTURE}' --duration 7200 --rate 1")
    return path


@pytest.fixture(scope="module")
def record(file):
    return al.read(file)["gx"]


@pytest.mark.slow("takes more than half a second")
@pytest.mark.usefixtures("details")
def test_a_jump_is_told_and_its_cure_works(file):
    said = " ".join(shown(file, "--statistic theoh --bias plain").split())
    for words in ("the bias ratio of theoh assumes one kind of noise", "times the Allan deviation at 1536 s",
                  "(--bias model corrects it)", "theoh jumps there, where it passes from oadev to TheoBR"):  # fmt: skip
        assert words in said
    assert "jumps" not in shown(file, "--statistic theoh --bias model")
    assert "jumps" not in shown(file, "--statistic theoh")  # it is the default
    late, right = (column(file, f"--statistic theoh --bias {bias}")[-2:] for bias in ("plain", "model"))
    assert all(b > 1.1 * a for a, b in zip(late, right, strict=True))


@pytest.mark.usefixtures("details")
def test_one_kind_of_noise_has_no_jump(tmp_path):
    run(f"simulate '{tmp_path}/white.csv' {WHITE} --duration 3600")
    said = shown(tmp_path / "white.csv", "--statistic theobr,theoh --bias plain --terms N")
    assert "TheoH" in said
    assert "assumes one kind" not in said


def test_the_first_screen_says_that_a_fit_of_a_curve_is_not_tested(file):
    said = run(f"analyze '{file}' --method curve --statistic theoh").stdout
    assert ("model not tested" in said, "model fits" in said) == (True, False)


def test_a_bias_is_for_the_statistics_that_have_it(file):
    both = cells(file, "--statistic oadev,theoh --bias model --no-intervals")
    assert ({row["statistic"] for row in both}, {row["low"] for row in both}) == ({"oadev", "theoh"}, {""})


def test_published_degrees_of_freedom(tmp_path, record):
    run(f"simulate '{tmp_path}/white.csv' {WHITE} --samples 7200")
    line = "--statistic theo1 --edf published --m 10,100,720,3600 --power-law"
    white = {int(row["m"]): float(row["edf"]) for row in cells(tmp_path / "white.csv", line) if row["alpha"] == "0"}
    table = {10: 3139, 100: 387, 720: 51.6, 3600: 7.8}
    assert set(white) >= {10, 100, 720}
    assert white == pytest.approx({m: table[m] for m in white}, rel=0.01)
    own, other = (al.deviation(record, "oadev", m=[8], noise=al.N(1.0, "deg/sqrt(h)"), **more)
                  for more in ({"edf": "published"}, {}))  # fmt: skip
    assert own.edf[0] == pytest.approx(other.edf[0], rel=0.15)
    assert "with published degrees of freedom" in own.supposed
    mixed = al.deviation(record, "oadev", m=[8], noise=al.Model("N 1 deg/sqrt(h), B 1 deg/h"), edf="published")
    with pytest.raises(al.UsageError):
        mixed.interval()


@pytest.mark.usefixtures("details")
def test_the_power_law_is_a_column(file):
    laws = column(file, "--power-law", "alpha", int)
    assert (laws[:3], laws[-1], set(column(file, "", "alpha", str))) == ([0, 0, 0], -2, {""})
    said = shown(file, "--power-law")
    assert "power law, less a ramp" in said
    assert "f^-2" in said
    assert json.loads(shown(file, "--power-law --json -"))["channels"][0]["values"][0]["alpha"] == laws


def test_means_come_before_anything_else(file, record):
    line = "--average 10 --from 100 --no-intervals --m 1,2,4"
    means = record.values[:7200].reshape(-1, 10).mean(axis=1)[10:]
    wanted = al.deviation(al.Record(means, rate=0.1, unit="deg/h", kind="rate"), m=[1, 2, 4], noise=None).to("deg/h")
    np.testing.assert_allclose(column(file, line), wanted.deviation, rtol=1e-9)
    assert column(file, line, "tau_s") == [10.0, 20.0, 40.0]


@rows("options, words", [
    ("--edf foo", "edf must be 'exact' or 'published', not 'foo'"),
    ("--edf published --no-intervals", "they need intervals"),
    ("--edf published --statistic pdev", "no degrees of freedom of pdev are published"),
    ("--join 2 --statistic theoh", "it must be above 0 and at most 1, not 2"),
    ("--divisor 7 --statistic theoh", "must be 30 (as published) or 6 (as in Stable32), not 7"),
])  # fmt: skip
def test_wrong_options_are_refused(file, options, words):
    ends(commands.run("deviation", file, *options.split()), 2, words)
