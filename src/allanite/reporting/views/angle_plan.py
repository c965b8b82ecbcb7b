"""How plans of the estimation of angle sensors are shown."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from allanite.applications.angle import AnglePlan, Scan
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Sheet, Table, columns

from . import View

if TYPE_CHECKING:
    from allanite.applications.angle import Sway

BRAND = say("harmonic errors of angle sensors")

LAWS = {"exact": say("exact"), "linear": say("linear")}

PLANNED = say(
    "No data and no random numbers are involved: the design matrix follows from latitude, time and sway; its "
    "information, together with the prior, gives the covariance of the estimate."
)
SCANNED = say(
    "Sum of the expected standard deviations of the amplitudes, and condition of the problem, by the start of the "
    "interval."
)


def _plan_sheet(plan: AnglePlan, title: str) -> Sheet:
    low, high = (math.degrees(v) for v in plan.h)
    chosen = plan.settings
    known = chosen.prior
    if known is None:
        prior = say("nothing known before")
    else:
        prior = say("known before to {amplitudes:g} (amplitudes) and {rest:g}", amplitudes=known[0], rest=known[1])
    when = say(
        "from {start} after h = 0 for {length}, every {interval:g} s: h from {low:.2f} to {high:.2f} deg",
        start=words.duration(plan.start),
        length=words.duration(chosen.duration),
        interval=chosen.interval,
        low=low,
        high=high,
    )
    where = say(
        "latitude {latitude:.6g} deg, q by the {law} law, noise of one sample {sigma:g}; {prior}; condition "
        "{condition:.4g}",
        latitude=math.degrees(chosen.latitude),
        law=LAWS[chosen.q_law],
        sigma=chosen.sigma,
        prior=prior,
        condition=plan.condition,
    )
    rows = [[name, f"{error:.4g}"] for name, error in plan.standard_deviations.items()]
    alerts = [Note(str(finding), "alert") for finding in plan.findings]
    table = Table((Column(say("constant"), "symbol"), Column(say("expected standard deviation"))), rows)
    total = say_count(
        plan.amplitudes,
        "sum over the {count} amplitude: {total:.4g} (all in the unit of sigma)",
        "sum over the {count} amplitudes: {total:.4g} (all in the unit of sigma)",
        total=plan.total,
    )
    return Sheet(title, (when, join("; ", [where, *_sway(chosen.sway)])), (*alerts, table, Note(total)))


def _sway(sway: "Sway | tuple[float, float] | None") -> Iterator[str]:
    if sway is None or isinstance(sway, tuple):
        return
    yield say(
        "sway of {roll:.3g} deg in roll and {pitch:.3g} deg in pitch, period {period:g} s",
        roll=math.degrees(sway.roll),
        pitch=math.degrees(sway.pitch),
        period=sway.period,
    )


def _plan_face(plan: AnglePlan, level: float) -> Face:
    title = say("Expected accuracy of the angle sensors")
    return Face(title, BRAND, (_plan_sheet(plan, say("plan")),), how=(Note(PLANNED),))


def _scan_face(scan: Scan, level: float) -> Face:
    best = scan.best
    low, high = (math.degrees(v) for v in best.h)
    verdict = say_count(
        best.amplitudes,
        "The best window of {length} begins {start} after h = 0, h from {low:.1f} to {high:.1f} deg: the expected "
        "standard deviations of the {count} amplitude add up to {total:.3g}.",
        "The best window of {length} begins {start} after h = 0, h from {low:.1f} to {high:.1f} deg: the expected "
        "standard deviations of the {count} amplitudes add up to {total:.3g}.",
        length=words.duration(best.settings.duration),
        start=words.duration(best.start),
        low=low,
        high=high,
        total=best.total,
    )
    heads = columns(
        say("start [min]"),
        say("h from [deg]"),
        say("to [deg]"),
        say("sum of deviations"),
        say("condition"),
        left=0,
    )
    rows = [
        [f"{s / 60:.1f}", f"{math.degrees(a):.2f}", f"{math.degrees(b):.2f}", f"{t:.4g}", f"{c:.4g}"]
        for s, a, b, t, c in zip(scan.starts, *scan.h.T, scan.totals, scan.conditions, strict=True)
    ]
    marks: list[Mark] = ["strong" if i == scan.totals.argmin() else "" for i in range(len(rows))]
    drawing = Drawing(lambda: figures.plot_scan(scan), say("expected accuracy by the start of the interval"), SCANNED)
    table = Table(heads, rows, say("all windows"), marks=marks, details=True)
    sheet = replace(_plan_sheet(best, say("best window")), verdicts=(verdict,))
    title = say("Where to estimate the angle sensors")
    few = (_ranges(scan),) if len(scan.starts) <= FEW else ()
    return Face(title, BRAND, (sheet,), parts=(drawing, table, *few), how=(Note(PLANNED),))


FEW = 8
"""Windows that stand side by side in a table."""


def _ranges(scan: Scan) -> Table:
    """The amplitudes by range of h."""
    heads = [f"{math.degrees(low):.1f} .. {math.degrees(high):.1f}" for low, high in scan.h]
    rows = [[name, *(f"{e:.3g}" for e in row)] for name, row in zip(scan.names, scan.errors.T.tolist(), strict=True)]
    least = scan.totals.min()
    rows.append([say("sum"), *(f"{t:.4g}" for t in scan.totals)])
    rows.append([say("sum over that of the best"), *(f"{t / least:.3g}" for t in scan.totals)])
    title = say("expected standard deviations of the amplitudes by range of h, deg")
    return Table((Column(say("constant"), "symbol"), *(Column(head) for head in heads)), rows, title)


PLAN = View(_plan_face, rows=lambda plan, level: plan.rows())
SCAN = View(_scan_face, lambda values, fit, level: figures.plot_scan(values[0]), lambda scan, level: scan.rows())
