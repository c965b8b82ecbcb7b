"""What a regression does, in sentences."""

from collections.abc import Callable, Sequence

from allanite.applications.compensation.compensated import Compensated
from allanite.applications.compensation.gain import Gain
from allanite.applications.compensation.regression import Regression
from allanite.applications.compensation.regressor import Effect
from allanite.phrases.phrase import join, say
from allanite.reporting import words
from allanite.reporting.digits import printable


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
        said = say("The correction increases the variance of {channel} by {share}", channel=name, share=share)
    else:
        said = say("The correction reduces the variance of {channel} by {share}", channel=name, share=share)
    if gain.low is None or gain.high is None:
        return join("", (said, "."))
    expected = _share(gain.expected, gain)
    limits = shown(f"{expected} ({_share(gain.low, gain)} .. {_share(gain.high, gain)})")
    if gain.met:
        return say("{effect}; {limits} could be expected.", effect=said, limits=limits)
    return say(
        "{effect}; {limits} could be expected, and it does not: the dependence is another one here.",
        effect=said,
        limits=limits,
    )


def found(name: str, regression: Regression, shown: Callable[[str], str] = str) -> str:
    """Whether there is a dependence, and what the correction does to the fitted record."""
    own = [e for e in regression if e.taken_off]
    undecided = []
    if regression.ambiguous:  # the regressors and a linear drift explain the record alike
        undecided.append(
            say(
                "the effect of {regressors} can hardly be separated from a rate ramp R in this record: the two share "
                "{share} of their variance, and either alone fits about as well. Record until {regressors} returns to "
                "its initial value.",
                regressors=_names(own),
                share=words.percent(regression.shared),
            )
        )
    if not regression.significant and undecided:
        return join(": ", (name, *undecided))
    if not regression.significant:
        return say(
            "{channel} shows no dependence on {regressors}: the correction would only remove noise.",
            channel=name,
            regressors=_names(own),
        )
    gain, held = regression.inside, regression.held
    also = [say("about a linear drift")] if regression.trend else []
    # by chance the sum of squares falls a little even where nothing is found
    also += [say("{share} expected by chance", share=shown(_share(gain.expected, gain)))]
    if held is not None:
        also.append(say("{share} in cross-validation", share=shown(f"{100 * held.explained:.3g} %")))
    said = [
        say(
            "{channel} depends on {regressors}. The correction reduces the variance by {share} ({also}).",
            channel=name,
            regressors=_names([e for e in own if e.significant]),
            share=shown(f"{100 * gain.explained:.3g} %"),
            also=join("; ", also),
        ),
        *undecided,
    ]
    rest = _names([e for e in own if not (e.chosen or e.significant)])
    said += [say("Leave out {regressors}: no dependence on it is shown.", regressors=rest)] if rest else []
    if not regression.harmless:
        said.append(say("In cross-validation it does harm: do not use it."))
    return join(" ", said)


def _names(effects: Sequence[Effect]) -> str:
    return join(", ", [e.label for e in effects])


def _share(part: float, gain: Gain) -> str:
    # two digits, of which "g" writes 100 as 1e+02
    return f"{float(f'{100 * part / gain.before:.2g}'):g} %"
