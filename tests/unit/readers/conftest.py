"""What several of these tests write."""

import pytest


@pytest.fixture
def write(tmp_path):
    """Write a file of text or bytes."""

    def write(content, name="gyro.csv"):
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


@pytest.fixture
def table(write):
    """Write columns below their names, and those below some lines."""

    def table(names, *columns, above=""):
        heading = names if isinstance(names, str) else ",".join(names)
        rows = (",".join(map(str, row)) for row in zip(*columns, strict=True))
        return write(above + "\n".join([heading, *rows, ""]))

    return table
