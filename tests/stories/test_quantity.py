"""The noise of an angle error and of a voltage, from the first command to every form of a result."""

import csv
import io
import json

import numpy as np
import pytest
from tests.commands import ends
from tests.rows import rows
from tests.verbs import run

import allanite as al

MODEL = "N 0.5 arcsec*sqrt(s), R 0.3 arcsec/s"
VOLTS = "N 1e-3 V*sqrt(s), K 2e-4 V/sqrt(s)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two runs of an angle in arcmin and one of a voltage, as text with headers."""
    where = tmp_path_factory.mktemp("quantity")
    for seed, (name, model, unit) in enumerate((("run1", MODEL, "arcmin"), ("run2", MODEL, "arcmin"),
                                                ("volts", VOLTS, "mV")), 1):  # fmt: skip
        record = al.simulate(al.Model(model), 6000, 10.0, rng=seed, unit=unit)
        rows = np.column_stack([np.arange(6000) / 10, record.values])
        np.savetxt(where / f"{name}.csv", rows, "%.10g", ",", header=f"t [s],az [{unit}]", comments="")
    return where


@pytest.fixture(scope="module")
def study(folder):
    run(f"analyze '{folder}/run1.csv' --kind value --json '{folder}/a.json' --report '{folder}/a.html' --quiet "
        f"--csv '{folder}/a.csv' --coefficients '{folder}/c.csv' --plot '{folder}/a.svg'")  # fmt: skip
    return json.loads((folder / "a.json").read_text())


@pytest.mark.slow("takes more than half a second")
def test_the_coefficients_are_those_of_the_angle(study):
    terms = {term["symbol"]: term for term in study["channels"][0]["fit"]["terms"]}
    for symbol, unit, value, near in (("N", "arcsec*sqrt(s)", 0.5, 0.1), ("R", "arcsec/s", 0.3, 0.05)):
        assert terms[symbol]["shown"]["unit"] == unit
        assert terms[symbol]["shown"]["value"] == pytest.approx(value, rel=near)
    assert (terms["N"]["unit"], study["channels"][0]["validity"]) == ("rad*sqrt(s)", "explained")


def test_page_tables_and_figure_name_the_angle(study, folder):
    page, figure = (folder / "a.html").read_text(), (folder / "a.svg").read_text()
    for text in (page, (folder / "c.csv").read_text()):
        assert "white noise of the angle" in text
        assert "angle random walk" not in text
        assert "rate random walk" not in text
    assert "arcsec" in figure
    rows = list(csv.DictReader(io.StringIO((folder / "a.csv").read_text())))
    assert {row["unit"] for row in rows} <= {"arcsec", "rad"}


@pytest.mark.slow("takes more than half a second")
@rows(
    "verb, more, unit",
    [("deviation", "--no-intervals --statistic oadev,mdev,ohdev", "arcsec"), ("dynamic", "", "arcsec"),
     ("spectrum", "", "(arcsec)^2/Hz")],
)  # fmt: skip
def test_curves_are_in_the_unit_of_the_angle(folder, verb, more, unit):
    out = folder / f"{verb}.csv"
    run(f"{verb} '{folder}/run1.csv' --kind value {more} --csv '{out}' --plot '{folder}/{verb}.svg' --quiet")
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert {row["unit"] for row in rows} == {unit}


UNSEEN = ("R: ohdev is insensitive to ramp of the angle", "flicker of the angle")


@pytest.mark.slow("analyses")
@rows("line, words, absent", [
    ("analyze run1.csv --method nnls --statistic ohdev", UNSEEN, "bias"),
    ("analyze run1.csv --method gls --statistic ohdev", UNSEEN, "bias"),
    ("analyze volts.csv", ("white noise of the voltage", "random walk of the voltage", "V*√s"), "angle"),
    ("compare run1.csv run2.csv", ("white noise of the angle",), "angle random walk"),
])  # fmt: skip
@pytest.mark.usefixtures("details")
def test_terms_are_named_by_the_quantity(folder, monkeypatch, line, words, absent):
    monkeypatch.chdir(folder)
    answer = run(f"{line} --kind value").stdout
    assert [text for text in words if text not in answer] == []
    assert absent not in answer


def test_other_programs_take_no_angle(folder):
    words = ("gyroscopes and accelerometers, not of 'az' (angle)", "'allanite analyze FILE --coefficients PATH'")
    ends(run(f"export '{folder}/run1.csv' --kind value --to kalibr", 3), 3, *words)
