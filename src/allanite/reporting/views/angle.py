"""How harmonic errors of angle sensors are shown, and plans of their estimation."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from allanite.applications.angle import AnglePlan, Calibration, Harmonics, Scan, Solution
from allanite.applications.angle.calibration import Result, parts_of
from allanite.applications.angle.harmonics import NUISANCES
from allanite.applications.angle.plans import AngleStudy
from allanite.applications.angle.solve import MISSING
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.syntax import toml
from allanite.core.units import convert
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.digits import digits, upper_limit
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Part, Plot, Sheet, Table, header_of
from allanite.reporting.words import ARCSEC

from . import view, view_of

BRAND = say("harmonic errors of angle sensors")

ENCODER = {
    "offset": say("constant difference of the two angles"), "drift": say("its linear growth over half the record"),
    "bend": say("its quadratic growth over half the record"),
}  # fmt: skip
"""Parameters estimated together with the harmonics of an encoder."""

OTHERS = (Column(say("constant"), "symbol"), Column(say("value")), Column(say("error")), Column(say("unit"), "unit"),
    Column(say("meaning"), "text", aside=True))  # fmt: skip
"""Columns of the constants that are no harmonics."""

MARKS: dict[str, Mark] = {"identified": "", "weak": "weak", "absent": "quiet"}
STATUSES = {"identified": say("identified"), "weak": say("weak"), "absent": say("absent")}
KEY = say("S and C with one standard error, arcsec. Identified: without the harmonic, an amplitude as large would have "
          "a probability below 1 %. Absent: not identified; the limit is the 95 % upper limit. Weak: identified, but "
          "the residuals are not the noise that the errors and intervals assume. Harmonics that were not requested are "
          "looked for: of 1000 records of white noise, one shows one by chance, and one an outlier.")  # fmt: skip
INNOVATIONS = say("Innovations: each sample minus its prediction from the samples before it, in standard deviations, "
                  "and their autocorrelation. For white noise 99 of 100 values lie in the shaded band.")  # fmt: skip
UNLIMITED = say("Limits of the amplitudes are not shown: they would hold only if the residuals were white noise.")
IN_TIME = say("Error of each sensor at the angles of the record, which move with time, with its confidence band.")
GIMBAL = say(
    "The measured cosine of the angle between the two gyros' momentum vectors minus the computed one is modeled as the "
    "sum of the sensors' errors, each multiplied by the partial derivative of the cosine with respect to its angle, "
    "the errors of the auto-compensating rotation, a daily and a steady drift, and white noise. The columns of ax and "
    "az are an assumption: a small vector fixed in the rotating frame."
)
AGAINST = say("The measured angle minus the reference, wrapped to half a turn, is modeled as a sum of sines and "
              "cosines of multiples of the measured angle, a constant, and white noise.")  # fmt: skip
RECURSIVE = say(
    "The constants are estimated recursively in square-root form: each sample is rotated into the triangular factor of "
    "the information matrix, which gives the least-squares estimate, its covariance, and the innovation of each sample."
)


def _verdict(result: Result, level: float, doubt: bool) -> str:
    rows = [(h, k) for h in parts_of(result) for k in h.orders]
    amplitudes = [say("harmonic {order} of {angle}: {amplitude} arcsec", order=k, angle=h.name or say("the angle"),
                      amplitude=_amplitude(h, k, level)[0]) for h, k in rows if h.found(k)]  # fmt: skip
    present = join(", ", amplitudes)
    absent = [say("{order} of {angle}", order=k, angle=h.name or say("the angle")) for h, k in rows if not h.found(k)]
    if not present:
        sentences = [say("No harmonic was found.")]
    elif any(h.status(k) == "weak" for h, k in rows):
        sentences = [say("Doubtful are {harmonics}.", harmonics=present)]
    else:
        sentences = [say("Found are {harmonics}.", harmonics=present)]
    sentences += [say("Not found: {harmonics}.", harmonics=join(", ", absent))] if absent and present else []
    return join(" ", [*sentences, say("Read the warnings before using the numbers.")] if doubt else sentences)


def _compared(result: Result, solution: Solution, level: float) -> Iterator[Part]:
    """How many of the true constants, where they are known, the intervals contain."""
    if (truth := _truth(result)) and solution.complete:
        limits = {name: solution.interval(name, level) for name in truth}
        inside = say_count(len(limits), "{inside} of {count} true amplitude lies within its {level} limits.",
                           "{inside} of {count} true amplitudes lie within their {level} limits.",
                           inside=sum(limits[name][0] <= true <= limits[name][1] for name, true in truth.items()),
                           level=words.percent(level))  # fmt: skip
        yield Note(inside, "strong")


def _parts(result: Result, solution: Solution, level: float) -> Iterator[Part]:
    missing = [str(finding) for finding in solution.findings if finding.name == MISSING]
    yield from (Note(finding, "strong") for finding in missing)
    if not solution.complete:
        yield Note(UNLIMITED, "strong")
    yield from (Note(warning, "warning") for warning in solution.warnings if warning not in missing)
    yield from (Note(str(check), "good") for check in solution.checks if check.passed)
    yield from _compared(result, solution, level)
    yield _harmonics(result, level)
    share = words.percent(level)
    caption = say("Error of each sensor over one common period of its harmonics, with its {level} confidence band. "
                  "Subtract it from the measured angles to correct them.", level=share)  # fmt: skip
    yield Drawing(lambda: figures.plot_errors(result, level), say("error over the angle"), caption)
    if len(solution.history.count) > 1:
        caption = say("Convergence of the estimates, with their {level} bands. Once a band stops narrowing, more "
                      "samples from the same range add no information.", level=share)  # fmt: skip
        label = say("convergence of the amplitudes")
        yield Drawing(lambda: figures.plot_history(result, solution, level), label, caption)
    if isinstance(result, Calibration):
        gimbals, sensors = result.gimbals, result.harmonics
        label = say("error over time")
        yield Drawing(lambda: figures.plot_error_in_time(gimbals, sensors, level), label, IN_TIME)
    label, title = say("innovations and their autocorrelation"), say("are the residuals white?")
    yield Drawing(lambda: figures.plot_innovations(solution), label, INNOVATIONS, title)
    rows = []
    for name, value, error in zip(solution.names, solution.values.tolist(), solution.errors.tolist(), strict=True):
        if name[0] in "SC" and name[1:2].isdigit():
            continue
        row = NUISANCES.get(name)
        si, unit = ("rad/s", "arcsec/h") if row and row.per_time else ("rad", "arcsec")
        factor = convert(1.0, si, unit)
        rows.append([name, *_constant(value * factor, error * factor), unit, row.meaning if row else ENCODER[name]])
    yield Table(OTHERS, rows, say("other estimated parameters"))


def _harmonics(result: Result, level: float) -> Table:
    """S, C and amplitude of every harmonic."""
    truth = _truth(result)
    true, error = [Column(say("true"))] * bool(truth), Column(say("error"), aside=True)
    aside = [replace(column, aside=True) for column in true]
    heads = (Column(say("harmonic"), "symbol"), Column("S [arcsec]", aside=True), error, *aside,
             Column("C [arcsec]", aside=True), error, *aside, Column(say("amplitude [arcsec]")),
             Column(words.interval(level), "interval"), *true, Column(say("phase [deg]")),
             Column("", "name"))  # fmt: skip
    rows, marks = [], []
    for h in parts_of(result):
        for name, order, *constants, _, _, _, phase, status in h.rows(level)[1]:
            sine, sine_error, cosine, cosine_error = (v / ARCSEC for v in constants)
            pair = [truth[f"{wave}{order} {name}"] / ARCSEC for wave in "SC"] if truth else []
            known = [[f"{v:.4g}"] for v in (*pair, math.hypot(*pair))] if truth else [[], [], []]
            shown = [*_constant(sine, sine_error), *known[0], *_constant(cosine, cosine_error), *known[1],
                     *_amplitude(h, order, level), *known[2]]  # fmt: skip
            angle = "" if status == "absent" else f"{math.degrees(phase):.0f}"
            rows.append([join(" ", (name or say("angle"), str(order))), *shown, angle, STATUSES[status]])
            marks.append(MARKS[status])
    return Table(heads, rows, marks=marks, key=KEY)


def _amplitude(h: Harmonics, order: int, level: float) -> tuple[str, str]:
    """Amplitude and interval, arcsec; of one that was not found its limit; no limits of a model that is incomplete."""
    low, high = h.limits(order, level)
    if low is None or high is None:
        return f"{h.amplitude[h.orders.index(order)] / ARCSEC:.3g}", ""
    if not h.found(order):
        return say("below {limit}", limit=upper_limit(h.upper(order) / ARCSEC).plain()[0]), ""
    size = float(h.amplitude[h.orders.index(order)])
    return digits(size / ARCSEC, low / ARCSEC, high / ARCSEC).plain()


def _constant(value: float, error: float) -> tuple[str, str]:
    """Value and standard error with two digits of the error."""
    shown = digits(value, value - error, value + error, signed=True)
    return shown.plain()[0], digits(error, figures=2).plain()[0]


def _constants(result: Result, solution: Solution, level: float) -> tuple[list[str], list[list[Any]]]:
    """All constants with limits, SI; the true ones of a simulated record."""
    truth = _truth(result)
    rows: list[list[Any]] = []
    for name, value, error in zip(solution.names, solution.values.tolist(), solution.errors.tolist(), strict=True):
        limits = ("" if limit is None else limit for limit in solution.limits(name, level))
        rows.append([name, value, error, *limits, *([truth.get(name, "")] if truth else [])])
    return ["constant", "value", "standard_error", "low", "high", *(["true"] if truth else [])], rows


def _truth(result: Result) -> dict[str, float]:
    return result.truth if isinstance(result, Calibration) else {}


def _study_plot(values: Sequence[AngleStudy], fit: Fit | None, level: float) -> Plot:
    draw = view_of(values[0].result).plot
    if draw is None:
        raise UsageError("a plan of one start has no figure; scan all starts of the interval")
    return draw([study.result for study in values], fit, level)


@view(
    _study_plot,
    lambda study, level: view_of(study.result).rows(study.result, level),  # type: ignore[misc]
)
def study_view(study: AngleStudy, level: float) -> Face:
    """What was estimated or planned from files, with their provenance."""
    return replace(
        view_of(study.result).face(study.result, level),
        header=header_of(study.provenance, study.notes)[0 if study.provenance.get("source") else -1 :],
        choices=toml(study.choices()), provenance=study.provenance, notes=study.notes,
    )  # fmt: skip


@view(
    lambda values, fit, level: figures.plot_errors(values[0], level),
    lambda result, level: result.rows(level) if result.solution is None else _constants(result, result.solution, level),
)
def result_view(result: Result, level: float) -> Face:
    """The harmonics of one angle, or of several that were calibrated together."""
    solution = result.solution
    names = join(", ", [h.name or say("the angle") for h in parts_of(result)])
    title = say("Harmonic errors of {angles}", angles=names)
    if solution is None:
        sheet = Sheet(names, (say("known, not estimated"),), (_harmonics(result, level),))
        return Face(title, BRAND, (sheet,))
    noise = say("noise of one sample {sigma:.4g} arcsec, {origin}; condition {condition:.4g}",
                sigma=solution.sigma / ARCSEC,
                origin=say("given") if solution.given else say("estimated from what is left over"),
                condition=solution.condition)  # fmt: skip
    about = [say_count(solution.innovations.size, "{count} sample", "{count} samples"), noise]
    if isinstance(result, Calibration):
        angles = {name: np.degrees(getattr(result.gimbals, name)) for name in result.angles}
        spans = [say("{angle} from {low:.2f} to {high:.2f} deg", angle=name, low=float(a.min()), high=float(a.max()))
                 for name, a in angles.items()]  # fmt: skip
        about.append(join("; ", spans))
    doubt = bool(solution.warnings)
    verdicts = (_verdict(result, level, doubt),)
    sheet = Sheet(names, about, tuple(_parts(result, solution, level)), verdicts, "alert" if doubt else "")
    model = GIMBAL if isinstance(result, Calibration) else AGAINST
    return Face(title, BRAND, (sheet,), how=(Note(model), Note(RECURSIVE)))


LAWS = {"exact": say("exact"), "linear": say("linear")}

PLANNED = say("No data and no random numbers are involved: the design matrix follows from latitude, time and sway; its "
              "information, together with the prior, gives the covariance of the estimate.")  # fmt: skip
SCANNED = say("Sum of the expected standard deviations of the amplitudes, and condition of the problem, by the start "
              "of the interval.")  # fmt: skip


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
    when = say("from {start} after h = 0 for {length}, every {interval:g} s: h from {low:.2f} to {high:.2f} deg",
               start=words.duration(plan.start), length=words.duration(chosen.duration), interval=chosen.interval,
               low=low, high=high)  # fmt: skip
    where = say("latitude {latitude:.6g} deg, q by the {law} law, noise of one sample {sigma:g}; {prior}; condition "
                "{condition:.4g}", latitude=math.degrees(chosen.latitude), law=LAWS[chosen.q_law], sigma=chosen.sigma,
                prior=prior, condition=plan.condition)  # fmt: skip
    alerts = [Note(str(finding), "warning") for finding in plan.findings]
    total = say_count(plan.amplitudes, "sum over the {count} amplitude: {total:.4g} (all in the unit of sigma)",
                      "sum over the {count} amplitudes: {total:.4g} (all in the unit of sigma)",
                      total=plan.total)  # fmt: skip
    if chosen.sway is not None and not isinstance(chosen.sway, tuple):
        sway = say("sway of {roll:.3g} deg in roll and {pitch:.3g} deg in pitch, period {period:g} s",
                   roll=math.degrees(chosen.sway.roll), pitch=math.degrees(chosen.sway.pitch),
                   period=chosen.sway.period)  # fmt: skip
        where = join("; ", (where, sway))
    if (ring := chosen.ring) is not None:
        turned = say("outer ring turned at {rate:.4g} deg/min between {low:.4g} and {high:.4g} deg about an axis at "
                     "{heading:.4g} deg from north", rate=math.degrees(ring.rate) * 60, low=math.degrees(ring.low),
                     high=math.degrees(ring.high), heading=math.degrees(ring.heading))  # fmt: skip
        steps = [say("in steps of {step:.4g} deg", step=math.degrees(ring.step))] if ring.step else []
        where = join("; ", (where, join(", ", (turned, *steps))))
    tables = [Table(CONSTANTS, plan.rows()[1], details=compared is not None)]
    if compared is None:
        rows = [[name, _minutes(first), _minutes(plan.mean_periods[name])] for name, first in plan.periods.items()]
        tables.append(Table(PERIODS, rows, say("periods of the harmonics")))
    else:
        rows = [[name, *map(_minutes, periods)] for name, periods in compared.mean_periods.items()]
        heads = (Column(say("mean period [min]"), "symbol"), *_ranges(compared))
        tables.insert(0, Table(heads, rows, say("mean periods of the harmonics by range of h, min")))
    return Sheet(title, (when, where), (*alerts, *tables, Note(total)))


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.2f}"


PERIODS = (Column(say("harmonic"), "symbol"), Column(say("at the start [min]")), Column(say("mean [min]")))
CONSTANTS = (Column(say("constant"), "symbol"), Column(say("expected standard deviation"), form=".4g"))
WINDOWS = (
    Column(say("start [min]"), form=lambda start: f"{start / 60:.1f}"), Column(say("h from [deg]"), form=_degrees),
    Column(say("to [deg]"), form=_degrees), Column(say("sum of deviations"), form=".4g"),
    Column(say("condition"), form=".4g"),
)  # fmt: skip

MAX_WINDOWS = 8  # Windows that stand side by side in a table


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
        length=words.duration(best.settings.duration), start=words.duration(best.start), low=low, high=high,
        total=best.total,
    )  # fmt: skip
    marks: list[Mark] = ["strong" if i == scan.totals.argmin() else "" for i in range(len(scan.starts))]
    parts: list[Part] = [
        Drawing(lambda: figures.plot_scan(scan), say("expected accuracy by the start of the interval"), SCANNED),
        Table(WINDOWS, [row[: len(WINDOWS)] for row in scan.rows()[1]], say("all windows"), marks=marks, details=True),
    ]
    few = scan if len(scan.starts) <= MAX_WINDOWS else None
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
