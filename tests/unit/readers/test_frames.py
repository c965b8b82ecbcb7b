"""Tables of pandas, polars and pyarrow: the same recording as the CSV with these headers."""

import numpy as np
import pyarrow as pa
import pytest
from tests.rows import refused, rows

import allanite as al

pd = pytest.importorskip("pandas")
pl = pytest.importorskip("polars")

RNG = np.random.default_rng(5)
COUNT = 50
CONTENT = {
    "time [s]": np.arange(COUNT) * 0.01 + 3, "gx [deg/s]": RNG.normal(size=COUNT),
    "gy [deg/s]": RNG.integers(-99, 99, COUNT),
    "acc_x_mps2": RNG.normal(size=COUNT).astype(np.float32).astype(float), "Temp [degC]": RNG.normal(25, 1, COUNT),
}  # fmt: skip


class Plain:
    """The least that a table may be."""

    def __init__(self, content):
        self.content, self.columns = content, list(content)

    def __getitem__(self, name):
        return type("Series", (), {"to_numpy": lambda _: np.asarray(self.content[name])})()


KINDS = [pd.DataFrame, pl.DataFrame, pa.table, Plain]


def assert_as_csv(frame, tmp_path, content, **options):
    pd.DataFrame(content).to_csv(tmp_path / "a.csv", index=False)
    expected, found = al.read(tmp_path / "a.csv", **options), al.read(frame, **options)
    assert found.channels == expected.channels
    assert found.notes == expected.notes
    for mine, theirs in zip(found, expected, strict=True):
        assert (mine.rate, mine.unit, mine.kind, mine.start) == (theirs.rate, theirs.unit, theirs.kind, theirs.start)
        np.testing.assert_array_equal(mine.values, theirs.values, strict=True)
    return found


WORDS = CONTENT | {"note": ["on the table"] * COUNT, "gy [deg/s]": [None, *range(COUNT - 1)]}
TURNS = {"id": ["a", "b"] * 25, "gx [deg/s]": CONTENT["gx [deg/s]"]}


@rows("kind", KINDS)
@rows("content, options, channels", [
    (CONTENT, {}, ("gx", "gy", "acc_x_mps2")), (TURNS, {"rate": 1.0}, ("a gx", "b gx")),
    (WORDS, {"channels": ["gy", "2"], "rate": 10.0, "time": "none"}, ("gy", "gx")),
], ids=["plain", "sensors that take turns", "words and missing values"])  # fmt: skip
def test_a_table_is_read_as_its_csv(kind, tmp_path, content, options, channels):
    assert assert_as_csv(kind(content), tmp_path, content, **options).channels == channels


@rows("kind", KINDS[:3])
def test_a_column_of_words_is_no_channel(kind):
    assert np.isnan(al.read(kind(WORDS))["gy"].values[0])
    refused(al.DataError, "'note' holds text", lambda: al.read(kind(WORDS), channels=["note"]))


@rows("kind", KINDS[:3])
def test_stamps_are_times(kind):
    stamps = np.datetime64("2024-05-01T00:00") + np.arange(COUNT) * np.timedelta64(5000, "us")
    assert al.read(kind({"at": stamps, "gx [deg/s]": CONTENT["gx [deg/s]"]}), time="at")[0].rate == pytest.approx(200)


def test_an_index_of_pandas_that_says_something_is_a_column():
    frame = pd.DataFrame({"gx [deg/s]": CONTENT["gx [deg/s]"]})
    refused(al.UsageError, "sampling rate is not in the file", lambda: al.read(frame))
    named = frame.set_index(pd.Index(CONTENT["time [s]"], name="time [s]"))
    assert al.read(named)[0].rate == pytest.approx(100)
    stamped = frame.set_index(pd.date_range("2024-05-01", periods=COUNT, freq="5ms"))
    assert al.read(stamped)[0].rate == pytest.approx(200)


def test_what_no_table_may_be():
    twice = pd.DataFrame(np.zeros((9, 2)), columns=["gx", "gx"])
    refused(al.DataError, r"several columns .* 'gx'", lambda: al.read(twice, rate=1, unit="deg/s"))
    refused(al.UsageError, "omit them", lambda: al.read(pd.DataFrame(CONTENT), dtype="i2"))
    refused(al.DataError, "fewer than 2 rows", lambda: al.read(pd.DataFrame(CONTENT)[:1]))
