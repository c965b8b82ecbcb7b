"""The numbers of a regression as they are printed: data-sheet units per unit of the regressor."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from allanite.compensation import Effect, Gain, Regression
from allanite.compensation.study import Compensated
from allanite.core.curve import Curve
from allanite.core.units import unit_of
from allanite.reporting.digits import digits
from allanite.reporting.sheet import printable


class Line(NamedTuple):
    """A coefficient in print."""

    label: str
    value: str
    error: str
    interval: str
    unit: str
    t: str
    p: str
    inflation: str
    status: str


def lines(regression: Regression, level: float) -> Iterator[Line]:
    """Every coefficient."""
    unit = regression.signal.sheet[0]
    scale = 1 / unit_of(unit).factor
    for which in range(len(regression.regressors)):
        e = regression.effect(which, level)
        shown = digits(e.value * scale, e.low * scale, e.high * scale, signed=True)
        value, interval = shown.plain()
        per = "" if e.regressor.column_unit == "1" else f" per {e.regressor.column_unit}"
        yield Line(
            e.label, value, digits(e.standard_error * scale, figures=2).plain()[0], interval, f"{unit}{per}",
            f"{e.t:+.1f}", probability(e.p), f"{e.inflation:.3g}", status(e),
        )  # fmt: skip


def status(effect: Effect) -> str:
    """What is said of a coefficient."""
    words = ["found" if effect.significant else "not shown"]
    words += ["chosen"] if effect.chosen else []
    words += ["not taken off"] if effect.regressor.is_trend else []
    return ", ".join(words)


def probability(p: float) -> str:
    """A p value.

    Examples
    --------
    >>> probability(0.0213), probability(1e-9)
    ('0.021', '< 0.0001')
    """
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"


def percent_of(gain: Gain) -> str:
    """Share of the variance that a correction takes off."""
    return f"{100 * gain.explained:.3g} %"


def share(part: float, gain: Gain) -> str:
    """A mean square as a share of the variance before."""
    return f"{100 * part / gain.before:.2g} %"


def verdict(channel: Compensated) -> str:
    """What the regression does, in one or two sentences."""
    regression = channel.regression
    name = printable(channel.record.name) or "the channel"
    if regression is None:
        return f"{name} gives no result: {channel.refusal}."
    if channel.gain is not None:
        return _elsewhere(name, channel.gain)
    found = [e.label for e in regression if e.significant and not e.regressor.is_trend]
    gain = regression.inside
    # by chance the sum of squares falls a little even where nothing is found
    expected = f"{share(gain.expected, gain)} by chance alone"
    if not regression.significant:
        named = ", ".join(e.label for e in regression if not e.regressor.is_trend)
        return f"{name} shows no dependence on {named}: taking it off would be taking off noise."
    held, own = regression.held, [e for e in regression if not (e.chosen or e.regressor.is_trend)]
    rest = [e.label for e in own if not e.significant]
    words = (
        f"{name} depends on {', '.join(found)}. Taking it off takes {percent_of(gain)} off the variance ({expected})"
    )
    words += "." if held is None else f", and {percent_of(held)} off blocks held back, each about its own mean."
    words += f" Leave out {', '.join(rest)}: no dependence on it is shown." if rest else ""
    return words + (" On blocks held back it does harm: do not use it." if held and held.explained < 0 else "")


def _elsewhere(name: str, gain: Gain) -> str:
    promised = ""
    if gain.low is not None and gain.high is not None:
        low, high = (share(v, gain) for v in (gain.low, gain.high))
        promised = f"; {share(gain.expected, gain)} ({low} .. {high}) could be expected"
        promised += "" if gain.met else ", which it does not meet: the dependence is another one here"
    did = f"takes {percent_of(gain)} off" if gain.explained >= 0 else f"adds {100 * -gain.explained:.3g} % to"
    return f"The correction {did} the variance of {name}{promised}."


CURVES = ["tau, s", "before", "limits", "after", "limits", "after / before", "EDF"]


def curve_rows(channel: Compensated, level: float) -> tuple[str, list[list[str]]]:
    """Unit, and the deviations before and after with their limits."""
    unit = channel.record.signal.sheet[0]
    if channel.before is None or channel.after is None:
        return unit, []
    before, after = channel.before.to(unit), channel.after.to(unit)
    limited = [(curve.deviation, *curve.interval(level)) for curve in (before, after)]
    rows = []
    for i, tau in enumerate(before.tau):
        cells = [f"{tau:.6g}"]
        for numbers in limited:
            cells += digits(*(float(v[i]) for v in numbers)).plain()
        ratio = _ratio(before, after, i)
        edf = float(after.edf[i])
        rows.append(
            [*cells, f"{ratio:.3f}" if math.isfinite(ratio) else "", f"{edf:.3g}" if math.isfinite(edf) else ""]
        )
    return unit, rows


def _shown(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else ""


def _ratio(before: Curve, after: Curve, i: int) -> float:
    return float(after.deviation[i] / before.deviation[i]) if before.deviation[i] > 0 else math.nan
