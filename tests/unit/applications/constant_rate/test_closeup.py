"""One interval in detail, and every interval as a table."""

import csv
import io

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rows import refused, rows

import allanite as al
from allanite.applications.constant_rate import EstimatorSettings, ExperimentSettings, closeup, estimate
from allanite.cli import main


@pytest.fixture(scope="module")
def record():
    return al.simulation.simulate_ring_laser(al.simulation.GL1, 12.4392, 24_000, 400.0, rng=1, name="gz")


SETTINGS = ExperimentSettings(interval=20.0)


def test_the_closeup_is_what_the_estimators_saw(record):
    found = closeup(record, SETTINGS, start=20.0)
    part = al.Record(record.values[8000:16_000], 400.0, "arcsec", kind="count", scale=record.scale)
    conditional, stairs = (estimate(part, method) for method in ("conditional", "staircase"))
    assert found.slopes.size == conditional.details["lines"]
    assert found.kept.mean() == conditional.details["kept"]
    assert found.slopes[found.kept].mean() == pytest.approx(conditional.value, rel=1e-12)
    assert np.square(found.misfit).sum() == pytest.approx(stairs.details["misfit"], abs=5)  # samples at a corner
    slope = (found.line[-1] - found.line[0]) / (found.line.size - 1) * part.factor * 400.0
    assert slope == pytest.approx(stairs.value, rel=1e-9)
    # a line by itself
    lines = found.slopes.size
    angle = np.concatenate(([0.0], np.cumsum(part.values)))[7 : 7 + 8001 - lines + 1]
    assert found.slopes[7] == pytest.approx(
        np.polyfit(np.arange(angle.size), angle, 1)[0] * part.factor * 400, rel=1e-9
    )


def test_it_is_stored_and_drawn(record):
    found = closeup(record, SETTINGS)
    again = al.from_dict(found.to_dict())
    np.testing.assert_array_equal(again.kept, found.kept)
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
    assert not found.counts.size
    assert found.kept.any()
    assert len(al.plot(found).axes) == 1
    with pytest.raises(al.UsageError, match="no regression line is within 1e-15"):
        closeup(rate, ExperimentSettings(interval=10.0, options=EstimatorSettings(allowed=1e-15)))


@rows("start", [-1.0, 41.0])
def test_an_interval_outside_is_refused(start, record):
    refused(al.UsageError, "does not fit into 60 s", lambda: closeup(record, SETTINGS, start=start))


@pytest.mark.slow("takes more than half a second")
def test_every_interval_is_written(record, tmp_path):
    al.write(record, tmp_path / "gz.npz")
    table, figure, page = (tmp_path / name for name in ("all.csv", "closeup.svg", "page.html"))
    noise = "N 0.0003 deg/sqrt(h), Q 0.3 arcsec, B 0.003 deg/h"
    done = CliRunner().invoke(
        main,
        ["rate", str(tmp_path / "gz.npz"), "--interval", "10", "--noise", noise, "--no-times", "--reference", "12.4",
         "--readings", str(table), "--closeup", str(figure), "--report", str(page)],
    )  # fmt: skip
    assert done.exit_code == 0, done.stderr
    rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
    assert (len(rows), {row["interval"] for row in rows}) == (6 * 6, set("123456"))
    mean = next(row for row in rows if row["method"] == "mean" and row["interval"] == "3")
    counted = record.values[8000:12_000].sum() * record.scale / 10.0
    assert float(mean["rate"]) == pytest.approx(counted)
    assert float(mean["error"]) == pytest.approx(counted - 12.4)
    assert "<svg" in figure.read_text(encoding="utf-8")
    assert "rate of every interval" in page.read_text(encoding="utf-8")


def test_what_wanders_is_drawn_beside_the_prediction(record):
    from allanite.applications.constant_rate.campaign import RateSettings

    model = al.N(0.0003, "deg/sqrt(h)") + al.Q(0.3, "arcsec") + al.B(0.003, "deg/h")
    study = al.constant_rate.measure_rates(record, None, RateSettings(SETTINGS, model, durations=(1.0, 3.0)))
    lower = al.plot(study).axes[1]
    line = next(line for line in lower.lines if "from interval to interval (B)" in str(line.get_label()))
    expected = np.sqrt(al.expected(al.B(0.003, "deg/h"), "adev", [1.0, 3.0])) / np.radians(1 / 3600)
    np.testing.assert_allclose(np.asarray(line.get_ydata(), dtype=float), expected)
