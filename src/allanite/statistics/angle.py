"""The angle of a record, cut at its gaps."""

from typing import NamedTuple

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Record

from .row import FloatArray


class Piece(NamedTuple):
    """The angle over a stretch without gaps: the sample at which it starts, and its points (one more than samples)."""

    start: int
    x: FloatArray


class Angle(NamedTuple):
    """The angle of a record in the steps of its readings.

    Attributes
    ----------
    pieces : tuple of Piece
    size : int
        Sample intervals of the record, lost ones included.
    scale : float
        What x must be multiplied with to be SI.
    """

    pieces: tuple[Piece, ...]
    size: int
    scale: float

    @property
    def runs(self) -> list[tuple[int, int]]:
        """(samples, 1) of every piece."""
        return [(piece.x.size - 1, 1) for piece in self.pieces]


def integrated(record: Record, order: int) -> Angle:
    """The angle of a record, for statistics that take differences of `order`.

    A constant rate is removed first where `order` lets it: a bias then costs no digits. No sum runs across a gap.

    Raises
    ------
    DataError
        No two neighbouring samples are finite.
    """
    step = record.interval if record.kind == "rate" else 1.0
    if record.kind == "angle":
        runs = _runs(record.values)
        pieces = [Piece(a, np.asarray(record.values[a:b] - record.values[a], dtype=np.float64)) for a, b in runs]
        return Angle(tuple(piece for piece in _some(pieces, record)), record.size, record.factor)
    from allanite.kernels.allan import integrate

    constant = record.constant if order > 1 else 0
    pieces = [Piece(a, integrate(record.values[a:b], constant)) for a, b in _runs(record.values)]
    return Angle(tuple(_some(pieces, record)), record.size, record.factor * step)


def _runs(values: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> list[tuple[int, int]]:
    """Begin and end of the stretches of finite values."""
    if values.dtype.kind != "f" or np.isfinite(values.sum(dtype=np.float64)):
        return [(0, len(values))]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], np.isfinite(values).astype(np.int8), [0]))))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _some(pieces: list[Piece], record: Record) -> list[Piece]:
    long = [piece for piece in pieces if piece.x.size > 2]
    if not long:
        raise DataError(f"{record.name!r} has no two neighbouring readings that are finite; nothing can be differenced")
    return long
