"""The central values: what they accept, what they refuse, and that they survive being written down."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.core.units import convert
from allanite.prepare import inspect, trim

MODEL = al.N(0.1, "deg/sqrt(h)") + al.B(1.0, "deg/h")


def record(n=5000, **options):
    return al.simulate(MODEL, n, 100.0, rng=1, **options)


WRONG = [({"rate": 0}, "between 1e-09 and 1e\\+15 Hz, not 0"), ({"rate": -1.0}, "between"),
         ({"rate": float("nan")}, "between"), ({"rate": "100"}, "rate must be a number"),
         ({"unit": "furlong"}, "unknown unit"), ({"unit": "deg"}, "does not fit kind 'rate'"),
         ({"kind": "speed"}, "unknown kind 'speed'"), ({"kind": "count", "unit": "arcsec"}, "size of one pulse"),
         ({"scale": -2.0}, "the scale must be between 1e-30"), ({"values": [[1.0, 2.0]]}, r"shape \(n,\)"),
         ({"values": ["a", "b", "c"]}, "not real numbers"), ({"values": [1.0 + 2j, 2.0]}, "not real numbers"),
         ({"values": [1.0]}, "too few"),
         ({"kind": "count", "unit": "arcsec", "scale": 1.0, "values": [1.0, 2.5, 3.0]}, "counts must be integers"),
         ({"kind": "count", "unit": "arcsec", "scale": 1.0, "values": [1.0, np.inf, 3.0]}, "finite")]  # fmt: skip


@rows(("wrong", "words"), WRONG)
def test_the_door_refuses(wrong, words):
    good = {"values": [1.0, 2.0, 3.0], "rate": 1.0, "unit": "deg/s", "kind": "rate"}
    refused(al.AllaniteError, words, lambda: al.Record(**(good | wrong)))


def test_a_record_cannot_be_changed():
    with pytest.raises(AttributeError):
        record().rate = 5.0


class Quantity:
    """What pint's and astropy's quantities have in common."""

    def __init__(self, magnitude, unit):
        self.magnitude, self.unit = magnitude, unit

    def to(self, unit):
        return Quantity(self.magnitude * convert(1.0, self.unit, unit), unit)


def test_quantities_bring_their_unit():
    found = al.Record(Quantity(np.array([1.0, 2.0]), "rad/s"), 1.0, "deg/s")
    np.testing.assert_allclose(found.values, np.degrees([1.0, 2.0]))
    np.testing.assert_allclose(found.rate_values, [1.0, 2.0])


def test_columns_of_tables_are_taken():
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    lost = [1.0, np.nan, 3.0]
    bare = type("Column", (), {"to_numpy": lambda _: np.array(lost)})()
    for column in (pandas.Series(lost), pandas.Series([1, None, 3], dtype="Int64"), polars.Series([1, None, 3]), bare):
        np.testing.assert_array_equal(al.Record(column, 10.0, "deg/h").values, lost)
    counts = al.Record(pandas.Series([1, 2, 3], dtype="Int64"), 10.0, "arcsec", kind="count", scale=0.1)
    assert counts.values.dtype == np.int64
    refused(al.DataError, "not real numbers", lambda: al.Record(polars.Series(["1", "2", "3"]), 10.0, "deg/h"))


def test_numbers_of_numpy_are_written_as_numbers():
    refused(al.UsageError, r"15 Hz, not -1$", lambda: al.Record([1.0, 2.0], np.float64(-1.0), "deg/h"))
    with pytest.raises(al.DataError, match=r"sample 1 of 'z' is 1\.25;"):
        al.Record([1.0, 1.25, 2.0], 10.0, "arcsec", kind="count", scale=0.1, name="z")
    assert "always 1.25)" in inspect(al.Record(np.full(300, 1.25), 10.0, "deg/h")).refusal


def test_rate_and_angle_are_names_of_one_thing():
    y = np.array([1.0, -2.0, 4.0])
    rate = al.Record(y, 10.0, "rad/s")
    angle = al.Record(np.concatenate(([5.0], 5.0 + np.cumsum(y / 10))), 10.0, "rad", kind="angle")
    np.testing.assert_allclose(angle.rate_values, y)
    np.testing.assert_allclose(rate.angle, angle.angle, atol=1e-15)
    assert rate.size == angle.size == 3


def test_recordings_by_name_and_number():
    recording = al.Recording((record(name="x"), record(name="y")))
    assert recording["y"] is recording[1]
    assert [r.name for r in recording] == ["x", "y"]
    refused(al.UsageError, "channels: x, y", lambda: recording["z"])
    refused(al.UsageError, "must differ", lambda: al.Recording((record(name="x"), record(name="x"))))
    refused(al.DataError, "at least one", lambda: al.Recording(()))


def test_models_add_and_come_back():
    model = al.Q(0.1, "arcsec") + MODEL + al.R(-1.0, "deg/h^2")
    assert ([t.symbol for t in model], model["R"].to("deg/h^2")) == (["Q", "N", "B", "R"], pytest.approx(-1.0))
    assert str(model["B"]) == "B = 1 deg/h"
    assert al.Model.from_dict(json.loads(json.dumps(model.to_dict()))) == model
    refused(al.UsageError, "once", lambda: model + al.N(1.0, "deg/sqrt(h)"))
    refused(al.UsageError, "not negative", lambda: al.N(-1.0, "deg/sqrt(h)"))
    refused(al.UsageError, "Q, N, B, R", lambda: model["K"])


@pytest.mark.slow("takes more than half a second")
def test_intervals_are_chi_square():
    """68.3 % of 400 records hold the truth at every octave: 400 trials, 4.5 standard errors, error probability 1e-4."""
    curves = [al.deviation(al.simulate(MODEL, 512, 100.0, rng=seed), noise=MODEL) for seed in range(1, 401)]
    # the noise is given: limits are the same multiples of the deviation in every record
    low, high = (limit / curves[0].deviation for limit in curves[0].interval(0.683))
    for curve in curves[1:20]:
        np.testing.assert_allclose(curve.interval(0.683), (low * curve.deviation, high * curve.deviation), rtol=1e-9)
    truth = np.sqrt(al.expected(MODEL, "oadev", 2.0 ** np.arange(low.size) / 100))
    deviations = np.array([curve.deviation for curve in curves])
    inside = ((low * deviations <= truth) & (truth <= high * deviations)).sum(axis=0)
    # few degrees of freedom make chi-square wide, never narrow
    assert np.all(inside / 400 > 0.683 - 4.5 * 0.0233)
    assert np.all(inside[:5] / 400 < 0.683 + 4.5 * 0.0233)


def test_fits_are_plain_data():
    fit = al.identify(record(20_000, name="z"))
    data = json.loads(json.dumps(fit.to_dict(), allow_nan=False))
    assert [term["symbol"] for term in data["terms"]] == list("QNBKR")
    noise = data["terms"][1]
    assert noise["status"] == "identified"
    assert noise["low"] < noise["value"] < noise["high"]
    assert noise["shown"]["unit"] == "deg/sqrt(h)"
    absent = data["terms"][3]
    assert (absent["value"], absent["low"]) == (None, 0.0)
    assert absent["high"] > absent["upper"]  # two-sided, and one-sided
    assert absent["shown"]["high"] == pytest.approx(convert(absent["upper"], absent["unit"], absent["shown"]["unit"]))
    headings, rows = fit.rows()
    assert [len(row) for row in rows] == [len(headings)] * 5
    refused(al.UsageError, "not a term of this fit", lambda: fit["GM"])
    refused(al.UnitError, "not a unit of N", lambda: fit["N"].to("deg/h"))


def test_windows():
    recording = al.Recording((record(name="x"),))
    part = trim(recording, 10, 20)["x"]
    assert (part.size, part.start) == (1000, 10.0)
    assert "cut from 10 s to 20 s" in part.history
    np.testing.assert_array_equal(part.values, recording["x"].values[1000:2000])
    assert trim(recording) is recording
    for start, until in [(5, 5), (-1, 5), (0, 51), (60, None)]:
        refused(al.UsageError, "window", lambda start=start, until=until: trim(recording, start, until))


@pytest.mark.slow("memory of a process of its own")
def test_a_study_takes_no_more_than_six_times_the_records_memory():
    import tracemalloc

    long = record(1_000_000)
    al.analyze(long)
    tracemalloc.start()
    al.analyze(long)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 6 * long.values.nbytes


def test_recipes_are_plain_data(tmp_path):
    recipe = al.Recipe(rate=100.0, channels=("x", "y"), band=(0.0, 5.0))
    assert al.Recipe.from_dict(json.loads(json.dumps(recipe.to_dict()))) == recipe
    path = tmp_path / "recipe.toml"
    path.write_text('rate = 100.0\nchannels = ["x", "y"]\nband = [0.0, 5.0]\n')
    assert al.Recipe.load(path) == recipe
    for line, words in (('level = "0.95"', "level must be a number"), ("level = 95", "between 0 and 1"),
                        ("band = [1.0]", "two frequencies"), ("rate = true", "rate must be a number")):  # fmt: skip
        path.write_text(line + "\n")
        refused(al.UsageError, words, lambda: al.Recipe.load(path))


def test_a_fit_without_a_valid_term_has_no_model():
    fit = al.identify(al.simulate(al.N(1, "deg/sqrt(h)"), 5000, 1.0, rng=1), terms="N,K")
    hidden = tuple(replace(e, status="not valid" if e.symbol == "N" else "not observable") for e in fit)
    doubtful = replace(fit, estimates=hidden, model=al.Model(fit.model.terms[:1]))
    assert fit.valid is not None
    assert doubtful.validity != "unexplained"
    assert doubtful.valid is None
