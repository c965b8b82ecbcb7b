"""Many units: which files are meant, what a limits file may say, what passes, and what one bad file does."""

import csv
import dataclasses
import io
import json

import numpy as np
import pytest
from tests.commands import ends, of_verb
from tests.rows import refused, rows

import allanite as al
from allanite.batch.sources import expand, several
from allanite.batch.specification import Seen, judge
from allanite.reporting import page

N_ONLY = '[limits]\nN = { max = "0.15 deg/sqrt(h)" }\n'

run = of_verb("analyze")


def unit(path, size, seed, name="gz"):
    noise = al.N(size, "deg/sqrt(h)" if "g" in name else "m/s/sqrt(h)")
    al.write(al.simulate(noise, 3000, 10.0, rng=seed, name=name), path)
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("units")
    for i, size in enumerate((0.1, 0.2)):
        unit(folder / f"u{i}.csv", size, i)
    (folder / "readme.txt").write_text("12 gyros\n")
    (folder / "deep").mkdir()
    unit(folder / "deep" / "u9.csv", 0.1, 9)
    return folder


def spec(tmp_path, text):
    (tmp_path / "spec.toml").write_text(text)
    return tmp_path / "spec.toml"


def test_files_folders_and_patterns_name_units(folder):
    u0, u1, deep = (str(folder / name) for name in ("u0.csv", "u1.csv", "deep/u9.csv"))
    found = expand([folder])
    assert found.files == (u0, u1)
    assert found.notes == (f"left out of {folder}, by their names not recordings: readme.txt",)
    assert expand([f"{folder}/*.csv"]).files == (u0, u1)
    assert set(expand([f"{folder}/**/*.csv"]).files) == {u0, u1, deep}
    assert expand([u1, folder, "-"]).files == (u1, u0, "-")  # none twice
    assert expand([folder], besides=[u1, None]).files == (u0,)


def test_names_that_stand_for_nothing_and_that_look_like_a_pattern(folder, tmp_path):
    refused(al.DataError, r"no file matches '.*\*\.npz'", lambda: expand([f"{folder}/*.npz"]))
    refused(al.DataError, "holds no recording", lambda: expand([tmp_path]))
    path = unit(tmp_path / "u[1].csv", 0.1, 0)
    assert not several([path])
    assert expand([path]).files == (str(path),)
    names = (["gyro.csv"], ["-"], ["a.csv", "b.csv"], ["units/*.csv"])
    assert list(map(several, names)) == [False, False, True, True]


@rows("text, words", [
    ('[limits]\nX = { max = "1 deg/h" }', "unknown term 'X' in [limits]; known terms: Q, F, N, B"),
    ('[limits]\nSine = { max = "1 deg/h" }', "unknown term 'Sine'"),
    ('[limits]\nN = { max = "0.15 deg/h" }', "'deg/h' is not a unit of N (angle random walk)"),
    ('[limits]\nminimum = { max = "1 deg/sqrt(h)" }', "'deg/sqrt(h)' is not a unit of a minimum"),
    ('[limits]\nN = "0.15 deg/sqrt(h)"', 'written as N = { max = "0.15 deg/sqrt(h)" }'),
    ("[limits]\nN = { max = 0.15 }", "with the unit; {'max': 0.15} came"),
    ('[limits]\nN = { max = "0.15" }', "a positive number with a unit"),
    ('[limits]\nN = { max = "-1 deg/sqrt(h)" }', "a positive number with a unit"),
    ('[limits]\nN = { max = "0.15 deg/sqrt(h)", min = "0" }', "unknown key 'min' in the limit of N"),
    ('[limits]\nN = [{ max = "1 deg/sqrt(h)" }, { max = "2 deg/sqrt(h)" }]', "two limits for a gyro"),
    ('[limit]\nN = { max = "1 deg/sqrt(h)" }', "unknown key 'limit' in the limits file"),
    ("[limits]\n", "there is no limit in it"), ("limits = 3\n", "limits is a table"), ("[limits", "the limits file"),
])  # fmt: skip
def test_a_wrong_limits_file_is_refused_before_anything_is_read(tmp_path, text, words):
    path = spec(tmp_path, text)
    ends(run(tmp_path / "missing.csv", "--limits", path), 2, words, "spec.toml")


def test_limits_of_one_channel_replace_those_of_all(tmp_path):
    text = N_ONLY + '[channels.gx]\nN = { max = "0.3 deg/sqrt(h)" }\n'
    found = al.batch.Specification.load(spec(tmp_path, text))
    gyro = found.limits[0].signal
    assert [limit.words() for limit in found.of("gz", gyro)] == ["0.15 deg/sqrt(h)"]
    assert [limit.words() for limit in found.of("gx", gyro)] == ["0.3 deg/sqrt(h)"]


@pytest.mark.slow("takes more than half a second")
def test_a_limit_of_another_kind_of_sensor_is_named(folder, tmp_path):
    path = spec(tmp_path, '[channels.gz]\nN = { max = "0.3 m/s/sqrt(h)" }\n')
    ends(run(folder, "--limits", path), 2, "the limit of N for the channel 'gz' is in m/s/sqrt(h)")
    # one that fits no channel passes nothing
    limits = spec(tmp_path, '[limits]\nN = { max = "1 m/s/sqrt(h)" }\n')
    ends(run(folder / "u0.csv", "--limits", limits), 0, "1 unit: 1 not decided")
    assert run(folder / "u0.csv", "--limits", limits, "--strict").exit_code == 3


@pytest.mark.slow("takes more than half a second")
def test_limits_of_two_kinds_of_sensors_stand_beside_each_other(tmp_path):
    text = '[limits]\nN = [{ max = "0.15 deg/sqrt(h)" }, { max = "0.01 m/s/sqrt(h)" }]\n'
    files = [unit(tmp_path / "g.csv", 0.1, 0), unit(tmp_path / "a.csv", 0.1, 0, "ax")]
    batch = al.batch.analyze_files(files, limits=spec(tmp_path, text))
    assert [u.outcome for u in batch] == ["pass", "fail"]


LIMIT = al.batch.Specification.from_toml({"limits": {"B": {"max": "2 deg/h"}}}).limits[0]


def scaled(seen):
    """What was seen in deg/h, in SI."""
    return Seen(*(v if v is None else v * LIMIT.factor for v in seen[:4]), seen.reason)


@rows(("seen", "outcome"), [
    (Seen(1.0, 0.8, 1.2), "pass"), (Seen(1.9, 1.7, 2.1), "not decided"), (Seen(2.1, 1.9, 2.3), "not decided"),
    (Seen(2.4, 2.1, 2.7), "fail"), (Seen(1.0), "pass"), (Seen(3.0), "fail"),  # a method without intervals
    (Seen(2.4, 2.1, 2.7, 2.7), "not decided"), (Seen(1.4, 1.1, 1.7, 1.7), "pass"),  # a curve that still falls
    (Seen(upper=1.5), "pass"), (Seen(upper=2.5), "not decided"), (Seen(reason="not valid"), "not decided"),
])  # fmt: skip
def test_the_rule(seen, outcome):
    assert judge("gz", LIMIT, scaled(seen)).outcome == outcome


@rows(("seen", "words"), [
    (Seen(1.9, 1.7, 2.1), "1.90 (1.70 .. 2.10) deg/h"), (Seen(upper=3.0), "not identified, below 3.0 deg/h"),
])  # fmt: skip
def test_a_judgement_is_shown(seen, words):
    assert repr(judge("gz", LIMIT, scaled(seen))) == f"<Judgement 'gz': B not decided, {words}>"


@pytest.mark.slow("takes more than half a second")
def test_the_size_of_a_ramp_is_judged(tmp_path):
    model = al.N(0.01, "deg/sqrt(h)") + al.R(2000.0, "deg/h^2")
    record = al.simulate(model, 3000, 10.0, rng=0, name="gz")
    falling = dataclasses.replace(record, values=-record.values)
    al.write(record, tmp_path / "u0.csv")
    al.write(falling, tmp_path / "u1.csv")
    for most, outcome in (("1500", "fail"), ("2500", "pass")):
        limits = spec(tmp_path, f'[limits]\nR = {{ max = "{most} deg/h^2" }}\n')
        assert [u.outcome for u in al.batch.analyze_files(tmp_path, limits=limits)] == [outcome] * 2


def test_a_channel_that_is_missing_and_a_term_that_was_not_asked_for_are_not_shown(folder, tmp_path):
    text = '[limits]\nK = { max = "1 deg/h/sqrt(h)" }\n[channels.gx]\nN = { max = "0.15 deg/sqrt(h)" }\n'
    (found,) = al.batch.analyze_files(folder / "u0.csv", al.Recipe(terms="N"), limits=spec(tmp_path, text))
    reasons = ["'K' is not a term of this fit; its terms: N", "there is no channel 'gx'"]
    assert [(j.outcome, j.reason) for j in found.judgements] == [("not decided", reason) for reason in reasons]
    assert found.outcome == "not decided"


@pytest.mark.slow("seconds of analyses")
@rows(("files", "limits", "code"), [
    (["u0.csv", "u1.csv"], None, 0), (["u0.csv"], N_ONLY, 0), (["u0.csv", "u1.csv"], N_ONLY, 4),
    (["u0.csv", "missing.csv"], None, 5), (["u0.csv", "missing.csv"], N_ONLY, 5),
    (["u1.csv", "missing.csv"], N_ONLY, 4),  # what was exceeded stays exceeded
    (["missing.csv", "gone.csv"], N_ONLY, 3),
])  # fmt: skip
def test_exit_codes(folder, tmp_path, files, limits, code):
    options = [] if limits is None else ["--limits", spec(tmp_path, limits)]
    result = run(*(folder / name for name in files), *options, code=code)
    for name in ("missing.csv", "gone.csv"):
        assert (name in result.stdout + result.stderr) == (name in files)


def test_where_the_mistake_is_that_of_the_command_it_is_said_once(folder):
    result = run(folder, "--terms", "XYZ")
    assert (result.exit_code, result.stderr.count("unknown term")) == (2, 1)
    assert "u0.csv" in result.stderr


@pytest.mark.slow("takes more than half a second")
def test_standard_input_is_a_file(folder, tmp_path):
    data = (folder / "u0.csv").read_bytes()
    found = json.loads(run("-", "--json", "-", input=data).stdout)
    named = json.loads(run(folder / "u0.csv", "--json", "-").stdout)
    assert found["channels"] == named["channels"]
    assert found["provenance"]["source"] == "standard input"
    ends(run("-", folder / "u1.csv", input=data), 0, "standard input")
    ends(run("-", input=b""), 3, "standard input: nothing came")
    ends(run("-", input=b"what is this\n"), 3, "standard input: no rows of numbers")


@pytest.mark.slow("takes more than half a second")
def test_the_table_of_coefficients_has_a_row_for_everything(folder, tmp_path):
    result = run(folder, folder / "missing.csv", "--limits", spec(tmp_path, N_ONLY), "--table", "-")
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    judged = {row["file"]: row["result"] for row in rows if row["term"] == "N"}
    assert judged == {str(folder / "u0.csv"): "pass", str(folder / "u1.csv"): "fail"}
    first = next(row for row in rows if row["term"] == "N")
    assert (first["channel"], first["unit"], first["status"]) == ("gz", "deg/sqrt(h)", "identified")
    assert float(first["low"]) < float(first["value"]) < float(first["high"])
    assert (rows[-1]["file"], rows[-1]["status"]) == (str(folder / "missing.csv"), "not analyzed")
    assert "no such file" in rows[-1]["remark"]
    alone = run(folder / "u0.csv", "--coefficients", "-").stdout
    assert alone == run(folder / "u0.csv", "--table", "-").stdout
    assert alone.startswith("channel,term,")


@pytest.mark.slow("takes more than half a second")
def test_outputs_in_the_folder_are_no_units(folder, tmp_path):
    unit(tmp_path / "u0.csv", 0.1, 0)
    for _ in range(2):
        ends(run(tmp_path, "--table", tmp_path / "table.csv", "--force"), 0, "1 of 1 unit analyzed")


@pytest.mark.slow("takes more than half a second")
def test_a_batch_holds_mean_spread_and_worst_but_no_samples(folder):
    batch = al.batch.analyze_files(folder)
    found = {one.symbol: one for one in batch.across}
    values = [u.study["gz"].fit["N"].value for u in batch]
    assert found["N"].mean == pytest.approx(np.mean(values))
    assert found["N"].deviation == pytest.approx(np.std(values, ddof=1))
    assert (found["N"].worst, found["N"].file, found["K"].identified) == (max(values), str(folder / "u1.csv"), 0)
    assert found["K"].below == max(u.study["gz"].fit["K"].upper for u in batch)
    assert np.isnan(found["K"].mean)
    assert (page(batch).count("<figure"), page(batch).count("<details>")) == (1, len(batch))
    record = batch[0].study["gz"].record
    assert not isinstance(record, al.Record)
    assert (record.size, record.rate, record.name) == (3000, 10.0, "gz")
    refused(al.UsageError, "no unit 'x'", lambda: batch["x"])
    said = run(folder, "--device", "mems").stdout
    assert said.count("N in a micromechanical (MEMS) gyroscope: angle random walk\n") == 1
