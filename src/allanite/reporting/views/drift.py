"""How a drift is shown: each quantity with time, what causes it, and what a requirement allows."""

import math
from collections.abc import Iterator
from pathlib import PurePath

import numpy as np

from allanite.claims.drift import AllowedTerm, Drift, DriftCourse, DriftShare
from allanite.claims.drift_settings import QUANTITIES, Requirement
from allanite.core.units import convert, signal_named
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits, rounded, upper_limit
from allanite.reporting.first import DETAILS, FIGURES, Answer, First, Remark, plus_minus
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Sheet, Table, header_of

from . import view

BRAND = say("drift without aid")
MIN_NAMED_SHARE, MIN_GIVEN_SHARE, MIN_RAISED_SHARE = 0.005, 1e-4, 0.1
"""Shares of the variance from which on a cause is named and has its share; how much limits that are shown add."""

HOW = say(
    "Standard deviations (1 sigma) from the structure function of each noise term; nothing is simulated. Heading and "
    "attitude err by x(t) - x(0) - (t/T)(x(0) - x(-T)), where x is the integral of the gyro's error and T the time "
    "over which its bias was averaged. The accelerometer's error and, strapdown, gravity times the error of attitude "
    "are integrated to velocity and position. Of several axes the worst at each time is taken."
)
INTERVALS = say(
    "The interval is that of the coefficients, combined by their correlation (method of variance estimates recovery); "
    '"at most" includes terms that were not identified, at their upper limits.'
)
CAPTION = say(
    "Standard deviation against the time without aid: all causes (black, with its interval), and each of them; dotted: "
    "with the upper limits of terms that were not identified."
)
AT_MOST_KEY = say("≤ with the upper limits of terms that were not identified.")
MIN_CURVED_TIME_S = 900.0
"""Times, s, from which on the earth's curvature counts: a tenth of the Schuler period and more."""
MAX_TILT_RAD = 0.5  # tilt, rad, from which on its sine is not the angle


def _alike(value: Drift) -> list[tuple[str, DriftCourse]]:
    """Each quantity with its name; heading and attitude together where they are the same."""
    courses = {name: value[name] for name in value.quantities}
    heading, attitude = courses.get("heading"), courses.get("attitude")
    if heading is None or attitude is None or not np.allclose(heading.sigma, attitude.sigma, rtol=1e-9):
        return [(course.title, course) for course in courses.values()]
    return [
        (say("heading, attitude"), heading),
        *((course.title, course) for name, course in courses.items() if name not in ("heading", "attitude")),
    ]


def _cause(share: DriftShare, *, named: bool) -> str:
    """A cause, with its sensor where there are several."""
    return join(" ", (signal_named(share.sensor).name, share.cause.name)) if named else share.cause.name


def _several(course: DriftCourse) -> bool:
    return len({share.sensor for share in course.shares}) > 1


def _lost(value: Drift) -> float:
    """The time, s, from which on the tilt is so large that velocity and position are lost."""
    tilt = value["attitude"] if value.settings.platform == "strapdown" and "attitude" in value.quantities else None
    lost = [] if tilt is None else tilt.times[np.where(tilt.sigma > 0, tilt.sigma, tilt.most) > MAX_TILT_RAD].tolist()
    return min(lost, default=math.inf)


def _cells(course: DriftCourse, lost: float) -> list[str]:
    """The standard deviation at each time, with the half width of its interval and what it is at most."""
    scale, cells = course.scale, []
    for size, low, high, most in zip(course.sigma, course.low, course.high, course.most, strict=True):
        upper = high if math.isfinite(high) else size
        shown = plus_minus(size * scale, low * scale, high * scale) if size else ""
        limit = f"≤ {upper_limit(most * scale).plain()[0]}" if most > (1 + MIN_RAISED_SHARE) * upper else ""
        cells.append(f"{shown} ({limit})" if shown and limit else shown or limit)
    gone = course.times >= (lost if course.name in ("velocity", "position") else math.inf)
    return [say("lost") if past else cell for past, cell in zip(gone.tolist(), cells, strict=True)]


def _percent(share: float) -> str:
    """A share of the variance."""
    return words.percent(share, 2 if share < 0.995 else 3)


def _mostly(course: DriftCourse, i: int, count: int) -> str:
    """The largest causes at a time, with their shares of the variance."""
    causes = [s for s in course.shares if not s.cause.limit and s.variance.any()] or course.shares
    whole = math.fsum(float(s.variance[i]) for s in causes)
    shares = [(float(s.variance[i]) / whole, s) for s in causes if whole]
    largest = sorted((pair for pair in shares if pair[0] >= MIN_NAMED_SHARE), key=lambda pair: -pair[0])[:count]
    named, before, told = _several(course), "", list[str]()
    for part, s in largest:
        cause = _cause(s, named=named and s.sensor != before)
        told.append(join(" ", (cause, _percent(part))))
        before = s.sensor
    return join(", ", told)


def _after(value: Drift) -> list[str]:
    return [words.duration(time) for time in value.settings.times]


def _required(value: Drift, need: Requirement) -> Iterator[Answer]:
    """What a requirement allows."""
    reached, si = value.reached(need), QUANTITIES[need.quantity].si
    scale = convert(1.0, si, need.unit)
    asked = say("{quantity} after {time}: {limit:.4g} {unit} required", quantity=QUANTITIES[need.quantity].title,
                time=words.duration(need.time), limit=need.limit * scale, unit=need.unit)  # fmt: skip
    if reached is not None:
        size = rounded(reached * scale)
        kept = say("kept") if reached <= need.limit else say("exceeded")
        if reached <= need.limit < value.course(need.quantity, [need.time]).most[0]:
            kept = say("kept, unless terms that were not identified are at their limits")
        asked = say("{asked}, {size} {unit} predicted: {kept}", asked=asked, size=size, unit=need.unit, kept=kept)
    yield asked
    terms = list(value.allowing(need))
    heads = [Column("", "name"), Column("", "symbol"), Column(say("alone"), form=rounded),
             Column(say("with equal shares"), form=rounded),
             Column(say("found")), Column("", "unit")]  # fmt: skip
    scaled = [(t, convert(1.0, t.signal.si[t.power], t.unit)) for t in terms]
    rows = [[t.signal.name, t.name, t.alone * k, t.shared * k, _found(t, k), t.unit] for t, k in scaled]
    yield Table(heads, rows, where="")


def _found(term: AllowedTerm, scale: float) -> str:
    """The coefficient of the record as it is shown by analyze."""
    if not term.found:
        return ""
    size = term.found * scale
    return digits(size, *(limit * size for limit in term.limits)).plain()[0]


def _remarks(value: Drift) -> list[Remark]:
    """What limits the answer."""
    settings, last, sensors = value.settings, value.settings.times[-1], {axis.sensor for axis in value.axes}
    longest = min((axis.longest for axis in value.axes if axis.longest), default=math.inf)
    strapdown = settings.platform == "strapdown" and bool(sensors)
    lost = _lost(value)
    told = (
        (lost < math.inf, say("from {time} on the tilt is not small: velocity and position are lost",
                              time=words.duration(min(lost, last))), ""),
        (last > longest, say("beyond {longest} the record says nothing: there the drift is that of the model alone",
                             longest=words.duration(min(longest, last))), ""),
        *((True, note, "") for note in value.notes),
        (strapdown and "accelerometer" not in sensors,
         say("velocity and position without the errors of accelerometers, whose noise is not known"), ""),
        (strapdown and "gyro" not in sensors,
         say("velocity and position without the tilt: the noise of gyros is not known"), ""),
        (last >= MIN_CURVED_TIME_S and not settings.schuler and "velocity" in value.quantities,
         say("after 15 min the curvature of the earth reduces the drift of velocity and position"), "--schuler"),
    )  # fmt: skip
    limits = [
        Remark("", (text,), command) if command else Remark.of("", text) for applies, text, command in told if applies
    ]
    grave = [Remark.of("", alert, grave=True) for alert in value.alerts]
    return [*grave, *limits]


def _said(value: Drift) -> list[str]:
    """What was assumed."""
    settings = value.settings
    averaged = say("bias averaged at rest for {time} before", time=words.duration(settings.averaged))
    if not settings.averaged:
        averaged = say("no calibration: flicker and random walks are counted from their value at the start")
    platform = say("strapdown") if settings.platform == "strapdown" else say("platform kept level")
    axes = dict.fromkeys(axis.channel for axis in value.axes if axis.channel)
    worst = [say("the worst of {axes} at each time", axes=", ".join(axes))] if len(axes) > 1 else []
    constant = [say("turn-on bias {bias}", bias=" and ".join(settings.turn_on))] if settings.turn_on else []
    return [say("1 sigma"), platform, averaged, *constant, *worst]


def first_of_drift(value: Drift, _: float) -> First:
    """Each quantity with time, and what causes it or what the first requirement allows."""
    answer: list[Answer] = []
    courses = _alike(value)
    if value.axes:
        heads = [Column(say("after"), "name"), *(Column(f"{name} [{course.unit}]", "name") for name, course in courses)]
        cells = (_cells(course, _lost(value)) for _, course in courses)
        answer.append(Table(heads, list(zip(_after(value), *cells, strict=True))))
    for need in value.settings.requirements:
        answer += _required(value, need)
    if value.axes and not value.settings.requirements:
        heads = [Column(say("caused by"), "name"), *(Column(name, "name") for name, _ in courses)]
        count = 2 if len(courses) < 4 else 1  # as there is room for
        rows = [[after, *(_mostly(course, i, count) for _, course in courses)] for i, after in enumerate(_after(value))]
        answer.append(Table(heads, rows))
    after = [DETAILS, FIGURES]
    if not value.settings.requirements:
        after.append(("--require '1 deg in 10 min'", say("what is allowed")))
    legend = [("≤|<=", AT_MOST_KEY)]
    return First(_title(value), "", answer, _remarks(value), legend, _said(value), after)


def _title(value: Drift) -> str:
    source = PurePath(value.provenance.get("source", "")).name
    return say("Drift of {source} without aid", source=source) if source else say("Drift without aid")


def _parts(value: Drift, name: str, course: DriftCourse) -> Iterator[Part]:
    """All numbers of a quantity: the total, and each cause."""
    scale = course.scale
    heads = [Column(say("after"), "name"),
             *(Column(text, form=rounded) for text in (say("1 sigma"), say("low"), say("high"), say("at most"))),
             Column(say("unit"), "unit")]  # fmt: skip
    table = zip(_after(value), *(v * scale for v in (course.sigma, course.low, course.high, course.most)), strict=True)
    yield Table(heads, [[*row, course.unit] for row in table], name)
    named, known = _several(course), [s for s in course.shares if s.variance.any()]
    causes = [
        Column(say("cause"), "name"), Column(say("channel"), "name"), *(Column(a, form=_sized) for a in _after(value)),
    ]  # fmt: skip
    rows = []
    for s in known:
        label = _cause(s, named=named)
        sizes = np.sqrt(s.variance) * scale
        shares = s.variance / np.where(course.sigma > 0, course.sigma**2, math.inf)
        cells = list(zip(sizes.tolist(), shares.tolist(), strict=True))
        if s.cause.limit:
            label, cells = say("{cause}, at most", cause=label), [(size, math.nan) for size in sizes.tolist()]
        rows.append([label, ", ".join(dict.fromkeys(s.channels)), *cells])
    yield Table(causes, rows, say("each cause alone [{unit}], and its share of the variance", unit=course.unit))


def _sized(cell: tuple[float, float]) -> str:
    size, share = cell
    shown = digits(size, figures=3).plain()[0]
    return shown if math.isnan(share) or share < MIN_GIVEN_SHARE else f"{shown} ({_percent(share)})"


@view(lambda values, _, __: figures.plot_drifts(values[0]), lambda value, _: value.rows(), first=first_of_drift)
def drift_view(value: Drift, _: float) -> Face:
    """Each quantity with its causes, and what the requirements allow."""
    parts: list[Part] = [Note(alert, "alert") for alert in value.alerts]
    for need in value.settings.requirements:
        told, table = _required(value, need)
        parts += [Note(str(told), "strong"), table]  # type: ignore[list-item]
    parts += [Note(shown, "remark") for remark in _remarks(value) if not remark.grave for shown in remark.clauses]
    if value.axes:
        parts.append(Drawing(lambda: figures.plot_drifts(value), say("drift by time"), CAPTION))
    sheets = [Sheet(name, (), tuple(_parts(value, name, course))) for name, course in _alike(value)]
    return Face(
        _title(value), BRAND, sheets, header_of(value.provenance, _said(value)), parts=parts,
        close=[Note(HOW, "quiet", where="text"), Note(INTERVALS, "quiet", where="text")],
        how=[Note(HOW), Note(INTERVALS)], provenance=value.provenance, notes=_said(value),
    )  # fmt: skip
