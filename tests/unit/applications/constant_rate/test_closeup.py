"""One interval in detail, and every interval as a table."""

import csv
import io

import numpy as np
import pytest
from tests.commands import run
from tests.rows import refused, rows

import allanite as al
from allanite.applications.constant_rate import EstimatorSettings, ExperimentSettings, closeup, estimate
from allanite.applications.constant_rate.campaign import RateSettings


@pytest.fixture(scope="module")
def record():
    return al.simulation.simulate_ring_laser(al.simulation.GL1, 12.4392, 24_000, 400.0, rng=1, name="gz")


SETTINGS = ExperimentSettings(interval=20.0)
MODEL = "N 0.0003 deg/sqrt(h), Q 0.3 arcsec, B 0.003 deg/h"


def test_the_closeup_is_what_the_estimators_saw(record):
    found = closeup(record, SETTINGS, start=20.0)
    part = al.Record(record.values[8000:16_000], 400.0, "arcsec", kind="count", scale=record.scale)
    conditional, stairs = (estimate(part, method) for method in ("conditional", "staircase"))
    lines, unit = found.slopes.size, part.factor * 400.0
    assert (lines, found.kept.mean()) == (conditional.details["lines"], conditional.details["kept"])
    assert found.slopes[found.kept].mean() == pytest.approx(conditional.value, rel=1e-12)
    assert np.square(found.misfit).sum() == pytest.approx(stairs.details["misfit"], abs=5)  # samples at a corner
    slope = (found.line[-1] - found.line[0]) / (found.line.size - 1) * unit
    assert slope == pytest.approx(stairs.value, rel=1e-9)
    # a line by itself
    angle = np.concatenate(([0.0], np.cumsum(part.values)))[7 : 7 + 8001 - lines + 1]
    assert found.slopes[7] == pytest.approx(np.polyfit(np.arange(angle.size), angle, 1)[0] * unit, rel=1e-9)


def test_it_is_drawn(record):
    found = closeup(record, SETTINGS)
    top, stairs, misfit = al.plot(found).axes
    assert "slope less 12.3" in top.get_ylabel()
    assert misfit.get_ylabel() == "counts minus staircase"
    drawn = np.asarray(stairs.lines[1].get_ydata())
    np.testing.assert_array_equal(drawn, np.floor(found.line[: drawn.size]))
    found = closeup(record, ExperimentSettings(20.0, options=EstimatorSettings(descent=20)))
    top = al.plot(found).axes[0]
    np.testing.assert_allclose(top.lines[0].get_ydata(), found.descent / np.radians(1 / 3600))


def test_a_rate_without_quantum_has_no_staircase():
    rate = al.simulate(al.N(0.1, "deg/sqrt(h)"), 4000, 100.0, rng=1)
    found = closeup(rate, ExperimentSettings(interval=10.0))
    assert (found.counts.size, found.kept.any(), len(al.plot(found).axes)) == (0, True, 1)
    narrow = ExperimentSettings(interval=10.0, options=EstimatorSettings(allowed=1e-15))
    refused(al.UsageError, "no regression line is within 1e-15", lambda: closeup(rate, narrow))


@rows("start", [-1.0, 41.0])
def test_an_interval_outside_is_refused(start, record):
    refused(al.UsageError, "does not fit into 60 s", lambda: closeup(record, SETTINGS, start=start))


@pytest.mark.slow("takes more than half a second")
def test_every_interval_is_written(record, tmp_path):
    al.write(record, tmp_path / "gz.npz")
    table, figure, page = (tmp_path / name for name in ("all.csv", "closeup.svg", "page.html"))
    done = run("rate", tmp_path / "gz.npz", "--interval", 10, "--noise", MODEL, "--no-times", "--reference", 12.4,
               "--readings", table, "--closeup", figure, "--report", page)  # fmt: skip
    assert done.exit_code == 0, done.stderr
    rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
    assert (len(rows), {row["interval"] for row in rows}) == (6 * 6, set("123456"))
    mean = next(row for row in rows if row["method"] == "mean" and row["interval"] == "3")
    counted = record.values[8000:12_000].sum() * record.scale / 10.0
    assert (float(mean["rate"]), float(mean["error"])) == pytest.approx((counted, counted - 12.4))
    assert "<svg" in figure.read_text(encoding="utf-8")
    assert "rate of every interval" in page.read_text(encoding="utf-8")


def test_what_wanders_is_drawn_beside_the_prediction(record):
    settings = RateSettings(SETTINGS, al.Model(MODEL), durations=(1.0, 3.0))
    lower = al.plot(al.constant_rate.measure_rates(record, None, settings)).axes[1]
    line = next(line for line in lower.lines if "from interval to interval (B)" in str(line.get_label()))
    expected = np.sqrt(al.expected(al.B(0.003, "deg/h"), "adev", [1.0, 3.0])) / np.radians(1 / 3600)
    np.testing.assert_allclose(np.asarray(line.get_ydata(), dtype=float), expected)
