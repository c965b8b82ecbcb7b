"""Lines of numbers, and the names above them."""

import numpy as np
import pytest
from allanite.live.lines import Lines, places

import allanite as al


@pytest.mark.parametrize(
    ("text", "names", "rows"),
    [
        (b"gx [deg/s]\n1\n2\n", ("gx",), [[1.0], [2.0]]),
        (b"gx [deg/s],gy [deg/s]\n1,2\n", ("gx", "gy"), [[1.0, 2.0]]),
        (b"t gx\n0.1 2\n", ("t", "gx"), [[0.1, 2.0]]),
        (b"gx [deg/s]\n1 2\n", ("gx", ""), [[1.0, 2.0]]),
        (b"a logger that begins with a sentence\n1 2\n", (), [[1.0, 2.0]]),
        (b"1;2\n3;4\n", (), [[1.0, 2.0], [3.0, 4.0]]),
    ],
)
def test_names_are_those_above_the_first_row(text, names, rows):
    lines = Lines()
    assert lines.rows(text) == rows
    assert lines.width == len(rows[0])
    if "" not in names:
        assert lines.names == names
        assert list(places(lines, None, None)[0]) == list(names or (f"column {i + 1}" for i in range(lines.width)))


def test_rows_may_come_byte_by_byte():
    lines = Lines()
    found = [row for byte in b"gx [deg/s]\n1.5\n-2\n" for row in lines.rows(bytes([byte]))]
    assert (found, lines.names) == ([[1.5], [-2.0]], ("gx",))


@pytest.mark.parametrize("text", ["1,2,3\n", "gx,gy,gz\n1,2,3\n", "gx [deg/s],gx [deg/s],gy [deg/s]\n1,2,3\n"])
def test_columns_are_called_as_those_of_a_file(tmp_path, text):
    """`watch --channels 1` once took the second column where `analyze --channels 1` takes the first."""
    path = tmp_path / "rows.csv"
    path.write_text(text + "1,2,3\n" * 20)
    lines = Lines()
    rows = np.array(lines.rows(path.read_bytes()))
    for key in ("1", "3", *(record.name for record in al.read(path, rate=1.0, unit="deg/s"))):
        (record,) = al.read(path, rate=1.0, unit="deg/s", channels=[key])
        ((name, column),) = places(lines, [key], None)[0].items()
        assert name == record.name
        assert rows[0, column] == pytest.approx(record.values[0])
