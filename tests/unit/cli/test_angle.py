"""allanite angle: from a CSV to a table, a page, JSON, a corrected file; and what it refuses."""

import csv
import io
import json
import os
import tempfile

import numpy as np
import pytest
from tests.commands import ends, of_verb
from tests.rows import rows

import allanite as al
from allanite.cli import angle, following
from allanite.core.syntax import toml
from allanite.readers import live
from allanite.reporting import figures, page, table
from allanite.reporting.printing import printed

ARCSEC = np.pi / 648_000
EXPERIMENT = ["--latitude", "60", "--duration", "3600"]


run = of_verb("angle")


@pytest.fixture(scope="module")
def gimbal(tmp_path_factory):
    path = tmp_path_factory.mktemp("angle") / "hour.csv"
    errors = ["--error", "h:128=3,-1.5", "--error", "q:128=0,2", "--error", "q:256=-1,0.5"]
    run("simulate", path, *EXPERIMENT, "--start", 7200, *errors, code=0)
    return path


@pytest.fixture(scope="module")
def encoder(tmp_path_factory):
    path = tmp_path_factory.mktemp("angle") / "encoder.csv"
    true = np.linspace(0, 12.5, 4000)
    known = al.angle.Harmonics.of({128: (20 * ARCSEC, 5 * ARCSEC)})
    measured = known.read(true) + ARCSEC * np.random.default_rng(1).standard_normal(4000)
    data = np.degrees(np.mod(np.column_stack([measured, true]), 2 * np.pi))
    np.savetxt(path, data, delimiter=",", fmt="%.10g", header="enc [deg],ref [deg]", comments="")
    return path


def estimate(path, *arguments, code=0):
    words = ("estimate", path, "--difference", "difference", "--latitude", 60, "--rho", "rho")
    return run(*words, *arguments, code=code)


def table_of(text):
    """Rows of a table by the names of their constants."""
    return {row["constant"]: row for row in csv.DictReader(io.StringIO(text))}


@pytest.mark.slow("takes more than half a second")
def test_what_was_simulated_is_printed_and_everything_is_written(gimbal, tmp_path):
    names = {"report": "a.html", "plot": "a.png", "json": "a.json", "csv": "a.csv", "corrected": "b.csv"}
    done = estimate(gimbal, *(part for k, v in names.items() for part in (f"--{k}", tmp_path / v)))
    row = next(line.split() for line in done.stdout.splitlines() if line.split()[:2] == ["h", "128"])
    assert float(row[2]) == pytest.approx(3.0, abs=4 * float(row[3]))
    assert float(row[5]) == pytest.approx(-1.5, abs=4 * float(row[6]))
    assert "misalignment" in done.stdout
    written = tuple(f"{name}: " for name in names)
    assert all(len(line) <= 120 for line in done.stdout.splitlines() if not line.startswith(("file", *written)))
    assert sorted(os.listdir(tmp_path)) == sorted(names.values())
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert "--ink" in page
    assert page.count("<figure") == 4
    assert page.count("<script") == 1  # its own
    assert "harmonic 128 of h: 3." in page
    data = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert (data["type"], [h["name"] for h in data["harmonics"]]) == ("Calibration", ["h", "q"])
    assert len(data["provenance"]["sha256"]) == 64
    assert data["recipe"]["latitude"] == 60.0
    value = table_of((tmp_path / "a.csv").read_text())["S128 h"]["value"]
    assert float(value) == data["solution"]["constants"][0]["value"]
    before = np.genfromtxt(gimbal, delimiter=",", names=True, skip_header=1)["q_rad"]
    after = np.genfromtxt(tmp_path / "b.csv", delimiter=",", names=True)["q_rad"]
    found = al.angle.Harmonics.from_dict(data["harmonics"][1])
    np.testing.assert_allclose(after, before - found.at(before), atol=1e-14)


def test_an_encoder(encoder, tmp_path):
    done = run("calibrate", encoder, "--measured", "enc", "--reference", "ref", "--report", tmp_path / "e.html", code=0)
    row = next(line.split() for line in done.stdout.splitlines() if line.split()[:2] == ["enc", "128"])
    assert float(row[6]) == pytest.approx(np.hypot(20, 5), abs=0.2)
    assert "absent" in done.stdout
    assert "Harmonic errors of enc" in (tmp_path / "e.html").read_text(encoding="utf-8")


@pytest.mark.slow("takes more than half a second")
def test_plan_finds_the_window_of_the_paper_and_names_the_periods_of_each_start(tmp_path):
    done = run("plan", *EXPERIMENT, "--q-law", "linear", "--report", tmp_path / "p.html", "--plot", tmp_path / "p.svg")
    ends(done, 0, "h from 13.38 to 19.77°", "sum over the 8 amplitudes: 1.129")
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "h from 13.4 to 19.8°" in page
    assert page.count("<svg") == 1
    one = json.loads(run("plan", *EXPERIMENT, "--start", 0, "--sway", "1,60", "--json", "-").stdout)
    assert (one["type"], round(one["total"], 2)) == ("AnglePlan", 0.95)
    # periods stand beside the accuracy
    starts = ["--q-law", "linear", "--start", "0,3600,7200,10800,14400,18000"]
    lines = run("plan", *EXPERIMENT, *starts).stdout.splitlines()
    rows = {line.strip().split("  ")[0]: line.split()[-6:] for line in lines if line.strip()}
    assert rows["128 h"] == ["22.6", "23.9", "27.0", "34.1", "52.6", "154.2"]
    assert rows["sum / best"] == ["4.62", "1.25", "1", "1.24", "1.83", "7.69"]
    table = list(csv.DictReader(io.StringIO(run("plan", *EXPERIMENT, *starts, "--csv", "-").stdout)))
    assert float(table[0]["period 128 h [s]"]) / 60 == pytest.approx(22.4, abs=0.05)
    assert float(table[2]["total over best"]) == 1.0


def test_a_turned_ring_is_simulated_and_the_truth_stands_beside_the_estimate(tmp_path):
    path, ring = tmp_path / "ring.csv", ["--ring-rate", 2, "--ring-range", "-10,10", "--ring-step", 0.25]
    run("simulate", path, *EXPERIMENT, "--start", 10800, *ring, "--error", "h:128=3,-1.5", code=0)
    first, names, *_ = path.read_text().splitlines()
    assert first == "# simulated errors, arcsec: h:128=3,-1.5"
    assert "mu [rad]" in names
    done = estimate(path, "--details", "--json", tmp_path / "a.json", "--csv", tmp_path / "a.csv")
    ends(done, 0, " of 8 true amplitudes lie within their 95 % limits")
    assert json.loads((tmp_path / "a.json").read_text())["truth"]["C128 h"] == pytest.approx(-1.5 * ARCSEC)
    rows = table_of((tmp_path / "a.csv").read_text())
    assert float(rows["S128 h"]["true"]) == pytest.approx(3 * ARCSEC)
    assert (float(rows["S256 q"]["true"]), rows["ax"]["true"]) == (0.0, "")
    assert abs(float(rows["S128 h"]["value"]) - 3 * ARCSEC) < 4 * float(rows["S128 h"]["standard_error"])
    planned = run("plan", *EXPERIMENT, "--start", 10800, *ring, "--details")
    ends(planned, 0, "outer ring turned at 2 °/min between -10 and 10° about an axis at 0° from north")


@rows("arguments, words", [
    (["plan", *EXPERIMENT, "--ring-rate", 1, "--ring-range", "5"], "two angles in deg"),
    (["plan", *EXPERIMENT, "--ring-step", 1], "--ring-rate"),
    (["plan", *EXPERIMENT, "--sway", "1"], "amplitude in deg and period in s"),
    (["plan", *EXPERIMENT, "--start", 0, "--plot", "x.png"], "give more than one"),
    (["simulate", "x.csv", *EXPERIMENT], "at least one --error"),
    (["simulate", "x.csv", *EXPERIMENT, "--error", "h=1"], "h:128=3,-1.5"),
])  # fmt: skip
def test_refused(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ends(run(*arguments), 2, words)
    assert os.listdir(tmp_path) == []


@rows("options, code, words", [
    (["--difference", "z", "--latitude", 60], 2, "no column 'z'"),
    (["--difference", "difference", "--rho", "rho", "--latitude", 45], 0, "the motion of h and q gives the latitude"),
    (["--difference", "difference", "--rho", "rho", "--h", "q_polar"], 2, "give the latitude"),
    ([], 0, "from the motion of h and q"),
    (["--difference", "difference", "--latitude", 60, "--rho", "rho", "--turn-period", 300], 2, "the same rotation"),
    (["--difference", "difference", "--latitude", 60, "--rho", "rho", "--unit", "m"], 2, "cannot be converted"),
    (["--difference", "difference", "--latitude", 60, "--rho", "rho", "--sigma", "0.5"], 0, "times the sigma given"),
])  # fmt: skip
def test_estimate_refuses_or_warns(gimbal, options, code, words):
    ends(run("estimate", gimbal, *options), code, words)


def test_broken_files(tmp_path, gimbal):
    lines = gimbal.read_text().splitlines()[1:]
    broken = tmp_path / "broken.csv"
    broken.write_text("\n".join([*lines[:50], lines[40], *lines[50:]]))
    assert "time decreases at sample 49" in estimate(broken, code=3).stderr
    cells = lines[9].split(",")
    broken.write_text("\n".join([*lines[:9], ",".join([cells[0], "nan", *cells[2:]]), *lines[10:]]))
    ends(estimate(broken), 0, "1 row with a missing value is left out")
    broken.write_text("\n".join([lines[0].replace("[rad]", ""), *lines[1:]]))
    assert "'h', 'q', 'rho': the unit is unknown" in estimate(broken, code=2).stderr
    broken.write_text("\n".join(line.rsplit(",", 1)[0] for line in lines))
    assert "--nuisance A1,A2,A3" in run("estimate", broken).stderr
    broken.write_text("no numbers here\n")
    estimate(broken, code=3)


def test_any_format_and_header_is_read(gimbal, tmp_path):
    """.npz whose names hold no unit, ``difference [1]``, and Russian tables; the same numbers from each."""
    names, *lines = gimbal.read_text().splitlines()[1:]
    data = dict(zip([name.split(" ")[0] for name in names.split(",")], np.loadtxt(lines, delimiter=",").T, strict=True))
    np.savez(tmp_path / "a.npz", **data)
    (tmp_path / "one.csv").write_text("\n".join([names.replace("difference", "difference [1]"), *lines]))
    russian = "\n".join([names, *lines]).replace(",", ";").replace(".", ",").replace("time [s]", "время, с")
    (tmp_path / "r.csv").write_bytes(russian.encode("cp1251"))
    expected = estimate(gimbal, "--csv", "-").stdout.splitlines()
    for file, more in {"a.npz": ("--unit", "rad"), "one.csv": (), "r.csv": ("--time", 1)}.items():
        lines = estimate(tmp_path / file, *more, "--csv", "-").stdout.splitlines()
        assert [line.split(",")[:5] for line in lines] == [line.split(",")[:5] for line in expected], file


def test_a_growing_file_is_watched(gimbal, tmp_path):
    """The estimate of a live source, at its end, is that of its file; a row that is no number is passed over."""
    lines = gimbal.read_text().splitlines()
    path = tmp_path / "live.csv"
    path.write_text("\n".join([*lines[:20], lines[20].replace(lines[20].split(",")[1], "nan"), *lines[21:], ""]))
    choices = (path, "--difference", "difference", "--rho", "rho", "--csv", "-")
    done, whole = run("watch", *choices, "--idle", "1.5 s", code=0), run("estimate", *choices, code=0)
    shown = table_of(done.stdout)
    for name, row in table_of(whole.stdout).items():
        error = float(row["standard_error"])
        assert shown[name]["true"] == row["true"]
        assert float(shown[name]["value"]) == pytest.approx(float(row["value"]), abs=1e-4 * error)
        assert float(shown[name]["high"]) == pytest.approx(float(row["high"]), abs=1e-3 * error)
    assert "359 samples; harmonic 128 of h: 3." in done.stderr
    path.write_text("nothing\n")
    assert "sent no samples" in run("watch", *choices, "--idle", "0.5 s").stderr


def test_lines_of_a_pipe_stay_where_the_results_cannot_be_written(gimbal, tmp_path, monkeypatch):
    def full(*_):
        raise al.UsageError("cannot be written")

    pieces = iter([gimbal.read_bytes()])
    monkeypatch.setattr(following, "opened", lambda *_: live.Tap(lambda _: next(pieces, b""), list))
    monkeypatch.setattr(angle, "deliver_study", full)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    done = run("watch", "port", "--difference", "difference", "--rho", "rho", "--idle", "0.5 s")
    (kept,) = tmp_path.glob("allanite-*.txt")
    assert f"kept in '{kept}'" in done.stderr
    assert kept.read_text().splitlines() == gimbal.read_text().splitlines()[1:]  # without what is said of the columns


def test_the_recipe_repeats_the_run(gimbal, tmp_path):
    recipe = tmp_path / "recipe.toml"
    options = ["--orders", "128", "--nuisance", "A1,A2,A3", "--prior", "3,10", "--level", "0.9", "--sigma", "1"]
    runs = {
        ("estimate", gimbal): ["--difference", "difference", "--latitude", 60, "--turn-period", 300, *options],
        ("plan",): [*EXPERIMENT, "--sway", "1,60", "--start", 600, "--orders", "128", "--angles", "h"],
    }
    for verb, chosen in runs.items():
        first = run(*verb, *chosen, "--json", "-", code=0)
        recipe.write_text(toml(json.loads(first.stdout)["recipe"]))
        assert run(*verb, "--recipe", recipe, "--json", "-").stdout == first.stdout


def test_known_harmonics_are_shown_and_drawn(tmp_path):
    known = al.angle.Harmonics.of({128: (3 * ARCSEC, 0.0)}, "h")
    assert "h 128" in table(known)
    assert "known, not estimated" in page(known)
    # errors are drawn against time
    hour = al.angle.gimbals(np.arange(3600.0, 7200.0, 10.0), latitude=np.radians(60))
    (axes,) = printed(figures.plot_error_in_time(hour, [known])).axes
    time, error = axes.lines[0].get_data()
    np.testing.assert_allclose(time, hour.time / 60)
    np.testing.assert_allclose(error, 3 * np.sin(128 * hour.h), atol=1e-6)
    out, figure = tmp_path / "sway.csv", tmp_path / "sway.png"
    asked = ("--latitude", 60, "--duration", 3600, "--error", "h:128=3,0", "--sway", "0.5,60", "--plot", figure)
    ends(run("simulate", out, *asked), 0, f"plot: {figure}")
    assert figure.read_bytes().startswith(b"\x89PNG")
