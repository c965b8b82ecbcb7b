"""The first screen of an analysis: coefficients by channel, and what limits them."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from allanite.core.estimate import Estimate
from allanite.core.fit import MIN_P as LEAST
from allanite.core.kinds import KIND_WORDS
from allanite.core.model import coefficient_factor
from allanite.core.plain import Header
from allanite.core.readings import FALLING_SIGN, IN_RUN
from allanite.core.record import Record
from allanite.core.units import SIGNALS
from allanite.core.validity import APPROXIMATE, ROUGHLY, UNEXPLAINED
from allanite.interpretation.devices import DEVICES
from allanite.phrases.phrase import Phrase, join, say, say_count
from allanite.reporting import words
from allanite.reporting.digits import digits, rounded
from allanite.reporting.first import FIGURES, PLUS_MINUS, Answer, ChannelRow, Channels, First, plus_minus
from allanite.study.job import Job
from allanite.study.results import Channel, Noise, Study
from allanite.terms import TERMS

from .jobs import LEVELS, alerts, doubts, mean_and_spread, reservations, source_of, weighed, without_repeats

MAIN = ("N", "B", "K")  # terms whose limits are told as long as there is room for any

IN_RUN_SHORT = say("in-run")

MEANING = ("--details", say("intervals, densities, meaning"))
LONGER = ("allanite plan FILE", say("how long to record"))
EXPORT = ("allanite export FILE --to TARGET", say("file of a filter"))


def first_of(study: Study, level: float) -> First:
    """The first screen of a study: its coefficients, or whether its channels are fit for analysis."""
    channels = study.channels
    fitted = [channel for channel in channels if channel.fit is not None]
    if not fitted:
        return _seen(study)
    lost = any(e.status == "absent" and e.symbol in MAIN for channel in fitted for e in channel.fit or ())
    answer: list[Answer] = [
        *(Channels(names_of(alike), list(_quantities(alike, level)), alike[0].record.signal.sensor)
          for alike in by_sensor(channels)),
    ]  # fmt: skip
    signals = [channel.record.signal for channel in fitted]
    inertial = any(signal.inertial for signal in signals)
    # what motion adds to a curve is not noise
    if all(s in signals for s in SIGNALS if s.inertial) and all(c.explained or not c.quality.moved for c in channels):
        from .export import filter_line

        answer += filter_line(study)
    device, meaning = study.recipe.device, MEANING[1]
    if device is not None:
        meaning = say("intervals, densities, meaning, causes in a {device}", device=DEVICES[device].title)
    return First(
        title_of(study), _verdict(channels), answer,
        without_repeats(doubts(channels), [*reservations(channels), *weighed(alerts(study))]),
        list(_legend(level).items()), how_read(study),
        [FIGURES, (MEANING[0], meaning), *([EXPORT] if inertial else []), *([LONGER] if lost else [])],
    )  # fmt: skip


def title_of(study: Job[Any]) -> Phrase:
    """The file and what it holds: ``imu.csv   3 gyroscopes, 100 Hz, 1 h``."""
    records = [channel.record for channel in study.channels if channel.record is not None]
    return join("   ", (source_of(study), join(", ", _contents(records))))


def _contents(records: Sequence[Record | Header]) -> Iterator[str]:
    sensors = Counter(record.signal.sensor for record in records)
    yield from (say("{count} × {sensor}", count=n, sensor=sensor) if n > 1 else sensor for sensor, n in sensors.items())
    same = {(f"{r.rate:.6g} Hz", words.duration(r.duration)) for r in records}
    yield from next(iter(same)) if len(same) == 1 else ()


def how_read(study: Job[Any]) -> list[str]:
    """How the file was read, the assumptions first that numbers depend on."""
    records = (channel.record for channel in study.channels)
    kinds = dict.fromkeys(say("{kind} in {unit}", kind=KIND_WORDS[r.kind], unit=r.unit) for r in records)
    digest = study.provenance.get("sha256", "")
    first = say("read as {kinds}", kinds=join(", ", kinds))
    return [first, *study.notes[:1], *([f"sha256 {digest[:8]}…"] if digest else []), *study.notes[1:]]


def _verdict(channels: Sequence[Channel]) -> Phrase:
    """Of how many channels the model fits: wholly, and in part."""
    fits = [channel.noise for channel in channels if channel.noise is not None and channel.explained]
    part = sum(any(_part(n)) or any(e.status == "not valid" for e in n.fit) for n in fits)
    good, every = len(fits) - part, len(channels)
    if fits and not any(fit.validity for fit in fits):
        return say("model not tested")
    if good == every:
        return say_count(good, "model fits", "model fits all {count} channels")
    partial = say("model fits {good} of {count} channels", good=good, count=every)
    return say("{said}, {part} in part", said=partial, part=part) if part else partial


def by_sensor(channels: Iterable[Any]) -> list[list[Any]]:
    """The channels of each kind of sensor."""
    alike: dict[str, list[Any]] = {}
    for channel in channels:
        alike.setdefault(channel.record.signal.name, []).append(channel)
    return list(alike.values())


def names_of(channels: Iterable[Any]) -> list[str]:
    """What the channels are called."""
    return [channel.record.name or say("channel") for channel in channels]


def _quantities(channels: Sequence[Channel], level: float) -> Iterator[ChannelRow]:
    """The coefficients of channels of one kind of sensor, with the minimum of their curves and how well models fit."""
    signal = channels[0].record.signal
    fits = [{e.symbol: e for e in channel.fit or ()} if channel.explained else {} for channel in channels]
    for symbol in names_in_order(symbol for fit in fits for symbol in fit):
        estimates = [fit[symbol] for fit in fits if symbol in fit]
        cells = [cell_of(fit[symbol], level) if symbol in fit else "" for fit in fits]
        rank = 0 if any(e.valued for e in estimates) else 1 if symbol in MAIN else 2
        if any(cells):
            marks = [fit[symbol].status.replace(" ", "-") if symbol in fit else "" for fit in fits]
            unit = estimates[0].sheet_unit
            yield ChannelRow(words.title(symbol, signal), symbol, unit, cells, rank, marks=marks)
            yield from _shapes(symbol, [fit.get(symbol) for fit in fits], level)
    unit = next((c.readings.shown_unit(0) for c in channels if c.readings is not None), signal.sheet[0])
    least = [lowest_cell(channel, level) for channel in channels]
    if any(least):
        narrow = [re.sub(r" \(.*\)", "", cell) for cell in least]  # without intervals
        yield ChannelRow(IN_RUN, "", unit, least, short=IN_RUN_SHORT, narrow=narrow)
    words_of = [fit_words(channel.noise, channel.refusal) for channel in channels]
    grades = ["alert" if c.refusal else LEVELS.get(c.noise.validity, "") if c.noise else "" for c in channels]
    yield ChannelRow(say("model fit"), "", "", words_of, short=say("model"), marks=grades)


def _shapes(symbol: str, estimates: Sequence[Estimate | None], level: float) -> Iterator[ChannelRow]:
    """The parameters of a term beside its values: a time constant, or a frequency and a damping ratio."""
    sizes = [[size for _, *size in e.shaped(level)] if e is not None and e.valued else [] for e in estimates]
    for i, row in enumerate(TERMS[symbol].parameters):
        cells = [digits(*size[i]).words() if i < len(size) else "" for size in sizes]
        if any(cells):
            narrow = [cell.split(" (")[0] for cell in cells]
            yield ChannelRow(row.title, row.letter, row.unit, cells, narrow=narrow)


def names_in_order(symbols: Iterable[str]) -> list[str]:
    """Symbols of terms, each once: the main ones first."""
    met = set(symbols)
    return [symbol for symbol in (*MAIN, *(s for s in TERMS if s not in MAIN)) if symbol in met]


def cell_of(estimate: Estimate, level: float) -> str:
    """A coefficient with the half width of its interval, its limit, or why there is neither."""
    unit = estimate.sheet_unit
    if estimate.valued and estimate.value is not None:
        factor = coefficient_factor(estimate.symbol, unit, estimate.signal)
        low, high = (limit / factor for limit in estimate.interval(level))
        shown = plus_minus(estimate.value / factor, low, high, signed=words.signed(estimate))
        return say("{value}, weak", value=shown) if estimate.status == "weak" else shown
    most = estimate.rounded_limit(unit)
    if most is not None:
        sign = f"|{estimate.symbol}| " if words.symbol(estimate) != estimate.symbol or words.signed(estimate) else ""
        return f"{sign}< {most.plain()[0]}"
    return estimate.row.name if estimate.status != "absent" else ""


def lowest_cell(channel: Channel, level: float) -> str:
    """The minimum of the curve with its interval; empty where it shows that the body moved instead of the bias."""
    readings, moved = channel.readings, not channel.explained and channel.quality.moved
    if readings is None or moved or (lowest := readings.lowest(level)) is None:
        return ""
    return lowest.words() + f" {FALLING_SIGN}" * (not readings.inside)


def fit_words(noise: Noise | None, refusal: str = "") -> str:
    """How well a model explains a record, as the cell of a table."""
    if noise is None:
        return say("no result") if refusal else ""
    good, until, within = noise.fit.goodness, *_part(noise)
    if not noise.validity or good is None:
        return say("not tested")
    if noise.validity == UNEXPLAINED:
        return say("DOES NOT FIT")
    if within:
        return say("but for a part") if within > ROUGHLY else say("within {share:.2g} %", share=100 * within)
    if until is not None:
        return say("up to {time}", time=words.duration(until))
    return say("fits{mark}, p {p:.2g}", mark="*" * (noise.validity == APPROXIMATE), p=good.p)


def _part(noise: Noise) -> tuple[float | None, float]:
    """Up to which averaging time a model holds, None if to the longest; and its misfit."""
    scope = noise.fit.scope if noise.validity == APPROXIMATE else None
    return (scope.until, scope.within if scope.misfit else 0.0) if scope is not None else (None, 0.0)


def _legend(level: float) -> dict[str, str]:
    """What the signs of a table mean, by what finds them; see `First`."""
    return {
        PLUS_MINUS: say("±: {share} half width.", share=words.percent(level)), "<(?!=)": say("<: limit, not detected."),
        "[*][,，]": say("*: reservation."), FALLING_SIGN: say("↓: still falling."),
        "[,，] ?p ": say("p < {least:g}: no fit.", least=LEAST),
    }  # fmt: skip


def _seen(study: Study) -> First:
    """Mean and spread of each channel, and whether it can be analyzed."""
    tables, good = [], sum(not channel.refusal for channel in study.channels)
    for alike in by_sensor(study.channels):
        unit = alike[0].record.signal.sheet[0]
        spreads = [None if isinstance(c.record, Header) else mean_and_spread(c.record) for c in alike]
        rows = [
            ChannelRow(say("mean"), "", unit, ["" if f is None else rounded(f[0]) for f in spreads]),
            ChannelRow(say("standard deviation"), "", unit, ["" if f is None else rounded(f[1]) for f in spreads]),
            ChannelRow(say("fit for analysis"), "", "", [_fitness(channel) for channel in alike]),
        ]
        tables.append(Channels(names_of(alike), rows, alike[0].record.signal.sensor))
    count = len(study.channels)
    some = say("{good} of {count} channels are fit for analysis", good=good, count=count)
    verdict = say("fit for analysis") if good == count else some
    after = [
        ("allanite analyze FILE", say("the noise")), ("--plot raw.png", say("figure")),
        ("--details", say("all that was found")),
    ]  # fmt: skip
    return First(
        title_of(study), verdict, tables, [*doubts(study.channels), *alerts(study)], (), how_read(study), after
    )


def _fitness(channel: Channel) -> str:
    if channel.refusal:
        return say("no")
    return say("with caution") if channel.quality.warnings else say("yes")
