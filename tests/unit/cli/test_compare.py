"""``allanite compare`` and what it writes: text, page, figure, JSON, CSV, exit codes."""

import csv
import io
import json

import numpy as np
import pytest
from tests import thinned
from tests.commands import ends, of_verb
from tests.rows import rows

import allanite as al
from allanite.reporting import page, table

MODEL = al.N(0.3, "deg/sqrt(h)") + al.K(300, "deg/h/sqrt(h)")


run = of_verb("compare")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("data")
    for seed, (name, factor) in enumerate((("before", 1.0), ("after", 0.8), ("third", 1.0)), 1):
        records = [al.simulate(MODEL, 4096, 100.0, rng=10 * seed + i, name=channel) for i, channel in enumerate("xy")]
        scaled = [al.Record(r.values * factor, 100.0, r.unit, name=r.name) for r in records]
        al.write(al.Recording(tuple(scaled)), place / f"{name}.csv")
    return place


@pytest.mark.slow("takes more than half a second")
def test_before_and_after(folder, tmp_path):
    suffixes = {"report": "html", "plot": "svg", "json": "json", "csv": "csv"}
    paths = {name: tmp_path / f"out.{end}" for name, end in suffixes.items()}
    asked = [part for name, path in paths.items() for part in (f"--{name}", path)]
    result = run(folder / "before.csv", folder / "after.csv", "--channels", "x", *asked)
    ends(result, 0, "the noise has changed", "not resolvable in these records")
    assert result.stdout.splitlines()[-4:] == [f"{name}: {path}" for name, path in paths.items()]
    data = json.loads(paths["json"].read_text("utf-8"), parse_constant=pytest.fail)
    (channel,) = data["channels"]
    assert (data["type"], channel["changed"]) == ("Comparison", True)
    n = next(term for term in channel["terms"] if term["symbol"] == "N")
    assert n["outcome"] == "smaller"
    assert n["low_percent"] < -20 < n["high_percent"]
    rows = list(csv.DictReader(io.StringIO(paths["csv"].read_text("utf-8"))))
    assert [row["quantity"] for row in rows][:6] == [*"QNBKR", "oadev"]
    assert float(rows[1]["change_percent"]) == pytest.approx(n["change_percent"])
    first = rows[5]
    assert float(first["change_percent"]) == pytest.approx(100 * (float(first["after"]) / float(first["before"]) - 1))
    assert float(first["low_percent"]) < float(first["change_percent"]) < float(first["high_percent"])
    page = paths["report"].read_text("utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert "°/√h" in page
    assert page.count("<script") == 1  # its own
    assert "http" not in page.split("<body>")[1].replace("http://www.w3.org", "")
    assert paths["plot"].read_text("utf-8").startswith("<?xml")
    ends(run(folder / "before.csv", folder / "after.csv", "--channels", "x", "--json", paths["json"]), 2, "--force")


@pytest.mark.slow("takes more than half a second")
def test_channels_of_one_file_and_of_two(folder):
    both = (folder / "before.csv", folder / "after.csv")
    crossed = (*both, "--channels", "x", "--against", "y")
    for words, names in ((both[:1], ["x / y"]), (crossed, ["x / y"]), ((*both, "--quiet"), ["x", "y"])):
        channels = json.loads(run(*words, "--json", "-").stdout)["channels"]
        assert [channel["name"] for channel in channels] == names


@pytest.mark.slow("takes more than half a second")
def test_several_files_are_pooled(folder, tmp_path):
    files = [folder / f"{name}.csv" for name in ("before", "after", "third")]
    paths = tmp_path / "pool.html", tmp_path / "pool.png", tmp_path / "pool.csv"
    done = run(*files, "--channels", "x", "--report", paths[0], "--plot", paths[1], "--csv", paths[2])
    ends(done, 0, "different from the others: after.csv", "record by record")
    assert "record by record" in paths[0].read_text("utf-8").lower()
    assert paths[1].read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader(io.StringIO(paths[2].read_text("utf-8"))))
    n = next(row for row in rows if row["quantity"] == "N")
    assert float(n["after.csv"]) == pytest.approx(0.8 * float(n["before.csv"]), rel=0.05)
    curve = next(row for row in rows if row["quantity"] == "oadev")
    assert float(curve["low"]) < float(curve["common"]) < float(curve["high"])


def test_a_part_against_the_rest(folder):
    ends(run(folder / "before.csv", "--channels", "x", "--part", "20"), 0, "first 20 s", "whole")


@rows("arguments, words", [
    ((), ["FILE"]), (("before.csv", "--channels", "x"), ["one channel", "--part"]),
    (("before.csv", "after.csv", "--part", "20"), ["--part splits a single file"]),
    (("before.csv", "--against", "y"), ["--against"]), (("before.csv", "after.csv", "--channels", "q"), ["'q'", "x"]),
    (("before.csv", "after.csv", "--statistic", "mtie"), ["mtie", "oadev"]),
])  # fmt: skip
def test_bad_input(folder, monkeypatch, arguments, words):
    monkeypatch.chdir(folder)
    ends(run(*arguments), 2, *words)


@pytest.mark.slow("takes more than half a second")
def test_a_name_that_would_do_harm_and_a_model_that_does_not_explain():
    rng, name = np.random.default_rng(1), "<script>alert(1)</script>\x1b[31m"
    plain, other = (al.simulate(MODEL, 20_000, 100.0, rng=rng, name=name) for _ in range(2))
    rising = al.Record(other.values * np.repeat([1.0, 1.6], 10_000), 100.0, other.unit, name=name)
    compared = al.compare(plain, rising)
    shown = page(compared)
    assert shown.count("<script") == 1  # its own
    assert "\x1b" not in table(compared)
    (pair,) = compared.pairs
    assert pair.explained == (True, False)
    assert pair.alerts[0].startswith("record 2: ")
    assert "noise level" in pair.alerts[0]
    assert pair.grades[0] == "explained"
    assert "may appear as a change of one of its terms" in pair.alerts[0]
    assert '<li class="alert">' in shown


@rows("arguments", thinned([
    ["before.csv", "after.csv", "--channels", "x", "--against", "y", "--terms", "QNK", "--band", "0.1,40"],
    ["before.csv", "--part", "25", "--until", "40", "--level", "0.9", "--outliers", "keep"],
    ["before.csv", "after.csv", "third.csv", "--statistic", "ohdev", "--taus", "0.1,1", "--quiet-window", "30"],
], 1))  # fmt: skip
def test_the_recipe_that_is_told_repeats_the_result(folder, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(folder)
    files = [argument for argument in arguments if argument.endswith(".csv")]
    first = json.loads(run(*arguments, "--json", "-").stdout)
    path = tmp_path / "recipe.toml"
    path.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in first["recipe"].items()))
    assert json.loads(run(*files, "--recipe", path, "--json", "-").stdout) == first


@pytest.mark.slow("takes more than half a second")
def test_every_file_is_read_with_the_options_and_named(folder, tmp_path):
    paths = [tmp_path / f"{name}.bin" for name in ("before", "after")]
    for path in paths:
        al.read(folder / f"{path.stem}.csv")["x"].values.astype("<f4").tofile(path)
    found = run(*paths, "--dtype", "f4", "--rate", "100", "--unit", "rad/s", "--kind", "rate", "--json", "-", code=0)
    wanted = json.loads(run(folder / "before.csv", folder / "after.csv", "--channels", "x", "--json", "-").stdout)
    terms = [data["channels"][0]["terms"][1]["change_percent"] for data in (json.loads(found.stdout), wanted)]
    assert terms[0] == pytest.approx(terms[1], abs=0.01)
    # a doubtful clock is said with the name of its file
    x = al.read(folder / "before.csv")["x"]
    time = (np.arange(x.size) + 0.3 * np.random.default_rng(1).standard_normal(x.size)) / 100
    path = tmp_path / "jittered.csv"
    path.write_text("t [s],x [rad/s]\n" + "".join(f"{t:.6f},{v:.9g}\n" for t, v in zip(time, x.values, strict=True)))
    found = run(folder / "after.csv", path, "--channels", "x", "--json", "-", code=0)
    (finding,) = json.loads(found.stdout)["findings"]
    assert finding["what"].startswith("jittered.csv: ")
    assert run(folder / "after.csv", path, "--channels", "x").stdout.count("jittered.csv: ") == 2
