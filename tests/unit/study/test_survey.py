"""Surveys: what goes in, what comes out, on the command line and in figures."""

import csv
import io
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.core.syntax import toml
from allanite.reporting import plot, table
from allanite.study.survey import Densities, Deviations, survey


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "imu.csv"
    rng = np.random.default_rng(7)
    data = np.column_stack([np.arange(4000) / 10, rng.standard_normal((4000, 3)), np.zeros(4000)])
    header = "time [s],x [deg/h],y [deg/h],a [g],flat [deg/h]"
    np.savetxt(path, data, delimiter=",", fmt="%.9g", header=header, comments="")
    return str(path)


def cells(*words):
    """The rows of the table that a command writes."""
    return list(csv.DictReader(io.StringIO(run(*words, "--csv", "-", code=0).stdout)))


def floats(table, column):
    return [float(row[column]) for row in table]


def test_deviation_is_that_of_the_library(file):
    table = cells("deviation", file, "--channels", "x", "--statistic", "adev,oadev", "--m", "1,10,100")
    record = al.read(file)["x"]
    fit = al.identify(record)
    for name, part in (("adev", table[:3]), ("oadev", table[3:])):
        curve = al.deviation(record, name, m=[1, 10, 100], noise=fit).to("deg/h")
        assert {(row["channel"], row["statistic"], row["unit"]) for row in part} == {("x", name, "deg/h")}
        assert [int(row["m"]) for row in part] == curve.m.tolist()
        low, high = curve.interval()
        for key, value in {"deviation": curve.deviation, "low": low, "high": high, "edf": curve.edf}.items():
            assert floats(part, key) == pytest.approx(value.tolist(), rel=1e-12)
    # limits can be left out, and the unit chosen
    alone = ("deviation", file, "--channels", "x", "--no-intervals")
    first, second = cells(*alone, "--to", "rad/s", "--taus", "0.1,1")
    assert (first["tau_s"], second["tau_s"], first["low"], first["edf"]) == ("0.1", "1.0", "", "")
    assert float(first["deviation"]) == pytest.approx(np.radians(1 / 3600), rel=0.1)
    assert "edf" not in run(*alone).stdout


@pytest.mark.slow("takes more than half a second")
@rows("verb", ["deviation", "spectrum"])
def test_channels_of_several_files_are_side_by_side(verb, file, tmp_path):
    other = tmp_path / "run2.csv"
    shutil.copy(file, other)
    form = ("--channels", "x", *(("--no-intervals",) if verb == "deviation" else ()))
    one = cells(verb, file, *form)
    both = cells(verb, file, other, *form, "--plot", tmp_path / "a.png")
    assert [row | {"channel": "x"} for row in both] == one * 2
    assert [*dict.fromkeys(row["channel"] for row in both)] == [Path(file).name, "run2.csv"]
    several = json.loads(run(verb, file, other, "--channels", "x,y", *form[2:], "--json", "-").stdout)["channels"]
    assert [c["name"] for c in several] == [f"{path} {name}" for path in (Path(file).name, "run2.csv") for name in "xy"]


@pytest.mark.slow("takes more than half a second")
def test_several_models_are_side_by_side(tmp_path):
    models = ["Sine 1 arcsec 0.5 Hz", "GM 1 arcsec 5 s"]
    form = ("--rate", "40", "--duration", "60")
    each = [cells("deviation", "--model", model, *form) for model in models]
    both = cells("deviation", "--model", models[0], "--model", models[1], *form, "--plot", tmp_path / "{channel}.svg")
    assert len(list(tmp_path.iterdir())) == 2
    assert floats(both, "deviation") == [*floats(each[0], "deviation"), *floats(each[1], "deviation")]
    assert [*dict.fromkeys(row["model"] for row in both)] == [str(al.Model(model)) for model in models]
    ends(run("deviation", "--model", models[0], "--sensor", "fog"), 2, "given twice")


def test_spectrum_is_that_of_the_library(file):
    options = ["--sides", "two", "--bins", "5", "--segment", "40", "--window", "blackman", "--level", "0.9"]
    table = cells("spectrum", file, "--channels", "y", *options)
    expected = al.spectrum(al.read(file)["y"], al.Welch(40.0, "blackman"), sides="two", bins=5).to("deg/h")
    assert floats(table, "density") == pytest.approx(expected.density.tolist())
    assert floats(table, "low") == pytest.approx(expected.interval(0.9)[0].tolist())
    units = {(row["unit"], row["amplitude_unit"], row["sides"]) for row in table}
    assert units == {("(deg/h)^2/Hz", "deg/h/sqrt(Hz)", "two")}
    table = cells("spectrum", file, "--channels", "y", "--estimator", "multitaper", "--bins", "0")
    assert len(table) == al.spectrum(al.read(file)["y"], "multitaper").frequency.size


def test_dynamic_is_that_of_the_library(file):
    table = cells("dynamic", file, "--channels", "x", "--window", "60", "--step", "20", "--statistic", "adev")
    expected = al.dynamic(al.read(file)["x"], "adev", window=60.0, step=20.0).to("deg/h")
    assert floats(table, "deviation") == pytest.approx(expected.deviation.ravel().tolist())
    assert floats(table[:: expected.tau.size], "time_s") == pytest.approx(expected.time.tolist())


def test_a_long_table_is_cut_on_the_terminal_only(file):
    words = ("deviation", file, "--channels", "x", "--taus", "log")
    shown, whole = run(*words, "--no-intervals").stdout, cells(*words)
    assert len(whole) >= 100
    assert f"26 of {len(whole)} rows; --csv writes all" in shown
    lines = [line.split()[:2] for line in shown.splitlines()]
    assert ["1", "0.1"] in lines
    assert ["2000", "200"] in lines
    every = table(survey(file, Deviations(taus="all", intervals=False), al.Recipe(channels=("x",))))
    assert re.search(r"2\d of 2000 rows; --csv writes all", every)


@rows("words, code, said", [
    (("deviation", "--statistic", "oadev,nadev"), 2, ["unknown statistic 'nadev'; did you mean adev?"]),
    (("deviation", "--to", "m"), 2, ["their dimensions differ"]),
    (("spectrum", "--tapers", "5"), 2, ["not a setting of 'welch'; its settings: segment, window"]),
    (("deviation", "--channels", "x,flat", "--m", "1"), 0, ["! no result: ", "edf"]),
])  # fmt: skip
def test_what_goes_wrong_is_said(words, code, said, file):
    ends(run(words[0], file, *words[1:]), code, *said)


@pytest.mark.slow("takes more than half a second")
def test_a_recipe_repeats_the_run(file, tmp_path):
    first = run("deviation", file, "--channels", "x,y", "--statistic", "adev,totdev", "--m", "1,10", "--json", "-")
    done, recipe = json.loads(first.stdout), tmp_path / "recipe.toml"
    recipe.write_text(toml(done["recipe"]), encoding="utf-8")
    assert json.loads(run("deviation", file, "--recipe", recipe, "--json", "-").stdout) == done


def test_refusals_are_named_and_others_go_on():
    y = np.random.default_rng(1).standard_normal(2000)
    lost = y.copy()
    lost[::2] = np.nan
    pair = al.Recording(tuple(al.Record(v, 10.0, "deg/h", name=n) for n, v in (("good", y), ("bad", lost))))
    found = survey(pair, Densities("multitaper"))
    assert [value.name for value in found.values] == ["good"]
    assert "missing" in found["bad"].refusal
    assert "no result: 1000 of 2000 samples are missing" in table(found)
    refused(al.DataError, "bad: 1000", lambda: survey(pair["bad"], Densities("multitaper")))


@pytest.fixture(scope="module")
def record():
    model = al.N(0.05, "deg/sqrt(h)") + al.B(0.5, "deg/h") + al.K(2.0, "deg/h/sqrt(h)")
    return al.simulate(model, 20_000, 10.0, rng=1, name="gz")


@pytest.fixture(scope="module")
def fit(record):
    return al.identify(record)


def labels(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_channels_of_one_statistic_and_statistics_of_one_channel_share_a_panel(record, fit):
    figure = plot([al.deviation(record), al.deviation(replace(record, name="gy", values=record.values * 2))])
    assert (len(figure.axes), labels(figure)) == (1, ["gz", "gy"])
    curves = [al.deviation(record, name, noise=fit.model) for name in ("adev", "oadev")]
    figure = plot(curves, fit)
    assert (len(figure.axes), figure.axes[0].get_title("left")) == (1, "gz")
    assert labels(figure) == ["Allan deviation", "overlapping Allan deviation", "expected by the model"]
    drawn = {line.get_label(): line.get_ydata() for line in figure.axes[0].lines}
    np.testing.assert_allclose(drawn["Allan deviation"], curves[0].to("deg/h").deviation)


@pytest.mark.slow("takes more than half a second")
def test_units_stand_side_by_side_and_channels_below_each_other(file):
    recording = al.read(file, channels=["x", "y", "a"])
    figure = plot([al.deviation(record, name) for record in recording for name in ("adev", "oadev")])
    assert [ax.get_title("left") for ax in figure.axes if ax.axison] == ["x", "a", "y"]
    assert len({ax.get_ylabel() for ax in figure.axes if ax.axison}) == 2


def test_a_spectrum_with_its_terms(record, fit):
    spectrum = al.spectrum(record, bins=10)
    figure = plot(spectrum, fit)
    (ax,) = figure.axes
    drawn = {line.get_label(): line for line in ax.lines}
    np.testing.assert_allclose(drawn["spectrum"].get_ydata(), spectrum.to("deg/h").amplitude)
    f, model = drawn["model"].get_data()
    np.testing.assert_allclose(model, np.sqrt(spectrum.to("deg/h").expected(fit.valid, np.asarray(f))))
    assert "one-sided" in ax.get_ylabel()
    assert "°/h/√Hz" in ax.get_ylabel()
    assert any(text.get_text().startswith("N = ") for text in ax.texts)
    assert ax.get_title("right").startswith("welch, hann window; explained, p = ")
    swaying = record.with_values(record.values + 1e-4 * np.sin(np.arange(record.size)), "")
    doubtful = plot(al.spectrum(swaying), al.identify(swaying, lines=False, band="all"))
    assert "; not explained, p " in doubtful.axes[0].get_title("right")
    assert plot([spectrum, spectrum]).axes[1].get_xlabel() == "frequency (Hz)"


def test_a_surface(record):
    gapped = np.where(np.arange(record.size) // 400 == 12, np.nan, record.values)
    for values in (record.values, gapped):
        surface = al.dynamic(record.with_values(values, ""), window=100.0)
        figure = plot(surface)
        curves, ratios = figure.axes[:2]
        assert curves.get_ylabel() == "overlapping Allan deviation (°/h)"
        mesh = ratios.collections[0].get_array()
        assert mesh.shape == (surface.tau.size, surface.time.size)
        np.testing.assert_allclose(np.nanmedian(mesh.filled(np.nan), axis=1), 1.0, rtol=0.02)
    nothing = al.dynamic(record.with_values(np.zeros(1000), ""), window=10.0)
    refused(al.UsageError, "zero everywhere", lambda: plot(nothing))


@pytest.mark.slow("takes more than half a second")
@rows("names", [["oadev", "ohdev", "mdev", "theoh"], ["oadev", "mtie"], ["oadev"]])
def test_the_legend_stays_within_the_figure(record, fit, names):
    figure = plot([al.deviation(record, name, noise=fit.model) for name in names], fit)
    figure.canvas.draw()
    for legend in figure.legends:
        box = legend.get_window_extent()
        assert 0 <= box.x0 < box.x1 <= figure.bbox.x1
