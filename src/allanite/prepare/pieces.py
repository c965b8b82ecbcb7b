"""A recording that comes in pieces: the preparation of a whole one, and blocks by their place in the record.

A piece is the place of its first sample and the samples of each channel; samples between two pieces are missing. The
functions take an iterator of pieces and give one, so that they follow each other as those of `transform` and `window`.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.kinds import KINDS

Piece = tuple[int, list[NDArray[Any]]]
"""Place of the first sample, and the samples of each channel."""


def placed(pieces: Iterable[tuple[int, list[NDArray[Any]]]]) -> Iterator[Piece]:
    """Pieces by their place instead of the number of missing samples before them."""
    place = 0
    for lost, columns in pieces:
        yield place + lost, columns
        place += lost + len(columns[0])


def blocks(pieces: Iterable[Piece], size: int, points: int = 0) -> Iterator[Piece]:
    """Blocks of `size` samples, which begin at its multiples however the record was cut; missing samples are NaN.

    With `points`, 1, a block ends with the first sample of the next one, from which the last step is taken. The last
    block ends with the record; where all samples of a block are missing, there is none.

    Examples
    --------
    >>> pieces = [(0, [np.arange(3)]), (5, [np.arange(5, 9)])]
    >>> [(place, column.tolist()) for place, (column,) in blocks(pieces, 4)]
    [(0, [0.0, 1.0, 2.0, nan]), (4, [nan, 5.0, 6.0, 7.0]), (8, [8])]
    """
    begin, parts, full = 0, list[Piece](), size + points
    for first, some in pieces:
        place, columns = first, some
        while length := max(map(len, columns)):
            if place >= begin + full:
                if parts:
                    yield begin, _joined(parts, full)
                begin, parts = place // size * size, []
            room = begin + full - place
            parts.append((place - begin, [values[:room] for values in columns]))
            if length < room:
                break
            yield begin, _joined(parts, full)
            place, columns = place + room - points, [values[room - points :] for values in columns]
            begin, parts = begin + size, []
    if parts:
        yield begin, _joined(parts, parts[-1][0] + max(map(len, parts[-1][1])))


def _joined(parts: list[Piece], size: int) -> list[NDArray[Any]]:
    """The samples of each channel; integers stay integers if none are missing."""
    if sum(len(columns[0]) for _, columns in parts) == size:
        return [
            values[0] if len(values) == 1 else np.concatenate(values)
            for values in zip(*(columns for _, columns in parts), strict=True)
        ]
    joined = [np.full(size, np.nan) for _ in parts[0][1]]
    for place, columns in parts:
        for whole, values in zip(joined, columns, strict=True):
            whole[place : place + len(values)] = values
    return joined


def averaged(pieces: Iterable[Piece], kinds: Sequence[str], m: int, size: int) -> Iterator[Piece]:
    """Means of `m` samples, as `transform.block_means` takes them; `size` is the number that is looked at at once."""
    for place, columns in blocks(pieces, m * max(1, size // m)):
        yield place // m, [means(values, kind, m) for values, kind in zip(columns, kinds, strict=True)]


def means(values: NDArray[Any], kind: str, m: int) -> NDArray[Any]:
    """Means of `m` samples each: of increments and counts sums, of an angle every m-th point."""
    if kind == "angle":
        return values[::m]
    each = values[: len(values) // m * m].reshape(-1, m)
    return np.asarray(each.sum(axis=1) if KINDS[kind][0] else each.mean(axis=1))


def excluded(pieces: Iterable[Piece], kinds: Sequence[str], spans: Sequence[tuple[int, int]]) -> Iterator[Piece]:
    """The pieces without the samples of these spans; points of an angle at their ends belong to the steps beside."""
    for place, columns in pieces:
        kept = []
        for values, kind in zip(columns, kinds, strict=True):
            cuts = [(max(first + KINDS[kind][1] - place, 0), last - place) for first, last in spans]
            inside = [(low, high) for low, high in cuts if low < min(high, len(values))]
            left = np.array(values, dtype=np.float64) if inside else values
            for low, high in inside:
                left[low:high] = np.nan
            kept.append(left)
        yield place, kept


def window(pieces: Iterable[Piece], first: int, end: int | None) -> Iterator[Piece]:
    """The samples from `first` on, up to before `end`, whose places count from there."""
    for place, columns in pieces:
        low, high = max(first - place, 0), None if end is None else max(end - place, 0)
        left = [values[low:high] for values in columns]
        if any(map(len, left)):
            yield place + low - first, left
