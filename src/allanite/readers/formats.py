"""The formats that are read, as a table: a line is a module with ``TITLE``, ``sniff`` and ``read``."""

from collections.abc import Callable
from typing import NamedTuple

from allanite.errors import DataError
from allanite.record import Recording

from . import numpy_file, psins, text
from .options import Options


class Reader(NamedTuple):
    """A format: what it is called, whether bytes and suffix look like it, and how it is read."""

    title: str
    sniff: Callable[[bytes, str], bool]
    read: Callable[[str, Options], Recording]


READERS: dict[str, Reader] = {  # asked in this order; text, which sniffs least, is the last
    "numpy": Reader(numpy_file.TITLE, numpy_file.sniff, numpy_file.read),
    "psins": Reader(psins.TITLE, psins.sniff, psins.read),
    "text": Reader(text.TITLE, text.sniff, text.read),
}


def reader_for(head: bytes, suffix: str) -> Reader:
    """The first reader that knows the format by the file's first bytes or its suffix."""
    for reader in READERS.values():
        if reader.sniff(head, suffix):
            return reader
    titles = "; ".join(reader.title for reader in READERS.values())
    raise DataError(f"the file is of no format that is read (it begins with {head[:8]!r}); what is read: {titles}")
