"""How a compensation is shown: what it does in sentences, coefficients, and deviations before and after."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from allanite.applications.compensation.compensating import Compensated, CompensationStudy
from allanite.applications.compensation.mixture import Gain
from allanite.applications.compensation.regression import Regression
from allanite.applications.compensation.regressor import Effect
from allanite.core.units import unit_of
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits, printable, printed_number
from allanite.reporting.first import Channels, First, Remark, condensed, merged, plus_minus
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Plot, Sheet, Table, known

from . import view
from .jobs import channel_sheet, job_face, source_of


def verdict(channel: Compensated, shown: Callable[[str], str] = str) -> str:
    """What the regression does, in one or two sentences; `shown` prints a number."""
    name = printable(channel.record.name) or say("the channel")
    if channel.regression is None:
        return say("{channel} gives no result: {reason}.", channel=name, reason=channel.refusal)
    if channel.gain is None:
        return found(name, channel.regression, shown)
    gain = channel.gain
    share = shown(words.percent(abs(gain.explained), 3))
    if gain.explained < 0:
        effect = say("The correction increases the variance of {channel} by {share}", channel=name, share=share)
    else:
        effect = say("The correction reduces the variance of {channel} by {share}", channel=name, share=share)
    if gain.low is None or gain.high is None:
        return join("", (effect, "."))
    expected = _share(gain.expected, gain)
    limits = shown(f"{expected} ({_share(gain.low, gain)} .. {_share(gain.high, gain)})")
    if gain.met:
        return say("{effect}; {limits} could be expected.", effect=effect, limits=limits)
    return say("{effect}; {limits} could be expected, and it does not: the dependence is another one here.",
               effect=effect, limits=limits)  # fmt: skip


def found(name: str, regression: Regression, shown: Callable[[str], str] = str) -> str:
    """Whether there is a dependence, and what the correction does to the fitted record."""
    own = [e for e in regression if e.taken_off]
    undecided = []
    if regression.ambiguous:  # the regressors and a linear drift explain the record alike
        undecided.append(say("the effect of {regressors} can hardly be separated from a rate ramp R in this record: "
                             "the two share {share} of their variance, and either alone fits about as well. Record "
                             "until {regressors} returns to its initial value.", regressors=_names(own),
                             share=words.percent(regression.shared)))  # fmt: skip
    if not regression.significant and undecided:
        return join(": ", (name, *undecided))
    if not regression.significant:
        return say("{channel} shows no dependence on {regressors}: the correction would only remove noise.",
                   channel=name, regressors=_names(own))  # fmt: skip
    gain, held = regression.inside, regression.held
    also = [say("about a linear drift")] if regression.trend else []
    # by chance the sum of squares falls a little even where nothing is found
    also += [say("{share} expected by chance", share=shown(_share(gain.expected, gain)))]
    if held is not None:
        also.append(say("{share} in cross-validation", share=shown(f"{100 * held.explained:.3g} %")))
    sentences = [say("{channel} depends on {regressors}. The correction reduces the variance by {share} ({also}).",
                     channel=name, regressors=_names([e for e in own if e.significant]),
                     share=shown(f"{100 * gain.explained:.3g} %"), also=join("; ", also)), *undecided]  # fmt: skip
    rest = _names([e for e in own if not (e.chosen or e.significant)])
    sentences += [say("Leave out {regressors}: no dependence on it is shown.", regressors=rest)] if rest else []
    if not regression.harmless:
        sentences.append(say("In cross-validation it does harm: do not use it."))
    return join(" ", sentences)


def _names(effects: Sequence[Effect]) -> str:
    return join(", ", [e.label for e in effects])


def _share(part: float, gain: Gain) -> str:
    # two digits, of which "g" writes 100 as 1e+02
    return f"{float(f'{100 * part / gain.before:.2g}'):g} %"


BRAND = say("compensation by regressors")
KEY = say("Found: if there were no dependence, a coefficient as far from zero would have a probability (p) below 5 %; "
          "for a column that cross-validation chose, p is multiplied by the number of columns it was chosen from. VIF: "
          "variance inflation factor, by which the other regressors widen the variance.")  # fmt: skip
HOW = (
    say(
        "The rate is modeled as a constant, a sum of coefficients times regressors (each minus its mean), and noise. "
        "The noise is identified from the same record by the restricted likelihood of its cosine transform, in which "
        "the coefficients are integrated out. The coefficients are generalized least squares estimates, averaged over "
        "what bias instability and rate random walk may be. Ordinary least squares would report an effect where there "
        "is none in half of all records or more."
    ),
    say(
        "Named regressors are always kept. Powers are included only if the cross-validated gain exceeds its standard "
        "error. The correction is zero at the means of the regressors: the bias stays. A linear "
        "drift is estimated together with the coefficients, unless it is left out, and not removed; the variances "
        "before and after are then those about a straight line."
    ),
    say(
        "Noise in a regressor makes its coefficient too small, by the share of noise in its variance. The "
        "deviations before and after come from the same samples: overlapping bands do not show that they agree."
    ),
)
HEADINGS = ("channel", "of", "tau_s", "m", "before", "before_low", "before_high", "after", "after_low", "after_high",
    "unit", "before_edf", "after_edf")  # fmt: skip


def coefficients(regression: Regression, level: float) -> Table:
    """Every coefficient of a regression."""
    heads = (Column(say("regressor"), "name"), Column(say("sensitivity")), Column(words.interval(level), "interval"),
             Column(say("unit"), "unit"), Column(say("status"), "text"), Column(say("std. error"), aside=True),
             Column("t", aside=True, form="+.1f"), Column("p", aside=True, form=lambda p: words.probability(p, 1e-4)),
             Column(say("VIF"), aside=True, form=".3g"))  # fmt: skip
    effects = [regression.effect(i, level) for i in range(len(regression.regressors))]
    rows, scale = [], 1 / unit_of(regression.signal.sheet[0]).factor
    for e in effects:
        unit, per = regression.signal.sheet[0], e.regressor.column_unit
        if per != "1":
            unit = say("{unit} per {regressor}", unit=unit, regressor=per)
        status = [say("identified") if e.significant else say("absent"), *([say("chosen")] if e.chosen else [])]
        size = digits(e.value * scale, e.low * scale, e.high * scale, signed=True).plain()
        error = digits(e.standard_error * scale, figures=2).plain()[0]
        rows.append([e.label, *size, unit, join(", ", status), error, e.t, e.p, e.inflation])
    drift = [say("The drift over time is not removed.")] if regression.trend else []
    key = join(" ", (KEY, *drift, _beside(regression)))
    return Table(heads, rows, marks=["strong" if e.significant else "quiet" for e in effects], key=key)


def _beside(regression: Regression) -> str:
    """The noise of a regression."""
    return say("Noise, identified with the coefficients: {model}; {effective:.4g} effective samples; scaled condition "
               "number {condition:.3g}.", model=str(regression.noise), effective=regression.effective,
               condition=regression.condition)  # fmt: skip


def _sheet(channel: Compensated, level: float, source: str = "") -> Sheet:
    sentence = verdict(channel, printed_number)
    sentence = join(": ", (source, sentence)) if source else sentence
    regression, gain = channel.regression, channel.gain
    useful = regression is not None and regression.useful
    doubt = not useful if gain is None else gain.met is False or gain.explained < 0
    of = say("noise before the correction")
    sheet = channel_sheet(channel, _parts(channel, level), (sentence,), "alert" if doubt else "", of)
    if not source:
        return sheet
    name = channel.record.name or say("channel")
    return replace(sheet, name=say("{channel} of {source}", channel=name, source=source))


def _parts(channel: Compensated, level: float) -> Iterator[Part]:
    regression = channel.regression
    if regression is None:
        return
    yield Note(verdict(channel), "strong", where="text")
    if channel.gain is None:
        yield from _regression_parts(regression, level)
    caption = say("Overlapping Allan deviation before and after with {level} bands, and the rate over time less its "
                  "bias: what was recorded, what the regressors explain, what is left.",
                  level=words.percent(level))  # fmt: skip
    yield Drawing(lambda: _draw([channel], level), say("deviation and rate before and after"), caption)
    # the deviations before and after, with their limits
    rows = []
    for _, _, tau, _, *numbers, _, _, edf in _lines(channel, "", level):
        before, after = numbers[:3], numbers[3:]
        ratio = after[0] / before[0] if before[0] > 0 else math.nan
        rows.append([tau, *digits(*before).plain(), *digits(*after).plain(), ratio, edf])
    heads = (
        Column("tau [s]", form=".6g"), Column(say("before")), Column(say("limits before"), "interval", aside=True),
        Column(say("after")), Column(say("limits after"), "interval", aside=True),
        Column(say("after / before"), form=known(".3f")), Column(say("edf after"), form=known(".3g")),
    )  # fmt: skip
    title = say("overlapping Allan deviation in {unit}, with {level} limits", unit=channel.record.signal.sheet[0],
                level=words.percent(level))  # fmt: skip
    yield Table(heads, rows, title, details=True)


def _regression_parts(regression: Regression, level: float) -> Iterator[Part]:
    yield from (Note(note, "alert") for note in regression.notes)
    yield Note(_beside(regression), where="text")
    yield coefficients(regression, level)


def first_of_study(study: CompensationStudy, level: float) -> First:
    """The sensitivities of each sensor side by side."""
    first = condensed(study_view.face(study, level), drawn=True)
    shown = [c for c in study.channels if c.regression is not None]
    if len(shown) < 2 or study.applied:
        return first
    sensors = dict.fromkeys(c.record.signal.name for c in shown)
    told = [c for c in shown if c.regression
        and (c.regression.ambiguous or (c.regression.significant and not c.regression.harmless))]  # fmt: skip
    doubted = [Remark.of("", verdict(c), grave=True) for c in told]
    own = [(c.record.name, alert) for c in shown if c.regression for alert in (*c.regression.notes, *c.alerts)]
    about = merged(Remark.of(name, alert, grave=True) for name, alert in own)
    others = [remark for remark in first.remarks if remark.clauses[0] not in [alert for _, alert in own]]
    axes = []
    for own_kind in ([c for c in shown if c.record.signal.name == sensor] for sensor in sensors):
        effects = [(c.record.name, *cell) for c in own_kind if c.regression for cell in _effects(c.regression, level)]
        axes.append(Channels.of([c.record.name for c in own_kind], effects, own_kind[0].record.signal.sensor))
    return replace(first, answer=axes, remarks=[*others, *doubted, *about])


def _effects(regression: Regression, level: float) -> Iterator[tuple[str, str, str]]:
    unit = regression.signal.sheet[0]
    scale = 1 / unit_of(unit).factor
    share = f"{100 * regression.inside.explained:.3g} %" if regression.significant else say("no effect")
    yield say("variance removed"), "", share
    for e in (regression.effect(i, level) for i in regression.taken):
        size = plus_minus(e.value * scale, e.low * scale, e.high * scale, signed=True)
        yield e.label, f"{unit}/{e.regressor.column_unit}".removesuffix("/1"), size if e.significant else say("absent")


def _draw(channels: Sequence[Compensated], level: float) -> Plot:
    return figures.plot_compensated([c for c in channels if c.regression is not None], level)


def _lines(channel: Compensated, of: str, level: float) -> Iterator[list[Any]]:
    if channel.before is None or channel.after is None:
        return
    unit = channel.record.signal.sheet[0]
    before, after = channel.before.to(unit), channel.after.to(unit)
    numbers = [v for c in (before, after) for v in (c.deviation, *c.interval(level))]
    for i, tau in enumerate(before.tau.tolist()):
        values = [float(v[i]) for v in numbers]
        yield [channel.record.name, of, tau, int(before.m[i]), *values, unit, float(before.edf[i]), float(after.edf[i])]


@view(
    lambda values, fit, level: _draw(
        [c for study in values for c in study.applied if c.regression is not None]
        or [c for study in values for c in study.channels],
        level,
    ),
    # overlapping Allan deviations in data-sheet units
    lambda study, level: (
        HEADINGS,
        [
            row
            for channels, of in ((study.channels, "fitted"), (study.applied, "applied"))
            for channel in channels
            for row in _lines(channel, of, level)
        ],
    ),
    first=first_of_study,
)
def study_view(study: CompensationStudy, level: float) -> Face:
    """The channels of a file, and of one that the correction was applied to."""
    return job_face(
        study, (say("Compensation of {source}", source=source_of(study)), BRAND),
        [
            *(_sheet(channel, level) for channel in study.channels),
            *(_sheet(channel, level, study.provenance.get("applied to", "")) for channel in study.applied),
        ],
        how=[*map(Note, HOW)],
    )  # fmt: skip


@view(lambda values, fit, level: _draw(values, level))
def channel_view(channel: Compensated, level: float) -> Face:
    """One channel."""
    return Face(channel.record.name or say("channel"), BRAND, (_sheet(channel, level),))


@view()
def regression_view(regression: Regression, level: float) -> Face:
    """The coefficients of a regression."""
    return Face(
        say("Regression of {channel}", channel=regression.name), BRAND,
        (Sheet(regression.name, parts=tuple(_regression_parts(regression, level))),),
        parts=[Note(found(printable(regression.name) or say("the channel"), regression), "strong")],
    )  # fmt: skip
