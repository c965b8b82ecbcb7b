"""Several runs become a pool; and a part of a record is held against the whole."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.record import Record, Recording
from allanite.identification import identify
from allanite.identification.likelihood.selection import standard_error
from allanite.prepare import trim
from allanite.statistics import deviation
from allanite.study.analysis import Recipe

from .change import alpha_of, holm
from .comparison import Comparison, Pair
from .contrast import homogeneity, outlying, spread
from .joint import Joint, least
from .pooled import Pool, PooledChannel, PooledTerm
from .ratio import shared_factors
from .study import Progress, Source, called, compare, demand_fit, doubts, gathered, loaded, origin, remarks

FloatArray = NDArray[np.float64]


def pool(
    runs: Sequence[Source],
    recipe: Recipe | None = None,
    *,
    rng: "np.random.Generator | None" = None,
    progress: Progress | None = None,
) -> Pool:
    """What several runs, or several units, have in common: coefficients, curve, scatter, and runs that lie apart.

    Parameters
    ----------
    runs : sequence of Recording, Record, Study or path
        Three or more of one kind of sensor; the channels that all of them have are pooled.
    recipe : Recipe, optional
        How to read, which terms and averaging times (those of the octaves by default), the level.
    rng : numpy.random.Generator, optional
        For the calibration of the test; ``default_rng(1)`` by default.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Returns
    -------
    Pool

    Raises
    ------
    DataError
        A file cannot be read, or no channel can be pooled.
    UsageError
        There are fewer than three runs, no channel that all have, or an option is wrong.

    Examples
    --------
    >>> from allanite.core.model import N
    >>> from allanite.simulation.record import simulate
    >>> sizes = (0.3, 0.3, 0.36, 0.3)
    >>> runs = [
    ...     simulate(N(size, "deg/sqrt(h)"), 8192, 100.0, rng=np.random.default_rng(i))
    ...     for i, size in enumerate(sizes)
    ... ]
    >>> found = pool(runs)
    >>> list(found.channels[0].apart)
    ['run 3']
    """
    recipe = recipe or Recipe(taus="octave")
    if len(runs) < 3:
        raise UsageError(f"runs are pooled from three on, and {len(runs)} came; of two, compare(before, after)")
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    recordings = [loaded(run, recipe) for run in runs]
    names, said = called(*runs), remarks(*recordings)
    rng = rng or np.random.default_rng(1)
    channels = []
    matched = _channels(recordings)
    for i, (name, records) in enumerate(matched):
        tell(f"pooling {name}", (i + 0.3) / (len(matched) + 0.3))
        try:
            channels.append(_pooled(name, records, names, (recipe, rng)))
        except DataError as error:
            channels.append(PooledChannel(name, refusal=str(error)))
    if all(channel.refusal for channel in channels):
        raise DataError("; ".join(f"{c.name or 'the runs'}: {c.refusal}" for c in channels))
    tell("done", 1.0)
    return Pool(tuple(channels), names, recipe.level, recipe.to_dict(), said, origin(*recordings))


def truncation(
    source: Source,
    until: float,
    recipe: Recipe | None = None,
    *,
    rng: "np.random.Generator | None" = None,
    progress: Progress | None = None,
) -> Comparison:
    """Whether a shorter record would have said the same: the first part held against the rest, with the whole beside.

    Part and rest are independent, part and whole are not: the part agrees with the whole where it agrees with the rest.

    Parameters
    ----------
    source : Recording, Record, Study or path
    until : float
        Where the part ends, seconds after the first sample.
    recipe, rng, progress
        As of `compare`.

    Returns
    -------
    Comparison
        Of the part with the rest; each `Pair.whole` is the fit of the whole.

    Examples
    --------
    >>> from allanite.core.model import N
    >>> from allanite.simulation.record import simulate
    >>> record = simulate(N(0.3, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> found = truncation(record, 100.0)
    >>> found.pairs[0].changed, found.pairs[0].whole["N"].status
    (False, 'identified')
    """
    recipe = recipe or Recipe(taus="octave")
    recording = loaded(source, recipe)
    part, rest = trim(recording, None, until), trim(recording, until, None)
    found = compare(part, rest, recipe, rng=rng, progress=progress)
    pairs = tuple(pair if pair.refusal else replace(pair, whole=_whole(pair, recording, recipe)) for pair in found)
    return replace(found, pairs=pairs, names=(f"first {until:g} s", "rest"))


def _whole(pair: Pair, recording: Recording, recipe: Recipe) -> Fit:
    """The fit of the whole, of the terms that were compared."""
    terms = ",".join(c.symbol for c in pair.changes)
    return identify(recording[pair.name], terms=terms, band=recipe.band, outliers=recipe.outliers or "mark")


def _channels(recordings: Sequence[Recording]) -> list[tuple[str, tuple[Record, ...]]]:
    """Channels that all recordings have; the only one of each, whatever its name."""
    if all(len(recording) == 1 for recording in recordings):
        return [(recordings[0][0].name, tuple(recording[0] for recording in recordings))]
    common = [name for name in recordings[0].channels if all(name in r.channels for r in recordings)]
    if not common:
        raise UsageError("the recordings have no channel in common; name one of each (channels, --channels)")
    return [(name, tuple(recording[name] for recording in recordings)) for name in common]


def _pooled(
    name: str,
    records: tuple[Record, ...],
    names: Sequence[str],
    made: "tuple[Recipe, np.random.Generator]",
) -> PooledChannel:
    recipe, rng = made
    alpha = alpha_of(recipe.level)
    alerts = demand_fit(records)
    together, fits, said = gathered(records, recipe)
    curves, curve, p = _curves(records, fits, recipe)
    apart, left = _apart(together, names, alpha)
    test = homogeneity(together, rng)
    return PooledChannel(
        name,
        test=test,
        terms=_terms(together, fits),
        curve=curve,
        curves=curves,
        p=p,
        apart=apart,
        rest=(homogeneity(left, rng) if apart else test).p,
        fits=fits,
        records=records,
        band=together.band,
        alerts=(*doubts(fits), *said, *alerts),
        alpha=alpha,
    )


def _terms(together: Joint, fits: Sequence[Fit]) -> tuple[PooledTerm, ...]:
    free = together.chosen.free
    alone, _ = least(together.only(free))
    found = [spread(together, i) for i in range(len(together.symbols))]
    adjusted = holm([p for _, p in found])
    terms = []
    for i, symbol in enumerate(together.symbols):
        theta = float(together.chosen.theta[i])
        between = within = math.nan
        if theta > 0:
            column = int(free[:i].sum())
            values = np.sqrt([part[column] / theta for part in alone])
            common = [replace(together.chosen, likelihood=part) for part in together.parts]
            errors = [standard_error(subset, i) / (2 * theta) for subset in common]
            between, within = float(values.std(ddof=1)), float(np.sqrt(np.mean(np.square(errors))))
        statistic, p = found[i]
        runs, dof = tuple(fit[symbol] for fit in fits), len(fits) - 1
        terms.append(
            PooledTerm(
                symbol,
                together.signal,
                value=math.sqrt(theta),
                limits=Remembered(partial(together.limits, i)),
                runs=runs,
                between=between,
                within=within,
                statistic=statistic,
                dof=dof,
                p=p,
                adjusted=adjusted[i],
            )
        )
    return tuple(terms)


def _apart(together: Joint, names: Sequence[str], alpha: float) -> tuple[dict[str, float], Joint]:
    """Runs that differ from all others, the worst one taken out at a time, and what is left."""
    apart: dict[str, float] = {}
    left = list(range(len(names)))
    rest = together
    while len(left) > 2:
        p = holm(outlying(rest))
        worst = int(np.argmin(p))
        if p[worst] > alpha:
            break
        apart[names[left.pop(worst)]] = p[worst]
        rest = replace(
            together, parts=tuple(together.parts[i] for i in left), seen=tuple(together.seen[i] for i in left)
        )
    return apart, rest


@dataclass(frozen=True, eq=False)
class PooledLaw:
    """Chi-square limits of variances averaged by their degrees of freedom, whose sum is `edf`, shape (k,)."""

    edf: FloatArray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        from scipy.special import chdtri

        low, high = (self.edf / chdtri(self.edf, p) for p in ((1 - level) / 2, (1 + level) / 2))
        return self.edf, low, high


def _curves(
    records: tuple[Record, ...], fits: Sequence[Fit], recipe: Recipe
) -> tuple[tuple[Curve, ...], Curve, FloatArray]:
    """The curve of each run, that of all, and p of their being the same at each averaging time."""
    m = shared_factors(records, recipe.statistic, recipe.taus)
    curves = tuple(
        deviation(record, recipe.statistic, m=factors.tolist(), noise=fit.model)
        for record, factors, fit in zip(records, m, fits, strict=True)
    )
    edf = np.array([curve.edf for curve in curves])
    variance = np.array([curve.variance for curve in curves])
    whole = edf.sum(axis=0)
    mean = (edf * variance).sum(axis=0) / whole

    count = np.sum([curve.count for curve in curves], axis=0)
    curve = replace(
        curves[0], variance=mean, count=count, name="all runs", law=PooledLaw(whole), noise=None, history=()
    )
    return curves, curve, bartlett(variance, edf)


def bartlett(variance: FloatArray, edf: FloatArray) -> FloatArray:
    """Probability that variances of shape (runs, k) with these degrees of freedom differ as much by chance, shape (k,).

    References
    ----------
    M. S. Bartlett, Proc. Royal Society A 160 (1937) 268.

    Examples
    --------
    >>> bartlett(np.array([[1.0], [1.0], [1.0]]), np.full((3, 1), 9.0)).tolist()
    [1.0]
    """
    from scipy.special import chdtrc

    runs, whole = len(edf), edf.sum(axis=0)
    mean = (edf * variance).sum(axis=0) / whole
    statistic = whole * np.log(mean) - (edf * np.log(variance)).sum(axis=0)
    correction = 1 + ((1 / edf).sum(axis=0) - 1 / whole) / (3 * (runs - 1))
    return np.asarray(chdtrc(runs - 1, np.maximum(statistic, 0.0) / correction))
