"""Tables for the terminal, in ASCII."""

import math
import textwrap
from collections.abc import Iterator, Sequence

from allanite.angle import Plan, Scan
from allanite.core.finding import Finding
from allanite.reporting.sheet import printable
from allanite.reporting.words import duration, percent

from .numbers import Result, lines, noise, others, solution_of

WIDTH = 110


def render(value: "Result | Plan | Scan", level: float = 0.95) -> str:
    """A result as text."""
    body = {Plan: _plan, Scan: _scan}.get(type(value))
    return "\n".join(body(value) if body else _result(value, level)) + "\n"  # type: ignore[arg-type, operator]


def _result(result: Result, level: float) -> Iterator[str]:
    solution = solution_of(result)
    yield f"{solution.innovations.size} readings, {noise(solution)}; condition {solution.condition:.4g}"
    for warning in solution.warnings:
        yield from _prose(f"! {warning}")
    yield from (f"  {check}" for check in solution.checks if check.passed)
    yield ""
    head = ["angle", "order", "S [arcsec]", "+-", "C [arcsec]", "+-", "amplitude", f"{percent(level)} interval",
            "phase [deg]", ""]  # fmt: skip
    rows = [
        [x.angle, str(x.order), x.sine.value, x.sine.error, x.cosine.value, x.cosine.error, x.amplitude, x.interval,
         x.phase, x.status]
        for x in lines(result, level)
    ]  # fmt: skip
    yield from _table(head, rows)
    yield ""
    rest = [[c.name, c.value, c.error, c.unit, c.meaning] for c in others(solution)]
    yield from _table(["along with it", "value", "+-", "unit", ""], rest)


def _plan(plan: Plan) -> Iterator[str]:
    low, high = (math.degrees(v) for v in plan.h)
    setup = plan.setup
    yield (
        f"from {duration(plan.start)} after h = 0 for {duration(setup.duration)}, every {setup.interval:g} s: h from "
        f"{low:.2f} to {high:.2f} deg"
    )
    yield (
        f"latitude {math.degrees(setup.latitude):.6g} deg, q by the {setup.q_law} law, "
        f"noise of one reading {setup.sigma:g}; condition {plan.condition:.4g}"
    )
    yield from _findings(plan.findings)
    yield ""
    yield from _table(
        ["constant", "expected standard deviation"], [[n, f"{e:.4g}"] for n, e in plan.standard_deviations.items()]
    )
    yield ""
    yield f"sum over the {plan.amplitudes} amplitudes: {plan.total:.4g} (all in the unit of sigma)"


def _scan(scan: Scan) -> Iterator[str]:
    most = max(1, len(scan.starts) // 20)
    shown = sorted({*range(0, len(scan.starts), most), int(scan.totals.argmin())})
    rows = [
        [
            f"{scan.starts[i] / 60:.1f}", f"{math.degrees(scan.h[i, 0]):.2f}", f"{math.degrees(scan.h[i, 1]):.2f}",
            f"{scan.totals[i]:.4g}", f"{scan.conditions[i]:.4g}", "<- best" if i == int(scan.totals.argmin()) else "",
        ]
        for i in shown
    ]  # fmt: skip
    yield from _table(["start [min]", "h from [deg]", "to [deg]", "sum of deviations", "condition", ""], rows)
    yield ""
    yield "best window"
    yield from _plan(scan.best)


def _findings(findings: Sequence[Finding]) -> Iterator[str]:
    for finding in findings:
        yield from _prose(f"! {finding}")


def _prose(text: str) -> list[str]:
    return textwrap.wrap(printable(text), WIDTH, initial_indent="  ", subsequent_indent="    ")


def _table(head: list[str], rows: list[list[str]]) -> Iterator[str]:
    columns = list(zip(head, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    # numbers stand to the right, words to the left
    right = [all(cell[:1] in "+-.0123456789" for cell in column[1:] if cell) for column in columns]
    for row in (head, *rows):
        cells = (
            printable(cell).rjust(w) if r else printable(cell).ljust(w)
            for cell, w, r in zip(row, widths, right, strict=True)
        )
        yield ("  " + "  ".join(cells)).rstrip()
