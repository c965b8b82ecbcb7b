"""Reading a file in parts, within the memory that may be used."""

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, inf
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from allanite.core.errors import AllaniteError, UsageError
from allanite.core.record import Record
from allanite.core.validity import Finding
from allanite.phrases.phrase import Phrase, say, spelled

from .clock.clocks import counting
from .clock.parts import Clock, Piece
from .clock.sampling_rate import stamped
from .columns import gravity, sensors
from .columns.column import column
from .columns.lines import Parts, chunks_of
from .columns.table import Sense
from .formats.registry import readable, reader_for, reader_of_type
from .options import Options, channel_names
from .sandbox.packing import PackedFile, packing_of
from .sandbox.process import RATIO
from .sandbox.source import STDIN, checked, head_of, named, size_of

NEED = 9
"""Memory that the analysis of a channel takes, over that of its samples as float64: measured with 3.2e7 of them."""

SMALL = 1 << 28  # bytes that any machine has: whether less is free is not asked

MEMORY_SHARE = 0.5  # share of the available memory that a record may take, unless it is given

UNKNOWN = 1 << 60
"""Bytes that are free on a system that does not tell: reading may fail, as it would without the question."""

MACHINE, OWN = Path("/proc/meminfo"), Path("/proc/self/statm")

_CGROUP = Path("/sys/fs/cgroup")
GROUPS = (
    (_CGROUP / "memory.max", _CGROUP / "memory.current", "inactive_file "),
    (_CGROUP / "memory/memory.limit_in_bytes", _CGROUP / "memory/memory.usage_in_bytes", "total_inactive_file "),
)
"""Limit and use of a container, as its own control group is mounted in it, and the line of what can be given back."""

_SIZE = re.compile(r"\s*(\d+(?:\.\d*)?)\s*([kMGT]?)i?B?\s*", re.IGNORECASE)
_UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "t": 10**12}


def size_in_words(size: float) -> str:
    """A number of bytes with its unit, to three digits."""
    for unit, worth in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= worth:
            return f"{size / worth:.3g} {unit}"
    return f"{size:.0f} B"


def bytes_of(text: str, name: str = "memory") -> int:
    """The size of a choice, such as ``"1GB"`` or ``"500 MB"``."""
    match = _SIZE.fullmatch(text)
    size = float(match[1]) * _UNITS[match[2].lower()] if match else 0.0
    if not 1.0 <= size < inf:
        raise UsageError(f"{spelled(f'--{name}', name)} is a size such as 1GB or 500MB, not {text!r}")
    return int(size)


def available() -> int:
    """Bytes of memory that this process may still take: of the machine, its control group and its address space."""
    return max(0, min(_of_machine(), _of_group(), _of_addresses()))


def _of_machine() -> int:
    free = next((int(line.split()[1]) << 10 for line in _lines(MACHINE) if line.startswith("MemAvailable:")), 0)
    if not free and hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        free = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return free or UNKNOWN


def _of_group() -> int:
    """What the control group of a container leaves; what the system caches of files is given back."""
    free = UNKNOWN
    for limit, used, cached in GROUPS:
        most = next((int(line) for line in _lines(limit) if line.isdigit()), UNKNOWN)
        if most < UNKNOWN:
            lines = _lines(limit.parent / "memory.stat")
            kept = next((int(line.split()[1]) for line in lines if line.startswith(cached)), 0)
            free = min(free, most - int(_lines(used)[0]) + kept)
    return free


def _of_addresses() -> int:
    """What ``ulimit -v`` leaves."""
    try:
        import resource
    except ImportError:  # not of this system
        return UNKNOWN
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most == resource.RLIM_INFINITY:
        return UNKNOWN
    pages = next((int(line.split()[0]) for line in _lines(OWN)), 0)
    return most - pages * resource.getpagesize()


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text().splitlines()
    except OSError:
        return []


def allowed(memory: str | None, share: float = MEMORY_SHARE) -> int:
    """Bytes that a record may take: those given, or a share of those available."""
    return int(share * available()) if memory is None else bytes_of(memory)


def needed(numbers: int, longest: int | None = None) -> int:
    """Bytes that the analysis of so many samples takes, one channel after the other; all are one, or the `longest`."""
    return 8 * (numbers + (NEED - 1) * (numbers if longest is None else longest))


def needed_to_read(size: int, rows: int, columns: int) -> int:
    """Bytes that reading a file of this size takes: the file, its columns, and one of them before it is converted."""
    return size + 8 * rows * (columns + 1)


def at_a_time(sizes: Sequence[int], memory: str | None, limit: int | None) -> Phrase | None:
    """Why channels of so many samples are analyzed one at a time; None where memory suffices for all at once."""
    together = needed(sum(sizes))
    if len(sizes) < 2 or (memory is None and together <= SMALL):
        return None
    limit = allowed(memory) if limit is None else limit
    if together <= limit:
        return None
    return say("the channels were analyzed one after the other: at once they may take {need} of memory, of which "
               "{limit} may be used ({option})", need=size_in_words(together), limit=size_in_words(limit),
               option=spelled("--memory", "memory"))  # fmt: skip


AT_ONCE = 1 << 20  # samples of all columns that are read at a time, at least a sixteenth of them in each
CHARACTERS = 10  # bytes of a file for each sample, where only its size is known


@dataclass(frozen=True, eq=False)
class PartsReader:
    """A file that is read in parts; `pieces` reads it from the beginning, once, and the rest is known after that."""

    name: str
    file: str
    parts: Parts
    sense: Sense
    clock: Clock
    heads: tuple[Record, ...]  # of the first samples, whose rate is not yet that of the whole
    need: int
    limit: int

    @property
    def rows(self) -> int:
        """Number of rows of the file."""
        return self.parts.rows

    @property
    def share(self) -> float:
        """Share of the file that has been read."""
        return min(1.0, self.clock.rows / self.rows)

    def pieces(self, rows: int | None = None) -> Iterator[Piece]:
        """Missing samples before a piece, and the samples of each channel, until the end of the file."""
        signals = [self._place(signal.column.position) for signal in self.sense.signals]
        stamps = self._stamp_places()
        wanted = list(dict.fromkeys((*stamps, *signals)))
        at_once = rows or max(AT_ONCE // len(wanted), AT_ONCE // 16)
        for values in self.parts.blocks(wanted, at_once):
            held = dict(zip(wanted, values, strict=True))
            clock = [self._stamps([held[i] for i in stamps], stamps)] if stamps else []
            yield from self.clock.pieces([*clock, *(held[i] for i in signals)])

    def _place(self, position: int) -> int:
        return next(i for i, column in enumerate(self.parts.head.columns) if column.position == position)

    def _stamp_places(self) -> list[int]:
        """The columns that the clock is made of: one, or seconds and their fractions."""
        clock = self.sense.sources.stamps
        if clock is None or not self.clock.stamped:
            return []
        first = self._place(clock.position)
        head = self.parts.head.columns
        if clock.header == head[first].header:
            return [first]
        rest = clock.header.removeprefix(f"{head[first].header} + ")
        return [first, next(i for i, column in enumerate(head) if column.header == rest)]

    def _stamps(self, found: list[NDArray[Any]], places: list[int]) -> NDArray[Any]:
        heads = [self.parts.head.columns[i] for i in places]
        columns = tuple(
            replace(head, values=column(head.header, values, head.position).values)
            for head, values in zip(heads, found, strict=True)
        )
        return columns[0].values if len(columns) == 1 else sensors.joined(columns, self.parts.options)[0][0].values


def whole_findings(reader: PartsReader) -> tuple[Finding, ...]:
    """Findings about the clock of the whole file, and that a counter without time stamps is not looked at."""
    beat = reader.clock.beat()
    findings = reader.sense.findings(beat, gravity.doubts(reader.sense.choice.signals, beat.rate))
    signals = [signal.column for signal in reader.sense.signals]
    counter = counting(column for column in reader.sense.columns if column not in signals)
    if counter is None or reader.clock.stamped:
        return findings
    what = say("{column} may count samples, which is not looked at when a file is read in parts", column=counter.label)
    return (*findings, Finding("counter", what, say("samples that are missing by it are joined as if there were none")))


def opened(path: Any, memory: str | None, choices: Mapping[str, Any], limit: int | None = None) -> PartsReader | None:
    """The reader in parts of a file of which no single channel fits into memory; None for anything else."""
    if not isinstance(path, (str, os.PathLike)) or path == STDIN:
        return None
    file, member = checked(path)
    limit = allowed(memory) if limit is None else limit
    if needed(size_of(file) * RATIO // 8) <= limit:  # with as many samples as it may hold
        return None
    reader, need = _found(path, file, member, (_options(choices), limit))
    if reader is None and need > limit:
        demand_memory(path, memory, choices)
    return None if need <= limit else reader


def growing(path: Any, choices: Mapping[str, Any], begin: Callable[[], int]) -> PartsReader | None:
    """The reader in parts of a text that grows, each time from the byte that `begin` tells; None for other files."""
    file = os.fspath(path)
    try:
        streamed = getattr(reader_for(head_of(file), os.path.splitext(file)[1].lower()), "streamed", None)
        parts = None if streamed is None else streamed(chunks_of(file, begin), _options(choices), grows=True)
        return None if parts is None else _reader(named(path, file), file, parts, 0)
    except AllaniteError as error:
        raise error.within(named(path, file)) from None


def demand_memory(path: Any, memory: str | None, choices: Mapping[str, Any]) -> None:
    """Refuse a file whose record takes more memory than is there, or than is given."""
    # Parameters are those of `opened`. How many samples a file holds is known for formats that are read in parts, and
    # otherwise estimated by its size.
    if not isinstance(path, (str, os.PathLike)) or path == STDIN:
        return
    file, member = checked(path)
    need = needed(size_of(file) // CHARACTERS)
    if memory is None and need <= SMALL:
        return
    limit = allowed(memory, 1.0)
    if need <= limit:
        return
    reader, need = _found(path, file, member, (_options(choices), limit))
    if need > limit:
        what = say("this job is") if reader else say("this format is")
        raise UsageError(_refused(named(path, os.fspath(path)), need, limit, what))


def _refused(name: str, need: int, limit: int, what: str) -> str:
    more = f"{ceil(need / 10**6)}MB"
    return say("{file}: the record may take {need} of memory, of which {limit} may be used, and {what} not read in "
               "parts (analyze, deviation and spectrum of text, .npy, raw binary, Parquet, HDF5 and ROS bags are); "
               "write the file as one of these, or allow more with {option}",
               file=name, need=size_in_words(need), limit=size_in_words(limit), what=what,
               option=spelled(f"--memory {more}", f"memory={more!r}"))  # fmt: skip


def _options(choices: Mapping[str, Any]) -> Options:
    given: dict[str, Any] = {key: value for key, value in choices.items() if value is not None}
    given |= {key: channel_names(given[key]) for key in ("channels", "along", "sincos") if key in given}
    return Options(**given)


def _found(path: Any, file: str, member: str, how: tuple[Options, int]) -> tuple[PartsReader | None, int]:
    """The reader in parts of a file, and the memory it needs; none where it has none, or fits by its size."""
    # `how` are the options and the memory that may be used.
    options, limit = how
    try:
        form = _format_of(file, member, options)
        if _fits(form, file, limit):
            return None, 0
        parts = _parts(form, file, member, options)
        if parts is None:
            return None, needed(size_of(file) // CHARACTERS)
        reader = _reader(named(path, os.fspath(path)), file, parts, limit)
        return reader, reader.need
    except AllaniteError as error:
        raise error.within(named(path, os.fspath(path))) from None


def _format_of(file: str, member: str, options: Options) -> Any:
    """The reader of a file; None for one that is packed."""
    if member or packing_of(file, readable, options.dtype is not None) is not None:
        return None
    suffix = os.path.splitext(file)[1].lower()
    return reader_of_type(options.dtype) if options.dtype is not None else reader_for(head_of(file), suffix)


def _fits(form: Any, file: str, limit: int) -> bool:
    """Whether a file fits by its size, and by about how many rows and columns it has, which are not counted."""
    size = size_of(file)
    if hasattr(form, "DENSITY") and needed(ceil(size * form.DENSITY)) <= limit:
        return True
    rows, columns = form.shape_of(file) if hasattr(form, "shape_of") else (0, 0)
    return rows > 0 and max(needed(rows * columns, rows), needed_to_read(size, rows, columns)) <= limit


def _parts(form: Any, file: str, member: str, options: Options) -> Parts | None:
    """The parts of a file; None if its format is not read in parts, as most in a packing."""
    if form is None:
        packed = PackedFile(file, member, readable)
        streamed = getattr(reader_for(packed.head, packed.suffix), "streamed", None)
        return None if streamed is None or options.dtype is not None else streamed(packed.chunks, options)
    parts: Parts | None = form.parts(file, options) if hasattr(form, "parts") else None
    return parts


def _reader(name: str, file: str, parts: Parts, limit: int) -> PartsReader:
    options = parts.options
    if options.sincos:  # which need the whole record, whose size is all that is asked for
        options = replace(options, sincos=None, unit="1", kind="value")
    heads = parts.head.recording(options).records
    sense = parts.head.sense(options)
    rows, columns = parts.rows, len(parts.head.columns)
    need = max(needed(rows * len(sense.signals), rows), needed_to_read(size_of(file), rows, columns))
    return PartsReader(name, file, parts, sense, Clock(stamped(sense.sources, options.rate)), heads, need, limit)
