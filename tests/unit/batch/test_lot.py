"""A lot: what is read from stored results is what the analysis of the files gives, and its tests keep their level."""

import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows
from tests.unit.batch.tasks import gyros, with_bad

import allanite as al
from allanite.batch.batch import Batch, BatchUnit
from allanite.batch.job import run_batch
from allanite.batch.lot import Spool, Trend, detectable, outliers, read_lot, slope_of
from allanite.batch.store import dumps, loads
from allanite.batch.tables import Across
from allanite.phrases.phrase import say, say_count
from allanite.reporting import table, to_csv
from allanite.reporting.views.batch import across_table
from allanite.study.results import Study

LIMITS = al.batch.Specification.from_toml({"limits": {"N": {"max": "0.15 deg/sqrt(h)"}}})
SIZES = [0.1, 0.11, 0.12, 0.13, 0.14, 0.16, 0.17]
WARM = [20, 25, 30, 35, 40, 50, 55]  # temperatures: N grows by 0.002 deg/sqrt(h) for each kelvin


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = with_bad(tmp_path_factory.mktemp("units"), SIZES)
    lines = ["file,unit_id,temperature,date", *(f"u{i}.csv,SN{i},{warm},2024-05-01" for i, warm in enumerate(WARM))]
    (folder / "manifest.txt").write_text("u0.csv\nu1.csv\nbad.csv\n")
    (folder / "manifest.csv").write_text("\n".join(lines) + "\n")
    recipe = al.Recipe(terms="N")
    run_batch(folder / "manifest.csv", folder / "results", recipe)
    run_batch(folder / "manifest.txt", folder / "few", recipe)
    return folder


@pytest.mark.slow("takes more than half a second")
def test_a_lot_is_what_the_analysis_of_the_files_gives(folder):
    files = [folder / name for name in ("bad.csv", "u0.csv", "u1.csv")]
    batch, lot = al.batch.analyze_files(files, al.Recipe(terms="N"), limits=LIMITS), read_lot(folder / "few", LIMITS)
    assert lot.batch.across == batch.across
    stored, made = ([(u.file, u.error, u.outcome, u.judgements) for u in units] for units in (lot.batch, batch))
    assert stored == made
    assert to_csv(lot, coefficients=True) == to_csv(batch, coefficients=True)
    assert to_csv(lot) == to_csv(batch)
    assert not lot.trends


@pytest.mark.slow("seconds of analyses")
def test_a_trend_over_temperature_is_found_and_none_where_all_dates_are_the_same(folder):
    lot = read_lot(folder / "results")
    (trend,) = [trend for trend in lot.trends if trend.symbol == "N"]
    assert trend.along == "temperature"
    assert trend.shown
    assert trend.low / trend.factor < 0.002 < trend.high / trend.factor
    assert [one.values.size for one in lot.distributions if one.symbol == "N"] == [len(SIZES)]
    assert not lot.outlying


def test_the_interval_of_a_slope_holds_the_true_one_as_often_as_it_says():
    rng = np.random.default_rng(1)
    at = np.linspace(0, 40, 8)
    limits = [slope_of(at, 3 + 0.1 * at + rng.standard_normal(8))[1:] for _ in range(1000)]
    assert np.mean([low < 0.1 < high for low, high in limits]) == pytest.approx(0.95, abs=0.025)


@rows("size", [4, 5, 14, 25])
def test_a_uniform_lot_has_an_outlying_unit_one_time_in_twenty(size):
    rng = np.random.default_rng(size)
    share = np.mean([bool(outliers(rng.standard_normal(size))) for _ in range(1000)])
    assert share == pytest.approx(0.05, abs=0.025)


def test_what_is_outlying_and_what_can_be_detected():
    values = np.random.default_rng(0).standard_normal(25)
    values[[3, 17]] = 7.0, 7.2
    assert (sorted(outliers(values)), outliers(np.ones(10))) == ([3, 17], [])
    assert [round(detectable(count)) for count in (4, 6, 10)] == [10, 5, 4]


def test_a_trend_is_shown_only_if_its_interval_excludes_zero():
    of = "gz", "N", LIMITS.limits[0].signal, "date", np.arange(9.0), np.ones(9)
    assert not Trend(*of, 1.0, -1.0, 3.0).shown
    assert Trend(*of, -1.0, -2.0, -0.5).shown


@pytest.mark.slow("takes more than half a second")
def test_few_units_are_tested_or_said_not_to_be(folder, tmp_path):
    few = table(read_lot(folder / "few"))
    assert "Not tested for outlying units: no coefficient has values of 4 units." in few
    assert "No unit is outlying" not in few
    assert "quantiles" not in few
    (tmp_path / "units").mkdir()
    gyros(tmp_path / "units", (0.12, 0.1, 0.1, 0.1, 0.1), 30_000)
    run_batch(tmp_path / "units", tmp_path / "results", al.Recipe(terms="N"))
    lot = read_lot(tmp_path / "results")
    assert [Path(one.file).name for one in lot.outlying if one.symbol == "N"] == ["u0.csv"]
    assert "of 5 units one is found" in " ".join(table(lot).split())


def test_numbers_of_some_units_say_of_how_many():
    found = Across("gz", "K", LIMITS.limits[0].signal, 4, 2, 1.0, 0.1, 1.1, "u1.csv", 0.9)
    batch = Batch((BatchUnit("u1.csv", error="x"),), {}, 0.95, None, (), {})
    assert [cell.endswith(" (of 2)") for cell in across_table(batch, [found]).rows[0][3:6]] == [True, True, False]


def test_exit_codes(folder, tmp_path):
    (tmp_path / "spec.toml").write_text('[limits]\nN = { max = "0.15 deg/sqrt(h)" }\n')
    ends(run("lot", folder / "results", "--limits", tmp_path / "spec.toml"), 4, "u6.csv")
    ends(run("lot", folder / "few", "--lang", "ru"), 5, "bad.csv")


def test_what_cannot_be_shown_is_said(folder, tmp_path):
    refused(al.UsageError, "results of a batch", lambda: read_lot(folder))
    (tmp_path / "bad.txt").write_text(str(folder / "bad.csv"))
    run_batch(tmp_path / "bad.txt", tmp_path / "none")
    refused(al.DataError, r"no file has a result in .*no rows of numbers", lambda: read_lot(tmp_path / "none"))
    shutil.copytree(folder / "few", tmp_path / "few")
    for part in (tmp_path / "few" / "parts").iterdir():
        part.write_bytes(b"PAR1")
    refused(al.DataError, r"cannot be read .*; run the batch again", lambda: read_lot(tmp_path / "few"))


def test_a_stored_phrase_is_still_one():
    text = dumps({"what": say("at {f:g} Hz", f=2.5), "name": "gx"})
    assert text == '{"name": "gx", "what": {"say": ["at {f:g} Hz"], "with": {"f": 2.5}}}'
    assert loads(text)["what"] == "at 2.5 Hz"
    phrase = say("{what}: {n}", what=say("minimum"), n=np.int64(3))
    assert loads(dumps([phrase]))[0].fields["what"].templates == ("minimum",)
    assert loads(dumps(say_count(2, "{count} sample", "{count} samples"))) == "2 samples"


def test_a_unit_of_a_lot_holds_no_study_and_is_stored_and_pickled_as_any_other(folder):
    lot = read_lot(folder / "few", LIMITS)
    unit = next(unit for unit in lot.batch if not unit.error)
    assert not any(isinstance(held, Study) for held in vars(unit).values())
    again = pickle.loads(pickle.dumps(unit))
    assert type(again) is BatchUnit
    assert again.to_dict() == unit.to_dict() == BatchUnit.from_dict(unit.to_dict()).to_dict()
    assert unit.study.channels[0].fit["N"].value == again.study.channels[0].fit["N"].value
    assert type(lot).from_dict(lot.to_dict()).to_dict() == lot.to_dict()
    assert len(Spool().put(Study((), al.Recipe(), (), (), {}))().channels) == 0
