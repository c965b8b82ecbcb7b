"""How gyro-verticals are shown: time constant, predicted error by source, roll and pitch, filters in scenarios."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from allanite.applications.attitude.filters import FILTERS
from allanite.applications.attitude.loop import Loop
from allanite.applications.attitude.optimum import Optimum
from allanite.applications.attitude.prediction import texts
from allanite.applications.attitude.result import Angle, VerticalStudy
from allanite.applications.attitude.scenarios import ScenarioErrors, VerticalDesign
from allanite.core.record import Record
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.sheet import Code, Column, Drawing, Face, Mark, Note, Part, Sheet, Table, header_of, one_sheet
from allanite.reporting.words import ARCSEC
from allanite.study.job import provenance_of

from . import Rows, view
from .jobs import channel_sheet, job_face, source_of

BRAND = say("roll and pitch from gyros and accelerometers")
KEY = say(
    "RMS angle error by source; the squares add. Share: of the square of the whole error of the filter of first order."
)
DETUNED = say("Error of the filter of first order with a wrong time constant.")
DRAWN = say(
    "Above: gain from the integrated gyro and from the accelerometer's tilt to the angle. Middle: density of the error "
    "by source, of the recommended filter. Below: error against the time constant."
)
ANGLES = say("Roll and pitch: mean, least and largest of short blocks; dashed: predicted limits about the mean.")
SCENARIOS_KEY = say(
    "RMS error of roll and pitch after the first fifth of the run, deg; in brackets the largest. Norm gate: ignores "
    "the accelerometers where the specific force differs from g in size; angle gate: where their tilt differs from the "
    "angle."
)


def _optimum_parts(found: Optimum, name: str = "") -> Iterator[Part]:
    first, second = found.first, found.second
    yield Note(say("time constant {tau:.4g} s: RMS error {error:.3g} arcsec, with a filter of first order",
                   tau=found.time_constant, error=first.to("arcsec")), "strong")  # fmt: skip
    if second is not None:
        loop = second.loop
        gains = {"k1": loop.k1, "k2": loop.k2, "error": second.to("arcsec"), "gain": 100 * (1 - second.rms / first.rms)}
        if found.order == 2:
            yield Note(say("use the filter of second order: k1 = {k1:.4g} 1/s, k2 = {k2:.4g} 1/s^2, RMS error "
                           "{error:.3g} arcsec, {gain:.2g} % less", **gains))  # fmt: skip
        else:
            yield Note(say("a filter of second order, k1 = {k1:.4g} 1/s, k2 = {k2:.4g} 1/s^2, has {error:.3g} arcsec, "
                           "only {gain:.2g} % less", **gains))  # fmt: skip
    else:
        yield Note(say("a filter of second order is not better"))
    yield Note(say("the optimal causal (Wiener) filter has {bound:.3g} arcsec; the noise of the filter of first order "
                   "is {loss} larger", bound=found.bound / ARCSEC,
                   loss=words.percent(found.loss, 2) or "0 %"))  # fmt: skip
    if first.floor:
        yield Note(say("floor: {floor:.3g} arcsec from flicker and bias of the accelerometer, which no time constant "
                       "removes", floor=first.floor / ARCSEC))  # fmt: skip
    yield _sources(found)
    heads = (Column(say("factor"), form="g"), Column(say("time constant [s]"), form=".4g"),
             Column(say("RMS error [arcsec]"), form=".4g"), Column(say("over the least"), form=".3f"))  # fmt: skip
    rows = [[k, k * found.time_constant, rms / ARCSEC, rms / first.rms] for k, rms in found.detuning]
    yield Table(heads, rows, say("detuning"), key=DETUNED)
    yield Drawing(lambda: figures.plot_optima([(name, found)]), say("filter and errors"), DRAWN)


def _sources(found: Optimum) -> Table:
    first, second = found.first, found.second or found.first
    heads = (
        Column(say("source"), "name"), Column(say("term"), "text"), Column(say("first order [arcsec]"), form=".3g"),
        Column(say("share"), form=lambda share: words.percent(share, 2)),
        Column(say("second order [arcsec]"), form=".3g"),
    )  # fmt: skip
    known = {(source.sensor, source.text): source.rms / ARCSEC for source in second.sources}
    rows: list[list[Any]] = [
        [say("gyro") if s.sensor == "gyro" else say("accelerometer"), join("", [s.text]), s.rms / ARCSEC,
         s.rms**2 / first.rms**2, known.get((s.sensor, s.text), 0.0)]
        for s in first.sources
    ]  # fmt: skip
    rows.append([say("all"), "", f"{first.rms / ARCSEC:.4g}", "100 %", f"{second.rms / ARCSEC:.4g}"])
    marks: list[Mark] = ["strong" if row is rows[-1] else "" for row in rows]
    table = Table(heads, rows, say("error by source"), marks=marks, key=KEY)
    return table.only(range(4)) if found.second is None else table


def _matrices(loop: Loop, rate: float) -> Code:
    """The filter as a program needs it, to the last digit."""
    h = 1 / rate
    alpha = math.exp(-loop.k1 * h)
    if loop.order == 1:
        lines = [f"Phi = [[1.0]]; B = [[{h!r}]]; H = [[1.0]]", f"K = [[{-math.expm1(-loop.k1 * h)!r}]]"]
        state = say("x = [angle]")
    else:
        lines = [f"Phi = [[1.0, {-h!r}], [0.0, 1.0]]; B = [[{h!r}], [0.0]]; H = [[1.0, 0.0]]",
                 f"K = [[{-math.expm1(-loop.k1 * h)!r}], [{-loop.k2 * h!r}]]"]  # fmt: skip
        state = say("x = [angle, gyro bias]")
    lines.append(f"alpha = {alpha!r}; dt = {h!r}")
    return Code("\n".join(lines), say("filter at {rate:g} Hz, SI: {state}, x = Phi x + B omega, x = x + K (tilt - H x)",
                                      rate=rate, state=state))  # fmt: skip


def _scenario_parts(found: ScenarioErrors) -> Iterator[Part]:
    each = zip(found.scenarios, found.winners, np.degrees(found.rms.min(axis=0)).tolist(), strict=True)
    best = [say("{scenario}: {filter} ({error:.3g} deg)", scenario=s, filter=w, error=e) for s, w, e in each]
    same = len(set(found.winners)) == 1
    head = say("one filter is the best in all scenarios") if same else say("no filter is the best in all scenarios")
    yield Note(head, "strong", points=best)
    named = dict(zip(found.filters, found.rms, strict=True))
    plain, gated = named.get("first order, 100 s"), named.get("100 s, norm gate 0.02 g")
    if plain is not None and gated is not None:
        yield Note(say("a gate on the size of the specific force does not see 1 m/s^2, which makes it only 0.52 % "
                       "larger: {gated:.4g} deg with the gate, {plain:.4g} deg without",
                       gated=math.degrees(gated[1]), plain=math.degrees(plain[1])))  # fmt: skip
    labels = ("first order, 10 s", "10 s, angle gate 1 deg", "10 s, angle gate 2 deg")
    if all(label in named for label in labels):
        free, narrow, wide = (np.degrees(named[label]).tolist() for label in labels)
        yield Note(say("with a gate of 1 deg on the angle the error is {narrow[1]:.2g} deg under acceleration "
                       "({free[1]:.3g} without), but {narrow[2]:.2g} in oscillation ({free[2]:.2g} without), whose "
                       "acceleration tilts the accelerometers by 1.6 deg; with a gate of 2 deg it is {wide[1]:.2g} and "
                       "{wide[2]:.2g} deg", free=free, narrow=narrow, wide=wide))  # fmt: skip
    heads = [Column(say("filter"), "name"), *(Column(join(" ", (s, "[deg]"))) for s in found.scenarios)]
    cells = [[name, *(f"{r:.3g} ({w:.2g})" for r, w in zip(np.degrees(rms), np.degrees(worst), strict=True))]
        for name, rms, worst in zip(found.filters, found.rms, found.worst, strict=True)]  # fmt: skip
    yield Table(heads, cells, say("filters in the scenarios"), key=SCENARIOS_KEY)
    yield Drawing(lambda: figures.plot_scenarios(found), say("filters in the scenarios"), SCENARIOS_KEY)


METHODS = Table(
    (Column(say("filter"), "symbol"), Column(say("what it is"), "text"), Column(say("formula"), "formula"),
     Column(say("source"), "text")),
    [[f.name, f.title, f.formula, f.reference] for f in FILTERS.values()], where="page",
)  # fmt: skip


def _angle_parts(angle: Angle) -> Iterator[Part]:
    yield Note(say("mean {mean:.4f} deg, standard deviation {deviation:.3g} arcsec", mean=math.degrees(angle.mean),
                   deviation=angle.deviation / ARCSEC))  # fmt: skip
    p = angle.prediction
    if p is not None:
        yield Note(say("predicted: {error:.3g} arcsec (1 sigma), {limit:.2g} deg (2 sigma)",
                       error=p.to("arcsec"), limit=2 * p.to("deg")), "strong")  # fmt: skip
        # a measured scatter that the prediction does not explain
        if isinstance(angle.record, Record) and angle.deviation >= MIN_SCATTER_RATIO * p.rms:
            yield Note(say("the angle scatters {ratio:.2g} times as much as predicted: the body moved, or noise is "
                           "missing from the models (see the channels)", ratio=angle.deviation / p.rms),
                       "warning")  # fmt: skip
    elif angle.optimum is None and not angle.doubts:
        yield Note(say("no prediction: the noise of its sensors is not known"), "alert")
    else:
        yield Note(say("no prediction: the filter is not linear"))
    yield from (Note(doubt, "alert") for doubt in angle.doubts)
    if angle.optimum is not None:
        yield Note(say("the best filters for this angle alone:"))
        yield from _optimum_parts(angle.optimum, angle.name)


MAX_IGNORED_SHARE = 0.1  # share of the samples without accelerometers from which a gate may do more harm than good
MIN_SCATTER_RATIO = 1.5  # ratio of measured and predicted scatter from which it is mentioned


def _scenario_rows(found: ScenarioErrors) -> Rows:
    heads = ["filter", *(f"{s} {what}" for s in found.scenarios for what in ("rms", "worst"))]
    pairs = np.degrees(np.stack([found.rms, found.worst], axis=2)).reshape(len(found.filters), -1)
    return heads, [[name, *row] for name, row in zip(found.filters, pairs.tolist(), strict=True)]


def _sample_rows(study: VerticalStudy, _: float) -> Rows:
    time = np.arange(1, study.roll.size + 1) / study.rate
    rows = np.column_stack([time, np.degrees(study.roll), np.degrees(study.pitch)]).tolist()
    return ["time", *(angle.name for angle in study.angles)], rows


@view(lambda values, fit, level: figures.plot_angles(values[0].angles), _sample_rows)
def study_view(study: VerticalStudy, _: float) -> Face:
    """Roll and pitch of a recording."""
    sheets = []
    for angle in study.angles:
        sensors = say("{first} and {last}", first=angle.gyro, last=angle.accelerometer)
        sheets.append(Sheet(angle.name, (sensors,), tuple(_angle_parts(angle))))
    for channel in study:
        known = [] if channel.model is None else [Note(say("noise: {model}", model=texts(channel.model)))]
        sheets.append(channel_sheet(channel, [*known, *map(Note, channel.left_out)]))
    row, loop = study.settings.row, study.loop
    how = say("{title}: time constant {tau:.4g} s{second}", title=row.title, tau=loop.time_constant,
              second=f", k2 = {loop.k2:.4g} 1/s^2" if loop.k2 else "")  # fmt: skip
    parts: list[Part] = [Note(how, "strong"), *map(Note, study.remarks)]
    if study.falling:
        parts.append(Note(say("{count} samples in free fall, during which the gyros alone were used",
                              count=study.falling), "warning"))  # fmt: skip
    if study.held > study.falling and row.name != "bortz":
        share = (study.held - study.falling) / study.roll.size
        held = say("the accelerometers were ignored in {share} of the samples", share=words.percent(share, 3))
        if share > MAX_IGNORED_SHARE:
            held = say("{held}: the gate is below the tilt of this motion", held=held)
        parts.append(Note(held, "alert" if share > MAX_IGNORED_SHARE else "note"))
    parts.append(Drawing(lambda: figures.plot_angles(study.angles), say("roll and pitch"), ANGLES))
    names = say("Roll and pitch of {source}", source=source_of(study)), BRAND
    return job_face(study, names, sheets, parts, close=[_matrices(study.loop, study.rate)], how=[METHODS])


@view(
    lambda values, fit, level: figures.plot_optima([("", v.optimum) for v in values]),
    lambda found, _: found.optimum.rows() if found.scenarios is None else _scenario_rows(found.scenarios),
)
def design_view(found: VerticalDesign, _: float) -> Face:
    """The best filter for two sensors, and filters in scenarios."""
    first = found.optimum.first
    horizon = say("no horizon") if first.duration is None else say("over {time}", time=words.duration(first.duration))
    sampled = say("continuous time") if first.rate is None else say("{rate:g} Hz", rate=first.rate)
    parts = list(_optimum_parts(found.optimum))
    if first.rate is not None:
        parts.append(_matrices(found.optimum.best.loop, first.rate))
    sheets = [Sheet(say("filter"), (horizon, sampled), parts)]
    if found.scenarios is not None:
        trial = found.scenarios.trial
        about = say("simulated: {duration:g} s at {rate:g} Hz", duration=trial.duration, rate=trial.rate)
        sheets.append(Sheet(say("scenarios"), (about,), tuple(_scenario_parts(found.scenarios))))
    noise = [say("gyro: {noise}", noise=first.gyro), say("accelerometer: {noise}", noise=texts(first.accelerometer))]
    header = [(say("noise"), noise[0]), ("", noise[1]), *header_of(provenance_of(), ())[1:]]
    return Face(say("Gyro-vertical"), BRAND, sheets, header, how=[METHODS], provenance=provenance_of())


OPTIMUM = design_view.through(VerticalDesign)


@view(lambda values, fit, level: figures.plot_scenarios(values[0]), lambda found, level: _scenario_rows(found))
def scenarios_view(found: ScenarioErrors, level: float) -> Face:
    """Filters in scenarios."""
    return one_sheet(say("Filters in scenarios"), BRAND, "", _scenario_parts(found))
