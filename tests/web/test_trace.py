"""The trace of a channel: the extremes of stretches, as many as asked for, wherever the window is."""

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.web.trace import build, window

VALUES = np.random.default_rng(1).normal(size=300_000)
RATE = 100.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("trace")
    build(place, al.Recording((al.Record(VALUES, RATE, "deg/h", name="gx"),)), "as it is")
    return place


@rows(("start", "stretches", "size"), [(0, 500, 2), (280_000, 500, 2), (250_000, 400, 40)])
def test_a_window_has_the_extremes_and_middles_of_its_stretches(folder, start, stretches, size):
    stop = start + stretches * size
    found = window(folder, "gx", start / RATE, stop / RATE, stretches)
    parts = VALUES[start:stop].reshape(stretches, size)
    if size < 16:
        np.testing.assert_allclose(found["t"], (start + size * (np.arange(stretches) + 0.5)) / RATE)
        np.testing.assert_allclose(found["low"], parts.min(axis=1), rtol=1e-5)
        np.testing.assert_allclose(found["high"], parts.max(axis=1), rtol=1e-5)
    # longer ones begin and end between those of a level
    assert len(found["t"]) == stretches
    assert min(found["low"]) == pytest.approx(parts.min(), rel=1e-5)
    assert max(found["high"]) == pytest.approx(parts.max(), rel=1e-5)
    assert np.all(np.diff(found["t"]) > 0)


def test_a_window_of_the_whole_has_every_extreme(folder):
    found = window(folder, "gx", None, None, 1000)
    assert 500 < len(found["t"]) <= 1000
    assert min(found["low"]) == pytest.approx(VALUES.min(), rel=1e-5)
    assert max(found["high"]) == pytest.approx(VALUES.max(), rel=1e-5)
    assert found["t"][0] == pytest.approx(1.5, abs=1.5)
    assert found["t"][-1] == pytest.approx(2998.5, abs=1.5)


@rows(("wild", "shown"), [([], None), ([5], 10.0), ([5, 250_000], 10.0)])
def test_a_few_wild_samples_do_not_set_the_range(tmp_path, wild, shown):
    values = VALUES.copy()
    values[wild] = 1e5
    build(tmp_path, al.Recording((al.Record(values, RATE, "deg/h"),)), "as it is")
    found = window(tmp_path, "", None, None, 1000)["range"]
    assert found is None if shown is None else (-shown < found[0] < VALUES.min() and VALUES.max() < found[1] < shown)


def test_numbers_without_a_unit_are_those_of_the_file(tmp_path):
    build(tmp_path, al.Recording((al.Record(VALUES[:100], 1.0, "deg/s"),)), "as it is", ["unit", "rate"])
    found = window(tmp_path, "", None, None, 100)
    np.testing.assert_allclose(found["low"], VALUES[:100], rtol=1e-5)
    assert (found["unit"], found["raw"]) == ("", ["unit", "rate"])
