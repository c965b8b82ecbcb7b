"""How plans of the estimation of angle sensors are shown."""

import math
from collections.abc import Iterator
from dataclasses import replace

from allanite.applications.angle import AnglePlan, Scan
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Part, Sheet, Table

from . import view

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


def _periods(plan: AnglePlan) -> Table:
    """Of each harmonic, at the start and over the interval."""
    heads = (Column(say("harmonic"), "symbol"), Column(say("at the start [min]")), Column(say("mean [min]")))
    rows = [[name, _minutes(first), _minutes(plan.mean_periods[name])] for name, first in plan.periods.items()]
    return Table(heads, rows, say("periods of the harmonics"))


def _mean_periods(scan: Scan) -> Table:
    """Of each harmonic by start."""
    rows = [[name, *map(_minutes, periods)] for name, periods in scan.mean_periods.items()]
    title = say("mean periods of the harmonics by range of h, min")
    return Table((Column(say("mean period [min]"), "symbol"), *_ranges(scan)), rows, title)


def _ranges(scan: Scan) -> Iterator[Column]:
    return (Column(f"{math.degrees(low):.1f}..{math.degrees(high):.1f}") for low, high in scan.h)


def _minutes(period: float) -> str:
    return f"{period / 60:.1f}" if math.isfinite(period) else say("infinite")


def _plan_sheet(plan: AnglePlan, title: str, compared: Scan | None = None) -> Sheet:
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
    alerts = [Note(str(finding), "warning") for finding in plan.findings]
    total = say_count(
        plan.amplitudes,
        "sum over the {count} amplitude: {total:.4g} (all in the unit of sigma)",
        "sum over the {count} amplitudes: {total:.4g} (all in the unit of sigma)",
        total=plan.total,
    )
    if chosen.sway is not None and not isinstance(chosen.sway, tuple):
        sway = say(
            "sway of {roll:.3g} deg in roll and {pitch:.3g} deg in pitch, period {period:g} s",
            roll=math.degrees(chosen.sway.roll),
            pitch=math.degrees(chosen.sway.pitch),
            period=chosen.sway.period,
        )
        where = join("; ", (where, sway))
    if (ring := chosen.ring) is not None:
        turned = say(
            "outer ring turned at {rate:.4g} deg/min between {low:.4g} and {high:.4g} deg about an axis at "
            "{heading:.4g} deg from north",
            rate=math.degrees(ring.rate) * 60,
            low=math.degrees(ring.low),
            high=math.degrees(ring.high),
            heading=math.degrees(ring.heading),
        )
        steps = [say("in steps of {step:.4g} deg", step=math.degrees(ring.step))] if ring.step else []
        where = join("; ", (where, join(", ", (turned, *steps))))
    accuracy = Table(CONSTANTS, plan.rows()[1], details=compared is not None)
    tables = (accuracy, _periods(plan)) if compared is None else (_mean_periods(compared), accuracy)
    return Sheet(title, (when, where), (*alerts, *tables, Note(total)))


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.2f}"


CONSTANTS = (Column(say("constant"), "symbol"), Column(say("expected standard deviation"), form=".4g"))
WINDOWS = (
    Column(say("start [min]"), form=lambda start: f"{start / 60:.1f}"), Column(say("h from [deg]"), form=_degrees),
    Column(say("to [deg]"), form=_degrees), Column(say("sum of deviations"), form=".4g"),
    Column(say("condition"), form=".4g"),
)  # fmt: skip

FEW = 8
"""Windows that stand side by side in a table."""


@view(rows=lambda plan, level: plan.rows())
def plan_view(plan: AnglePlan, _: float) -> Face:
    """What one experiment would tell."""
    return Face(
        say("Expected accuracy of the angle sensors"), BRAND, (_plan_sheet(plan, say("plan")),), how=(Note(PLANNED),)
    )


@view(lambda values, fit, level: figures.plot_scan(values[0]), lambda scan, level: scan.rows())
def scan_view(scan: Scan, level: float) -> Face:
    """What experiments would tell by their start, and the best one."""
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
    marks: list[Mark] = ["strong" if i == scan.totals.argmin() else "" for i in range(len(scan.starts))]
    parts: list[Part] = [
        Drawing(lambda: figures.plot_scan(scan), say("expected accuracy by the start of the interval"), SCANNED),
        Table(WINDOWS, [row[: len(WINDOWS)] for row in scan.rows()[1]], say("all windows"), marks=marks, details=True),
    ]
    few = scan if len(scan.starts) <= FEW else None
    if few is not None:  # the amplitudes by range of h
        rows = [
            [say("sum"), *(f"{t:.4g}" for t in scan.totals)],
            [say("sum / best"), *(f"{t / scan.totals.min():.3g}" for t in scan.totals)],
            *([name, *(f"{e:.3g}" for e in row)] for name, row in zip(scan.names, scan.errors.T, strict=True)),
        ]
        title = say("expected standard deviations of the amplitudes by range of h, deg")
        parts.append(Table((Column(say("h [deg]"), "symbol"), *_ranges(scan)), rows, title))
    sheet = replace(_plan_sheet(best, say("best window"), few), verdicts=(verdict,))
    return Face(say("Where to estimate the angle sensors"), BRAND, (sheet,), parts=parts, how=(Note(PLANNED),))
