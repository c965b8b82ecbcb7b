"""The noise of each axis: from the results of an analysis, from fits, or from given models."""

from collections.abc import Iterator, Mapping, Sequence
from functools import singledispatch
from typing import Any

from allanite.core.errors import UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term, model_of
from allanite.phrases.phrase import join
from allanite.study.results import Channel, Study

from .content import Axis

ALLAN = ("oadev", "adev")
"""Statistics that are Allan deviations."""

Source = Study | Channel | Fit | Model | Term | Mapping[str, Fit] | Sequence["Source"]
"""What can be exported; several are put together, for example a gyro's and an accelerometer's."""


@singledispatch
def axes_of(source: Any) -> Iterator[Axis]:
    """The axes of a source; refused channels are left out."""
    raise UsageError(
        f"a {type(source).__name__} holds no noise; give a Study, a Channel, a Fit, a Model, or a list of these"
    )


@axes_of.register
def _(source: Study) -> Iterator[Axis]:
    known = {key: value for key, value in source.provenance.items() if key in ("source", "sha256")}
    for channel in source.channels:
        yield from _of_channel(channel, source.recipe.level, known)


@axes_of.register
def _(source: Channel) -> Iterator[Axis]:
    return _of_channel(source, 0.95, {})


def _of_channel(channel: Channel, level: float, known: Mapping[str, str]) -> Iterator[Axis]:
    if channel.noise is None:
        return
    fit, doubts = channel.noise.fit, channel.noise.doubts
    alerts = (*channel.noise.omitted, *(alert for alert in channel.alerts if alert not in doubts))
    yield Axis(
        channel.record.name,
        fit,
        channel.record.rate,
        join("; ", doubts) if doubts else "",
        channel.readings,
        level,
        alerts,
        next((curve for curve in channel.curves if curve.statistic in ALLAN), None),
        known,
    )


@axes_of.register
def _(source: Fit) -> Iterator[Axis]:
    doubt = "" if source.valid is not None else source.model.doubt
    yield Axis(source.name, source, source.curve.rate if source.curve else None, doubt)


@axes_of.register(Model)
@axes_of.register(Term)
def _(source: Model | Term) -> Iterator[Axis]:
    model = model_of(source)
    given = tuple(Estimate(t.symbol, t.signal, t.value, None, "reported", None, "given", shape=t.shape) for t in model)
    yield Axis("", Fit(given, "given", model.signal, model), None, model.doubt)


@axes_of.register
def _(source: Mapping) -> Iterator[Axis]:  # type: ignore[type-arg]  # dispatch needs the bare class
    for name, fit in source.items():
        for axis in _within(fit):
            yield Axis(name, axis.fit, axis.rate, axis.doubt)


@axes_of.register(list)
@axes_of.register(tuple)
def _(source: Sequence[Any]) -> Iterator[Axis]:
    for part in source:
        yield from _within(part)


def _within(part: Any) -> Iterator[Axis]:
    try:
        yield from axes_of(part)
    except RecursionError:
        raise UsageError("the results given are nested too deeply, or contain themselves") from None
