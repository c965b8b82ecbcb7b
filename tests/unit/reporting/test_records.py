"""The figure of records over time."""

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.reporting import page
from allanite.reporting.figures.record import STRETCHES, envelope
from allanite.study.analysis import examine


def record(size=100_000, rate=100.0, **form):
    """Noise with a gap and an outlier."""
    values = np.random.default_rng(0).normal(size=size)
    values[70_123 % size], values[30_000:36_000] = 50.0, np.nan
    return al.Record(values, rate, form.pop("unit", "deg/s"), name="gz", **form)


@rows("count", [1, 7, STRETCHES, 200_000])
def test_stretches_hold_every_extreme_and_every_mean(count):
    whole = record()
    seen, values = envelope(whole, count), whole.values
    assert np.nanmin(seen.low) == np.nanmin(values)
    assert np.nanmax(seen.high) == 50.0
    assert len(seen.at) == min(count, len(values))
    sizes = np.diff(np.linspace(0, len(values), len(seen.at) + 1).astype(int))
    if count > len(values):
        assert np.array_equal(seen.mean, values, equal_nan=True)
    elif not np.isnan(seen.mean).any():
        assert np.average(seen.mean, weights=sizes) == pytest.approx(np.nanmean(values), abs=0.05)
    assert seen.broken.sum() * len(values) / len(seen.at) == pytest.approx(6000, abs=2 * len(values) / len(seen.at) + 1)


@rows("made, unit, time, ends", [
    (record(), "°/s", "min", (0, 100_000 / 6000)), (record(rate=1.0), "°/s", "h", (0, 100_000 / 3600)),
    (al.Record(np.arange(500), 10.0, "arcsec", kind="count", scale=0.1), "pulses of 0.1 arcsec", "s", (0, 50)),
    (al.Record(np.arange(501.0), 10.0, "arcsec", kind="angle"), "arcsec", "s", (0, 50)),
    (al.Record(np.arange(500.0), 10.0, "arcsec", kind="increment", scale=2.0, cut=5.0), "arcsec", "s", (5, 55)),
])  # fmt: skip
def test_axes_have_the_unit_of_the_samples_and_the_times_of_the_recording(made, unit, time, ends):
    (ax,) = al.plot(made).axes
    assert ax.get_ylabel() == unit
    assert ax.get_xlabel() == f"time ({time})"
    assert ax.get_xlim() == pytest.approx(ends)
    x, y = ax.lines[0].get_data()
    assert np.nanmin(x) >= ends[0]
    assert np.nanmax(x) <= ends[1]
    scale = 1.0 if made.kind == "count" else made.scale or 1.0
    assert (np.nanmin(y), np.nanmax(y)) == (np.nanmin(made.values) * scale, np.nanmax(made.values) * scale)
    if made.kind == "count":  # a pulse of 0.1 arcsec, 10 times a second, is 1 deg/h
        (right,) = ax.child_axes
        ax.figure.draw_without_rendering()
        assert (right.get_ylabel(), ax.get_ylim()) == ("°/h", pytest.approx(right.get_ylim()))


def test_channels_are_panels_and_lines_break_where_samples_are_missing():
    ax = al.plot(record()).axes[0]
    lines = {line.get_label(): line for line in ax.lines}
    x, y = lines["samples"].get_data()
    gap = (x > 300 / 60) & (x < 360 / 60)
    assert np.isnan(y[gap]).mean() > 0.95
    assert not np.isnan(y[~gap]).any()
    assert np.allclose(lines["missing samples"].get_xdata()[[0, -1]], (5, 6), atol=0.03)
    # channels are panels of one abscissa
    both = al.Recording((record(), al.Record(np.ones(100_000), 100.0, "mg", name="ax")))
    figure = al.plot(both)
    assert [ax.get_ylabel() for ax in figure.axes] == ["°/s", "mg"]
    assert [ax.get_xlabel() for ax in figure.axes] == ["", "time (min)"]
    assert page(both).count("<svg") >= 2
    assert len(al.plot([*both]).axes) == len(al.plot(examine(both)).axes) == 2
    # samples that are not in memory are not drawn
    stored = al.Study.from_dict(examine(record()).to_dict())
    refused(al.UsageError, "no samples are in memory", lambda: al.plot(stored))
