"""Plans of recordings and checks of the identification as text, in ASCII, for a terminal."""

import math
import textwrap
from collections.abc import Iterator, Sequence

from allanite.core.model import Model
from allanite.planning.bound import name_of
from allanite.planning.plan import RecordingPlan
from allanite.planning.selfcheck import SelfCheck
from allanite.reporting.sheet import printable
from allanite.study.analysis import Channel

from . import words

LEGEND = (
    "Least relative standard errors (1 sigma, Cramer-Rao) of the coefficients by the length of the record; up to 25 % "
    "a term is called identified, above 40 % it is hardly seen. The default method reaches them where they are below "
    "about 12 %."
)


def plan_text(plan: RecordingPlan, name: str = "", *, notes: Sequence[str] = (), width: int = 120) -> str:
    """The table of a plan: relative standard errors by length, and the length for the wanted accuracy."""
    headings = ["", "expected", *(words.duration(d) for d in plan.durations), f"for {_percent(plan.accuracy)}"]
    values = expected_values(plan.model)
    rows = [
        [parameter, values.get(parameter, ""), *map(_percent, errors), _length(needed)]
        for parameter, errors, needed in zip(plan.names, plan.errors.tolist(), plan.needed.tolist(), strict=True)
    ]
    ramp = "a ramp of unknown size is reckoned with" if plan.ramp else "no ramp"
    first = f"{printable(name) or 'plan'}  {plan.rate:.8g} Hz, {ramp}"
    lines = [first, *(part for note in notes for part in wrapped(note, width)), *aligned([headings, *rows], left=2)]
    return "".join(f"{line}\n" for line in lines)


def notes_of(channel: Channel) -> list[str]:
    """What must be known of a channel whose model is taken for a sensor's: doubts, and what was not found."""
    absent = [e for e in channel.fit or () if e.value is None and e.upper is not None]
    limits = ", ".join(f"{e.symbol} {e.words()}" for e in absent)
    return [
        *(f"! {printable(alert)}" for alert in words.alerts(channel)),
        *([f"of this record, and not reckoned with: {limits}"] if limits else []),
    ]


def expected_values(model: Model) -> dict[str, str]:
    """Each parameter's value in the unit of data sheets."""
    found = {}
    for t in model:
        name, unit = name_of(t, model), t.signal.sheet[t.row.power]
        found[name] = f"{t.to(unit):.4g} {unit}"
        found |= {
            f"{name} {p.name.replace('_', ' ')}": f"{value:.4g} {p.unit}"
            for p, value in zip(t.row.parameters, t.shape, strict=True)
        }
    return found


def aligned(rows: Sequence[Sequence[str]], *, left: int = 1) -> Iterator[str]:
    """Rows as lines, the first `left` columns to the left and the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [c.ljust(w) if i < left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        yield f"  {'  '.join(cells)}".rstrip()


def wrapped(text: str, width: int) -> list[str]:
    """Prose, indented."""
    return textwrap.wrap(text, max(width, 40), initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False)


def _percent(error: float) -> str:
    if math.isnan(error):
        return "-"
    return f"{100 * error:.2g} %" if error < 1 else "> 100 %"


def _length(seconds: float) -> str:
    if not math.isfinite(seconds):
        return "never"
    return words.duration(float(f"{seconds:.2g}")) if seconds < 100 * 365.25 * 86400 else "> 100 years"


CHECKED = (
    "bound: least relative standard error (Cramer-Rao); bias and spread of the coefficient, relative to the truth; "
    "coverage: share of the printed intervals that hold the truth; found: share of records in which the term is said "
    "to be there. +- is the Monte-Carlo standard error."
)


def check_text(check: SelfCheck, name: str = "", *, width: int = 120) -> str:
    """The table of a check."""
    headings = ["", "truth", "bound", "bias", "spread", "coverage", "found"]
    values = expected_values(check.model)
    rows = [
        [c.symbol, values.get(c.symbol, "") if c.truth else "absent", _percent(c.bound)]
        + [_with_error(m) for m in (c.bias, c.spread, c.coverage, c.found)]
        for c in check.terms
    ]
    length = words.duration(check.size / check.rate)
    first = (
        f"{printable(name) or 'check'}  {check.records} records of {check.size} readings at {check.rate:.8g} Hz "
        f"({length}), intervals at {words.percent(check.level)}"
    )
    doubt = f"said of no model to explain the record: {_with_error(check.unexplained)} of records"
    notes = [part for note in (doubt, *check.notes) for part in wrapped(note, width)]
    return "".join(f"{line}\n" for line in (first, *aligned([headings, *rows], left=2), *notes))


def _with_error(measured: tuple[float, float]) -> str:
    """A share with its error in percent, to the digits that the error leaves."""
    value, error = measured
    if math.isnan(value):
        return "-"
    places = max(0, min(3, 1 - math.floor(math.log10(100 * error)))) if error > 0 else 1
    return f"{100 * value:.{places}f} +- {100 * error:.{places}f} %"
