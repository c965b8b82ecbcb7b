"""The main analysis: noise coefficients of every channel with intervals, and its curve."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import Any

from allanite.core.aliases import public
from allanite.core.display_units import showing
from allanite.core.errors import DataError, UsageError
from allanite.core.record import Record
from allanite.core.units import SIGNALS, Signal
from allanite.parallel.processors import IDENTIFICATION, importing
from allanite.phrases.phrase import say, spelled
from allanite.statistics import deviation
from allanite.statistics.readings import readings

from .channels import Progress, Source, run
from .keeper import STRIDES, Inspected, Keeper, demand_grid
from .noise import begun_in, noise_in
from .recipe import Recipe
from .results import Channel, Study


@public
def analyze(source: Source, recipe: Recipe | None = None, *, progress: Progress | None = None, **choices: Any) -> Study:
    """Analyze a recording: noise coefficients of every channel, with intervals, and its curve.

    Parameters
    ----------
    source : Recording, Record, path, table or array
        A path or a table is read with the recipe's options. The columns of an array of shape (n, channels), or the
        values of one of shape (n,), become records with its rate and unit.
    recipe : Recipe, optional
        All choices; the defaults are the standard analysis.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.
    **choices
        Fields of `Recipe`: ``analyze(table, rate=100, unit="deg/s")``.

    Returns
    -------
    Study
        Channels that cannot be analyzed have a reason instead of results.

    Raises
    ------
    DataError
        The file cannot be read, or none of its channels can be analyzed.
    UsageError
        An option is wrong, or a required one is missing.
    """
    recipe = (recipe or Recipe()).but(choices)
    study = analyzed(source, recipe, progress)
    demand_shown(recipe, (channel.record.signal for channel in study.channels))
    return study


def demand_shown(recipe: Recipe, of: Iterable[Signal]) -> None:
    """Refuse a unit of the recipe in which no coefficient of any channel can be shown, by the signals of these."""
    signals = {signal.name: signal for signal in of}
    for unit in recipe.to or ():
        if not any(signal.name in signals for signal in showing(unit)):
            units = ", ".join(signal.sheet[0] for signal in signals.values())
            wanted = spelled("--output-unit", "to=")
            raise UsageError(f"no channel has a coefficient in {unit!r} ({wanted}); the channels are in {units}")


def analyzed(source: Source, recipe: Recipe, progress: Progress | None = None) -> Study:
    """The study of a recording, as `analyze` returns it; not every unit of the recipe need fit it."""

    def keeping(head: Record, size: int) -> Keeper:
        demand_grid(recipe.taus, None, head.rate)
        return Keeper(head, (recipe.statistic,))

    with importing(IDENTIFICATION, kernels=recipe.method == "whittle"):
        return run(Study, source, recipe, lambda seen: _channel(seen, recipe), Channel.refused, keeping=keeping,
                   begin=partial(begun_in, recipe=recipe), in_parts_too=(STRIDES,), progress=progress)  # fmt: skip


def _channel(seen: Inspected, recipe: Recipe) -> Channel:
    """The result of one channel."""
    keeper = seen.keeper
    read = readings(seen.record) if keeper is None else None  # first, as it takes every deviation that is asked for
    noise = noise_in(seen, recipe)
    (curve,) = keeper.curves(noise.fit, recipe.taus) if keeper else (
        deviation(seen.record, recipe.statistic, taus=recipe.taus, noise=noise.fit),
    )  # fmt: skip
    if keeper is None and curve.supposes is not None:
        curve.supposes()  # the angle is given up; limits are computed where they are shown
        if curve.law is not None and all(s.name in seen.beside for s in SIGNALS if s.inertial):
            curve.interval(recipe.level)  # which the values for a filter need
    noise = replace(noise, fit=replace(noise.fit, curve=curve))
    return Channel(seen.first, seen.quality, noise, curves=(curve,), readings=read).to(*(recipe.to or ()))


def refitted(channel: Channel, recipe: Recipe) -> Channel:
    """A channel of a study analyzed once more with other choices of the identification or curve."""
    if not isinstance(channel.record, Record):
        raise DataError(say("the samples of {channel!r} are not in memory: analyze the file once more",
                            channel=channel.record.name))  # fmt: skip
    return _channel(Inspected(channel.record.name, (channel.record,), (channel.quality,)), recipe)


def examine(source: Source, recipe: Recipe | None = None, *, progress: Progress | None = None) -> Study:
    """Summarize a recording and check its quality: a study without results."""
    # Parameters, exceptions and result are those of `analyze`, but no channel has a curve or a fit.
    recipe = recipe or Recipe()
    return run(Study, source, recipe, lambda seen: Channel(seen.first, seen.quality), Channel.refused,
               keeping=lambda head, _: Keeper(head), doing="inspecting", demand=False, progress=progress)  # fmt: skip
