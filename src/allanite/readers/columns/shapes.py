"""Texts and logs whose lines are not simply the rows of one table."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from allanite.core.arrays import complete
from allanite.core.record import Record
from allanite.phrases.phrase import say

from .layout import HEAD, MARKS, cells, cells_of, decoded, is_number, style

FILLED, FEWEST_SAMPLES = 0.5, 32
"""Share of every k-th row that must have a sample, and samples: of fewer the distance may be chance."""


def stride(records: Sequence[Record]) -> tuple[int, int]:
    """First row with a sample, and the distance of such rows: 1 unless all channels have samples in every k-th only."""
    if any(complete(record.values) for record in records):
        return 0, 1
    sampled = np.flatnonzero(np.logical_or.reduce([np.isfinite(record.values) for record in records]))
    step = int(np.gcd.reduce(np.diff(sampled))) if sampled.size > 1 else 1
    filled = sampled.size >= FEWEST_SAMPLES and sampled.size * step > FILLED * len(records[0].values)
    return (int(sampled[0]), step) if step > 1 and filled else (0, 1)


def thinned(records: Sequence[Record], first: int, step: int) -> tuple[Record, ...]:
    """Every `step`-th sample, at the rate of these."""
    what = say("only one row in {step} has samples: the others are left out", step=step)
    return tuple(
        replace(
            record, values=record.values[first::step], rate=record.rate / step,
            start=None if record.start is None else record.start + first / record.rate,
            history=(*record.history, what),
        )
        for record in records
    )  # fmt: skip


def note(records: Sequence[Record], step: int) -> str:
    """The note on their rate."""
    return say("rate {rate:.7g} Hz, since only one row in {step} has samples of {names}; if others were lost rather "
               "than averaged, N is too large by up to sqrt({step})",
               rate=records[0].rate / step, step=step, names=", ".join(record.name for record in records))  # fmt: skip


WIDEST_LINE = 1000  # numbers per line above which the line is a channel and not a sample

_NOVATEL = re.compile(rb"^[#%]RAWIMUS?X?A,[^;\r\n]*;([^*;\r\n]*)\*[0-9a-fA-F]{8}[ \t]*\r?$", re.MULTILINE)
"""RAWIMU, RAWIMUS, RAWIMUX and RAWIMUSX in ASCII: seconds, status, then Z, -Y and X of both sensors end each of them
(NovAtel, OEM7 Commands and Logs Reference Manual)."""

_CHECKSUM = re.compile(rb"\*[0-9A-Fa-f]{2}(?=\r?\n|$)")


def straightened(data: bytes) -> tuple[bytes, tuple[str, ...]]:
    """The text with one line per sample, and a note on what was transposed or joined."""
    if data.lstrip().startswith(b"$"):
        data = without_checksums(data)
    if data.lstrip()[:1] in (b"#", b"%") and _NOVATEL.search(data[:HEAD]):
        return _of_novatel(data)
    # lines of thousands of numbers become columns
    head = data[:HEAD]
    if head.count(b"\n") * WIDEST_LINE > len(head):
        return _joined(data)
    lines = [line for line in _lines(data) if line]
    plain = [line for line in lines if not line.startswith(MARKS[:3])]
    if not plain:
        return _joined(data)
    delimiter, decimal = style([line[:4000] for line in plain])
    rows = [cells(line.strip(delimiter + " "), delimiter) for line in plain]
    if not any(is_number(cell, decimal) for cell in rows[0]):  # a heading: its columns are many
        return data, ()
    if min(map(len, rows)) <= WIDEST_LINE or len({len(row) for row in rows}) > 1:
        return _joined(data)
    names = all(not is_number(row[0], decimal) for row in rows)
    body = "\n".join(map(";".join, zip(*rows, strict=True)))
    length = len(rows[0]) - names
    note = say("the line of {length} numbers is used as one channel", length=length)
    if len(rows) > 1:
        note = say("the {count} lines of {length} numbers are used as channels", count=len(rows), length=length)
    comments = "".join(line + "\n" for line in lines if line.startswith(MARKS[:3]))
    return (comments + body + "\n").encode(), (note,)


def _of_novatel(data: bytes) -> tuple[bytes, tuple[str, ...]]:
    """The rows of logs of increments, in counts whose size is that of the type of IMU, which the log does not state."""
    logs = [fields.split(b",") for fields in _NOVATEL.findall(data)]
    rows = [b",".join((fields[-8], *fields[-6:])) for fields in logs if len(fields) >= 9]
    axes = [f"{sensor}_{axis} [LSB]" for sensor in ("delta_velocity", "delta_angle") for axis in ("z", "-y", "x")]
    note = say("{count} logs RAWIMU of NovAtel are used as rows; other logs are left out", count=len(rows))
    return b"\n".join([",".join(["tow [s]", *axes]).encode(), *rows, b""]), (note,)


def without_checksums(data: bytes) -> bytes:
    """The lines without the checksums of sentences at their ends."""
    return _CHECKSUM.sub(b"", data)


def _joined(data: bytes) -> tuple[bytes, tuple[str, ...]]:
    """Lines that alternate between more and fewer numbers become one line per sample."""
    plain = _uncommented(_lines(data[:HEAD])[:400])
    # those of the same delimiters do not alternate, but for a header
    if len({(*map(line.count, ',;\t"'), len(line.split())) for line in plain[1:]}) < 2:
        return data, ()
    delimiter, decimal = style(plain[-200:])
    rows_of = cells_of(plain, delimiter)
    numeric = [len(row) for row in rows_of if any(is_number(cell, decimal) for cell in row)]
    widths = numeric[:-1] if len(data) > HEAD else numeric
    period = next((n for n in range(2, 7) if len(widths) >= 5 * n and widths[n:] == widths[:-n]), 0)
    if not period or len(set(widths)) < 2:
        return data, ()
    lines = _lines(data)
    kept = _uncommented(lines)
    first = len(plain) - len(numeric)
    above = [f"# {line}" for line in lines[: lines.index(kept[first])] if line and line not in kept[:first]]
    mark = delimiter if delimiter != " " else "  "
    rows = [mark.join(kept[i : i + period]) for i in range(first, len(kept), period)]
    names = [mark.join(kept[:first])] if first == period else kept[:first]
    note = say("{count} lines of {sizes} numbers are used as one row per sample",
               count=period, sizes=", ".join(map(str, numeric[:period])))  # fmt: skip
    return "\n".join([*above, *names, *rows, ""]).encode(), (note,)


def _lines(data: bytes) -> list[str]:
    return [line.strip() for line in decoded(data).splitlines()]


def _uncommented(lines: list[str]) -> list[str]:
    return [line for line in lines if line and not line.startswith(MARKS)]
