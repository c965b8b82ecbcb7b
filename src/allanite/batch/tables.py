"""The tables of a batch: a row for each coefficient, point of a curve, and finding, from stored results."""

from collections.abc import Callable, Iterator
from typing import Any

from allanite.core.readings import MINIMUM

from .executor import Plain

Rows = Iterator[dict[str, Any]]
REFUSED = "refused"
"""Name of the finding about a channel without a result."""

COEFFICIENTS = {
    "file": str, "channel": str, "sensor": str, "symbol": str, "status": str, "value": float, "low": float,
    "high": float, "upper": float, "standard_error": float, "unit": str, "level": float, "shown_value": float,
    "shown_low": float, "shown_high": float, "shown_unit": str, "parameters": list, "method": str, "reason": str,
}  # fmt: skip
"""Columns of the coefficients: SI, and as data sheets have them; `parameters` are those of the term's shape."""

CURVES = {
    "file": str, "channel": str, "statistic": str, "m": int, "tau": float, "deviation": float, "low": float,
    "high": float, "edf": float, "count": int, "unit": str,
}  # fmt: skip
"""Columns of the curves, SI."""

FINDINGS = {
    "file": str, "channel": str, "name": str, "what": str, "consequence": str, "remedy": str, "start": float,
    "end": float, "fatal": bool,
}  # fmt: skip
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
    "coefficients.parquet": (COEFFICIENTS, coefficients),
    "curves.parquet": (CURVES, curves),
    "findings.parquet": (FINDINGS, findings),
}
"""Name of a table: its columns, and the rows of one study."""


def schema_of(columns: dict[str, type]) -> Any:
    """The columns of a table as Arrow has them."""
    import pyarrow as pa

    kinds = {str: pa.string(), float: pa.float64(), int: pa.int64(), bool: pa.bool_(), list: pa.list_(pa.float64())}
    return pa.schema([(name, kinds[kind]) for name, kind in columns.items()])


def as_table(rows: list[dict[str, Any]], schema: Any) -> Any:
    """Rows as a table; plain data write numbers that are not finite as words."""
    import pyarrow as pa

    numbers = {field.name for field in schema if pa.types.is_floating(field.type)}
    clean = [{k: float(v) if k in numbers and isinstance(v, str) else v for k, v in row.items()} for row in rows]
    return pa.Table.from_pylist(clean, schema=schema)
