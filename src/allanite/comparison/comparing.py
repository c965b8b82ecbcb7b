"""What has changed between recordings: two of them, many, the channels of one, or its beginning and the rest."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.phrases.phrase import say, spelled
from allanite.prepare import trim
from allanite.study import channels
from allanite.study.channels import Progress
from allanite.study.noise import noise_of
from allanite.study.recipe import Recipe
from allanite.study.results import Study

from .comparison import Comparison, ComparisonSettings, Pair
from .contrast import compare_fits
from .pooled import Pool, PooledChannel, pool_records
from .sources import SourceSet, name_both, open_source, open_sources, run_sources
from .two_records import compare_records

Source = channels.Source | Study


@public
def compare(before: Source | Fit, after: Source | Fit, recipe: Recipe | None = None,
            *, against: Sequence[str] | None = None, rng: "np.random.Generator | None" = None,
            progress: Progress | None = None, **choices: Any) -> Comparison:  # fmt: skip
    """Compare the noise of two records, and test whether it has changed.

    The verdict is the likelihood ratio of one common noise model against two, calibrated by a parametric bootstrap.
    Each coefficient has its change in percent with a profile interval and a p-value adjusted (Holm) for the number of
    coefficients; each averaging time has the ratio of the variances with its interval. The records are assumed to be
    independent; two records of the same noise, such as raw and corrected samples, are recognized and compared as a
    pair. Sinusoids have rows of their own.

    Parameters
    ----------
    before, after : Recording, Record, Study, path, table, array, or Fit
        Paths and tables are read with the recipe's options. Channels are paired by name; two recordings of one channel
        each, or of equally many, otherwise in order. Two fits are compared by their intervals only.
    recipe : Recipe, optional
        How to read, which terms and averaging times to compare (those of the octaves by default), the level.
    against : sequence of str, optional
        Channels of `after` to compare with those of `before`, in this order.
    rng : numpy.random.Generator, optional
        For the calibration; ``default_rng(1)`` by default, so that the same records have the same verdict.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.
    **choices
        Fields of `Recipe`: ``compare(x, y, rate=100, unit="deg/s")``.

    Returns
    -------
    Comparison
        Channels that cannot be compared have a reason instead of results.

    Raises
    ------
    DataError
        A file cannot be read, or no channel can be compared: sensors of different kinds, no band of frequencies in
        common, records that are too short, constant, or the same.
    UsageError
        An option is wrong, or the channels cannot be paired.

    Examples
    --------
    >>> from allanite import N, simulate
    >>> one, two = (
    ...     simulate(N(size, "deg/sqrt(h)"), 8192, 100.0, rng=np.random.default_rng(1)) for size in (0.3, 0.24)
    ... )
    >>> found = compare(one, two)
    >>> found["N"].outcome, round(found["N"].percent), found["K"].outcome
    ('smaller', -20, 'not resolvable')
    """
    recipe = _ready(recipe, choices)
    if isinstance(before, Fit) or isinstance(after, Fit):
        return compare_fits(before, after, recipe)
    sources = open_sources((before, after), recipe, against=against, progress=progress)
    settings = ComparisonSettings(against=None if against is None else tuple(against))
    return _compare(sources, recipe, settings, rng=rng, progress=progress)


def compare_channels(source: Source, recipe: Recipe | None = None, *, rng: "np.random.Generator | None" = None,
                     progress: Progress | None = None) -> Comparison | Pool:  # fmt: skip
    """The channels of one recording, held against each other: a comparison of two, a pool of more."""
    # Parameters, errors and result are those of `compare` and `pool`.
    recipe = _ready(recipe)
    recording = open_source(source, recipe, progress)
    if len(recording) == 1:
        cure = spelled("give a second file, more channels, or --part to compare its beginning with the rest",
                       "give a second recording, more channels, or use truncation to compare its beginning with the "
                       "rest")  # fmt: skip
        raise UsageError(f"there is only one channel, {recording[0].name!r}; {cure}")
    sources = SourceSet((recording,), recording.channels, [(name_both(*recording), tuple(recording))])
    if len(recording) == 2:
        return _compare(sources, recipe, rng=rng, progress=progress)
    return _pool(sources, recipe, rng=rng, progress=progress)


@public
def pool(runs: Sequence[Source], recipe: Recipe | None = None, *, rng: "np.random.Generator | None" = None,
         progress: Progress | None = None, **choices: Any) -> Pool:  # fmt: skip
    """Pool several runs, or several units: common coefficients and curve, scatter, and outlying runs.

    Parameters
    ----------
    runs : sequence of Recording, Record, Study, path, table or array
        Two or more of one kind of sensor; the channels that all of them have are pooled. Of two, the scatter between
        runs has a single degree of freedom.
    recipe : Recipe, optional
        How to read, which terms and averaging times (those of the octaves by default), the level.
    rng : numpy.random.Generator, optional
        For the calibration of the test; ``default_rng(1)`` by default.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.
    **choices
        Fields of `Recipe`.

    Returns
    -------
    Pool
        Channels that cannot be pooled have a reason instead of results.

    Raises
    ------
    DataError
        A file cannot be read, or no channel can be pooled.
    UsageError
        There are fewer than two runs, no channel that all have, or an option is wrong.

    Examples
    --------
    >>> from allanite import N, simulate
    >>> sizes = (0.3, 0.3, 0.36, 0.3)
    >>> runs = [
    ...     simulate(N(size, "deg/sqrt(h)"), 8192, 100.0, rng=np.random.default_rng(i))
    ...     for i, size in enumerate(sizes)
    ... ]
    >>> found = pool(runs)
    >>> list(found.channels[0].apart)
    ['run 3']
    """
    recipe = _ready(recipe, choices)
    if len(runs) < 2:
        raise UsageError(f"pooling needs at least two runs, not {len(runs)}")
    return _pool(open_sources(runs, recipe, progress=progress), recipe, rng=rng, progress=progress)


@public
def truncation(source: Source, until: float, recipe: Recipe | None = None, *, rng: "np.random.Generator | None" = None,
               progress: Progress | None = None) -> Comparison:  # fmt: skip
    """Test whether a shorter record would have given the same result: compare its first part with the rest.

    Part and rest are independent, part and whole are not: the part agrees with the whole where it agrees with the rest.

    Parameters
    ----------
    source : Recording, Record, Study or path
    until : float
        Where the part ends, seconds after the first sample.
    recipe, rng, progress
        As for `compare`.

    Returns
    -------
    Comparison
        Comparison of the part with the rest; each `Pair.whole` is the fit of the whole.

    Examples
    --------
    >>> from allanite import N, simulate
    >>> record = simulate(N(0.3, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> found = truncation(record, 100.0)
    >>> found.pairs[0].changed, found.pairs[0].whole["N"].status
    (False, 'identified')
    """
    recipe = _ready(recipe)
    recording = open_source(source, recipe, progress)
    part, rest = trim(recording, None, until), trim(recording, until, None)
    pairs = [(record.name, (part[record.name], rest[record.name])) for record in recording]
    sources = SourceSet((recording,), (say("first {until:g} s", until=until), say("rest")), pairs)
    comparison = _compare(sources, recipe, ComparisonSettings(part=until), rng=rng, progress=progress)

    def with_whole(pair: Pair) -> Pair:
        """The pair and the fit of the whole, of the terms that were compared."""
        terms = ",".join(change.symbol for change in pair.changes if change.frequency is None and not change.parameter)
        whole = noise_of(recording[pair.name], recipe, terms=terms)
        doubts = (say("the whole: {doubt}", doubt=doubt) for doubt in whole.doubts)
        return replace(pair, whole=whole.fit, alerts=(*pair.alerts, *doubts))

    return replace(comparison, channels=tuple(pair if pair.refusal else with_whole(pair) for pair in comparison))


def _ready(recipe: Recipe | None, choices: Mapping[str, Any] | None = None) -> Recipe:
    """The recipe of a comparison, before anything is read."""
    recipe = (recipe or Recipe(taus="octave")).but(choices or {})
    if recipe.method != "whittle":
        raise UsageError(f"records are compared by their likelihood, method 'whittle', not {recipe.method!r}")
    return recipe


def _compare(sources: SourceSet, recipe: Recipe, settings: ComparisonSettings | None = None, *,
             rng: "np.random.Generator | None", progress: Progress | None) -> Comparison:  # fmt: skip
    kind = partial(Comparison, settings=settings or ComparisonSettings())
    work = partial(compare_records, recipe=recipe, rng=rng or np.random.default_rng(1))
    return run_sources(kind, sources, recipe, work, Pair.refused, progress=progress)


def _pool(sources: SourceSet, recipe: Recipe, *, rng: "np.random.Generator | None", progress: Progress | None) -> Pool:
    work = partial(pool_records, names=sources.names, recipe=recipe, rng=rng or np.random.default_rng(1))
    return run_sources(Pool, sources, recipe, work, PooledChannel.refused, doing="pooling", progress=progress)
