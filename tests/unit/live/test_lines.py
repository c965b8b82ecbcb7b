"""Lines of numbers, and the names above them."""

import pytest

from allanite.live.lines import Lines, places


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
        assert list(places(lines, None, None)[0]) == list(names or map(str, range(lines.width)))


def test_rows_may_come_byte_by_byte():
    lines = Lines()
    found = [row for byte in b"gx [deg/s]\n1.5\n-2\n" for row in lines.rows(bytes([byte]))]
    assert (found, lines.names) == ([[1.5], [-2.0]], ("gx",))
