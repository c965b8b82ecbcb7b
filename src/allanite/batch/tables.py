"""The tables of a batch: what became of its files, coefficients, points of curves, findings, and their summary."""

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from allanite.core.plain import Value
from allanite.core.readings import MINIMUM
from allanite.core.units import Signal, convert
from allanite.readers.arrow import pa
from allanite.study.results import Channel
from allanite.terms import TERMS

from .executor import Plain
from .sources import OWN
from .store import Store, shown

DONE, FAILED, OPEN = "done", "failed", "open"
"""Status of a file: it has a result, it has none and why is known, it was not reached yet."""

AT_ONCE = 64  # files whose rows are held in memory together


@dataclass(frozen=True)
class FileStatus:
    """A file of a batch, and what became of it."""

    file: str
    facts: dict[str, Any]  # the columns of the manifest
    # key, sha256: the key of its result, and of what content it is; empty if the file cannot be read
    key: str = ""
    sha256: str = ""
    status: str = OPEN  # One of "done", "failed", "open"
    error: str = ""  # why it has failed
    rejected: str = ""  # channels without a result, or whose noise no model explains


@dataclass(frozen=True)
class Resumed:
    """What a run of a batch has done."""

    files: tuple[FileStatus, ...]  # all files, in the order of their names
    analyzed: int  # records that were analyzed now; files with the same content are one
    before: int  # files that were done by an earlier run
    notes: tuple[str, ...] = ()  # what was left out

    @property
    def failed(self) -> tuple[FileStatus, ...]:
        """The files without a result."""
        return tuple(file for file in self.files if file.status != DONE)

    @property
    def rejected(self) -> tuple[str, ...]:
        """File and channel of what has no result, or is not explained by its model."""
        return tuple(f"{file.file}: {file.rejected}" for file in self.files if file.rejected)


def put_files(store: Store, files: Iterable[FileStatus], choices: Plain) -> None:
    """The table of files, with the recipe in its metadata."""
    ordered = sorted(files, key=lambda f: f.file)
    store.put_files([{"file": f.file, **{name: getattr(f, name) for name in OWN}, **f.facts} for f in ordered], choices)


def put_tables(store: Store, files: Iterable[FileStatus]) -> Iterator[FileStatus]:
    """Write the other tables in the order of the files, and yield the files with what their results say of them."""
    # Each result is read once, and a few are held at a time.
    with ExitStack() as stack:
        writers = {name: stack.enter_context(store.writer(name, schema_of(columns)))
                   for name, (columns, _) in TABLES.items()}  # fmt: skip
        ordered = sorted(files, key=lambda file: file.file)
        for i in range(0, len(ordered), AT_ONCE):
            group = ordered[i : i + AT_ONCE]
            parts = [store.get(file.key) if file.status == DONE else {} for file in group]
            for name, (_, rows_of) in TABLES.items():
                results = zip(group, parts, strict=True)
                rows = [row for file, part in results if "study" in part for row in rows_of(file.file, part["study"])]
                if rows:
                    writers[name].write_table(as_table(rows, writers[name].schema))
            for file, part in zip(group, parts, strict=True):  # a stored result may be an error
                error, rejected = part.get("error", ""), part.get("rejected", "")
                settled = replace(file, status=FAILED if error else DONE, error=error, rejected=rejected)
                yield settled if file.status == DONE else file


@dataclass(frozen=True, repr=False)
class Coefficient(Value):
    """The coefficient of a channel: what everything that is found of it over several units has in common."""

    channel: str
    symbol: str
    signal: Signal

    @property
    def sheet_unit(self) -> str:
        """Unit of data sheets."""
        return self.signal.sheet[power_of(self.symbol)]

    @property
    def factor(self) -> float:
        """SI units in one unit of data sheets."""
        return convert(1.0, self.sheet_unit, self.signal.si[power_of(self.symbol)])


@dataclass(frozen=True, repr=False)
class Across(Coefficient):
    """One coefficient of one channel over all units, SI; "minimum" is the minimum of the Allan deviation."""

    units: int  # with a valid result for it, identified or not
    identified: int  # units with a value; the numbers that follow are theirs
    mean: float
    deviation: float  # from unit to unit, with the statistical error of each value in it; NaN of a single one
    worst: float  # the value of the largest size
    file: str  # the unit it belongs to
    below: float | None = None  # the largest upper limit of the units in which the term was not identified

    def row(self) -> list[Any]:
        """Channel, term, numbers of units, mean, spread, worst and its file, upper limit, unit: of data sheets."""
        shown = [v / self.factor for v in (self.mean, self.deviation, self.worst)]
        below = math.nan if self.below is None else self.below / self.factor
        return [self.channel, self.symbol, self.units, self.identified, *shown, self.file, below, self.sheet_unit]

    def _summary(self) -> str:
        return f"{self.channel!r}: {self.symbol}, {self.identified} of {self.units} units"


def power_of(symbol: str) -> float:
    """The power of time in the unit of a coefficient, or of the minimum of the deviation."""
    return 0 if symbol == MINIMUM else TERMS[symbol].power


class Known(NamedTuple):
    """What is known of a coefficient of one unit: its value, or its upper limit."""

    file: str
    value: float | None
    upper: float | None


def gathered(
    channels: Iterable[tuple[str, Channel]], level: float, *, valued: bool = False
) -> list[tuple[tuple[str, str, Signal], list[Known]]]:
    """Channel, symbol and signal of every coefficient, with what is known of it over units."""
    results: dict[tuple[str, str, str], tuple[tuple[str, str, Signal], list[Known]]] = {}
    for file, channel in channels:
        name, signal = channel.record.name, channel.record.signal
        known: list[tuple[str, float | None, float | None]] = [(e.symbol, e.value, None) if e.valued
                                                               else (e.symbol, None, e.upper) for e in channel.fit or ()
                                                               if e.valued or e.status == "absent"]  # fmt: skip
        minimum = None if channel.readings is None else channel.readings.minimum
        if channel.readings is not None and minimum is not None:
            inside, most = channel.readings.inside, minimum.interval(level)[1]
            known.append((MINIMUM, minimum.deviation, None) if inside else (MINIMUM, None, most))
        for symbol, value, upper in known:
            if value is not None or not valued:
                _, units = results.setdefault((name, signal.name, symbol), ((name, symbol, signal), []))
                units.append(Known(file, value, upper))
    return list(results.values())


def across(channels: Iterable[tuple[str, Channel]], level: float) -> tuple[Across, ...]:
    """Every coefficient of every channel over units; see `gathered`."""
    results = []
    for of, units in gathered(channels, level):
        values = np.array([unit.value for unit in units if unit.value is not None], dtype=np.float64)
        mean, spread, worst, file = math.nan, math.nan, math.nan, ""
        if values.size:
            at = int(np.argmax(np.abs(values)))
            mean, worst = float(values.mean()), float(values[at])
            spread = float(values.std(ddof=1)) if values.size > 1 else math.nan
            file = [unit.file for unit in units if unit.value is not None][at]
        below = max((unit.upper for unit in units if unit.value is None and unit.upper is not None), default=None)
        results.append(Across(*of, len(units), values.size, mean, spread, worst, file, below))
    return tuple(results)


Rows = Iterator[dict[str, Any]]
REFUSED = "refused"  # name of the finding about a channel without a result

COEFFICIENTS = {"file": str, "channel": str, "sensor": str, "symbol": str, "status": str, "value": float, "low": float,
                "high": float, "upper": float, "standard_error": float, "unit": str, "level": float,
                "shown_value": float, "shown_low": float, "shown_high": float, "shown_unit": str, "parameters": list,
                "method": str, "reason": str}  # fmt: skip
"""Columns of the coefficients: SI, and as data sheets have them; `parameters` are those of the term's shape."""

CURVES = {"file": str, "channel": str, "statistic": str, "m": int, "tau": float, "deviation": float, "low": float,
          "high": float, "edf": float, "count": int, "unit": str}  # fmt: skip
"""Columns of the curves, SI."""

FINDINGS = {"file": str, "channel": str, "name": str, "what": str, "consequence": str, "remedy": str, "start": float,
            "end": float, "fatal": bool}  # fmt: skip
"""Columns of the findings; those about a file as a whole have an empty channel."""


def coefficients(file: str, study: Plain) -> Rows:
    """A row for each coefficient of each channel, and one for the minimum of the deviation."""
    for channel in study["channels"]:
        of = {"file": file, "channel": channel["name"], "sensor": channel["signal"]}
        for term in (channel["fit"] or {}).get("terms", ()):
            shown = {f"shown_{name}": term["shown"][name] for name in ("value", "low", "high", "unit")}
            same = {name: term[name] for name in COEFFICIENTS if name in term}
            yield of | same | shown | {"parameters": term["shape"]}
        readings = channel["readings"]
        if not readings or not readings["minimum"]:
            continue
        point = readings["minimum"]
        of |= {"symbol": MINIMUM, "unit": readings["unit"], "level": point["level"], "parameters": []}
        of["method"] = "read off"
        if readings["inside"]:
            yield of | {"status": "reading", "value": point["deviation"], "low": point["low"], "high": point["high"]}
        else:  # only a limit is known
            yield of | {"status": "absent", "upper": point["high"], "reason": "not reached in this record"}


def curves(file: str, study: Plain) -> Rows:
    """A row for each averaging time of each curve."""
    arrays = [name for name, kind in CURVES.items() if kind is not str]
    for channel in study["channels"]:
        for curve in channel["curves"]:
            of = {"file": file, "channel": channel["name"], "statistic": curve["statistic"], "unit": curve["unit"]}
            known = {name: curve[name] for name in arrays if curve.get(name) is not None}
            for point in zip(*known.values(), strict=True):
                yield of | dict(zip(known, point, strict=True))


def findings(file: str, study: Plain) -> Rows:
    """A row for each finding about the file, its channels, their fits and residuals, and for each refused channel."""
    yield from (_finding(file, "", finding) for finding in study["findings"])
    for channel in study["channels"]:
        name = channel["name"]
        for part in ("quality", "fit", "residuals"):
            yield from (_finding(file, name, finding) for finding in (channel[part] or {}).get("findings", ()))
        if channel["refusal"]:
            yield {"file": file, "channel": name, "name": REFUSED, "what": channel["refusal"], "fatal": True}


def _finding(file: str, channel: str, finding: Plain) -> dict[str, Any]:
    start, end = finding["place"] or (None, None)
    same = {name: finding[name] for name in FINDINGS if name in finding}
    return {"file": file, "channel": channel, **same, "start": start, "end": end}


TABLES: dict[str, tuple[dict[str, type], Callable[[str, Plain], Rows]]] = {
    "coefficients.parquet": (COEFFICIENTS, coefficients), "curves.parquet": (CURVES, curves),
    "findings.parquet": (FINDINGS, findings),
}  # fmt: skip
"""Name of a table: its columns, and the rows of one study."""


def schema_of(columns: dict[str, type]) -> Any:
    """The columns of a table as Arrow has them."""
    kinds = {str: pa.string(), float: pa.float64(), int: pa.int64(), bool: pa.bool_(), list: pa.list_(pa.float64())}
    return pa.schema([(name, kinds[kind]) for name, kind in columns.items()])


def as_table(rows: list[dict[str, Any]], schema: Any) -> Any:
    """Rows as a table; plain data write numbers that are not finite as words."""
    numbers = {field.name for field in schema if pa.types.is_floating(field.type)}
    clean = [{k: float(v) if k in numbers and isinstance(v, str) else v for k, v in row.items()} for row in rows]
    return pa.Table.from_pylist(shown(clean), schema=schema)
