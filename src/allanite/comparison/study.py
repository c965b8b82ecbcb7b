"""Before and after: it composes records, their fits and curves into a comparison, as `study` does into a study."""

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import Model
from allanite.core.record import Record, Recording
from allanite.identification import identify, symbols_of
from allanite.prepare import inspect
from allanite.prepare import outliers as robust
from allanite.statistics import deviation
from allanite.study.analysis import Recipe, Study, provenance_of, recording_of
from allanite.terms import TERMS

from .change import Change, alpha_of, holm
from .comparison import Comparison, Pair, Ratios
from .contrast import Contrast, homogeneity, partly_common
from .intervals import IntervalContrast
from .joint import Joint, common_band, demand_one_kind, joint
from .ramps import RampContrast, ramp_law
from .ratio import ratio_law, shared_factors

Source = Recording | Record | Study | Fit | str | os.PathLike[str]
Progress = Callable[[str, float], None]


def compare(
    before: Source,
    after: Source,
    recipe: Recipe | None = None,
    *,
    against: Sequence[str] | None = None,
    rng: "np.random.Generator | None" = None,
    progress: Progress | None = None,
) -> Comparison:
    """What has changed between two records, and whether that is more than chance.

    The verdict is the likelihood ratio of one common noise model against two, calibrated by drawing; each coefficient
    has its change in percent with profile limits and a p adjusted (Holm) for the number of coefficients; at each
    averaging time stands the ratio of the variances with its limits. The records are supposed to be independent.

    Parameters
    ----------
    before, after : Recording, Record, Study, path, or Fit
        Paths are read with the recipe's options. Channels are paired by name; two recordings of one channel each, or of
        equally many, otherwise in order. Two fits are compared by their intervals only.
    recipe : Recipe, optional
        How to read, which terms and averaging times to compare (those of the octaves by default), the level.
    against : sequence of str, optional
        Channels of `after` that are compared with those of `before`, in this order.
    rng : numpy.random.Generator, optional
        For the calibration; ``default_rng(1)`` by default, so that the same records have the same verdict.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Returns
    -------
    Comparison
        Channels that cannot be compared carry the reason and no numbers.

    Raises
    ------
    DataError
        A file cannot be read, or no channel can be compared: sensors of different kinds, no band of frequencies in
        common, records that are too short, constant, or the same.
    UsageError
        An option is wrong, or the channels do not pair.

    Examples
    --------
    >>> from allanite.core.model import N
    >>> from allanite.simulation.record import simulate
    >>> one, two = (
    ...     simulate(N(size, "deg/sqrt(h)"), 8192, 100.0, rng=np.random.default_rng(1)) for size in (0.3, 0.24)
    ... )
    >>> found = compare(one, two)
    >>> found["N"].outcome, round(found["N"].percent), found["K"].outcome
    ('smaller', -20, 'not resolvable')
    """
    recipe = recipe or Recipe(taus="octave")
    if recipe.method != "whittle":
        raise UsageError(f"records are compared by their likelihood, method 'whittle', not by {recipe.method!r}")
    if isinstance(before, Fit) or isinstance(after, Fit):
        return _of_fits(before, after, recipe)
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    first = loaded(before, recipe)
    second = loaded(after, recipe if against is None else replace(recipe, channels=tuple(against)))
    said = remarks(first, second)
    matched, notes = _matched(first, second, ordered=against is not None)
    rng = rng or np.random.default_rng(1)
    pairs = []
    for i, (name, records) in enumerate(matched):
        tell(f"comparing {name}", (i + 0.3) / (len(matched) + 0.3))
        try:
            pairs.append(_pair(name, records, recipe, rng))
        except DataError as error:
            pairs.append(Pair(name, refusal=str(error)))
    if all(pair.refusal for pair in pairs):
        raise DataError("; ".join(f"{pair.name or 'the records'}: {pair.refusal}" for pair in pairs))
    tell("done", 1.0)
    return Comparison(
        tuple(pairs),
        names=called(before, after),
        level=recipe.level,
        choices=recipe.to_dict(),
        notes=(*said, *notes),
        provenance=origin(first, second),
    )


def loaded(source: Any, recipe: Recipe) -> Recording:
    """The recording of whatever holds one."""
    if isinstance(source, Study):
        return Recording(tuple(channel.record for channel in source.channels), notes=source.notes)
    if not isinstance(source, (Recording, Record, str, os.PathLike)):
        raise UsageError(f"a {type(source).__name__} cannot be compared; give records, recordings, studies or paths")
    return recording_of(source, recipe)


def called(*sources: Any) -> tuple[Any, ...]:
    """What the sources are called: the names of files or records where these differ."""
    names = [_own_name(source) for source in sources]
    if all(names) and len(set(names)) == len(names):
        return tuple(names)
    return ("before", "after") if len(sources) == 2 else tuple(f"run {i + 1}" for i in range(len(sources)))


def _own_name(source: Any) -> str:
    if isinstance(source, (str, os.PathLike)):
        return os.path.basename(source)
    if isinstance(source, Recording):
        return source[0].name if len(source) == 1 else ""
    return str(getattr(source, "name", ""))


def remarks(*recordings: Recording) -> tuple[str, ...]:
    """What was assumed when reading, and what is wrong with the clocks.

    Raises
    ------
    DataError
        A clock does not support the job.
    """
    findings = [finding for recording in recordings for finding in recording.findings]
    fatal = [str(finding) for finding in findings if finding.fatal]
    if fatal:
        raise DataError(". ".join(fatal))
    notes = [note for recording in recordings for note in recording.notes]
    return tuple(dict.fromkeys((*notes, *map(str, findings))))


def origin(*recordings: Recording) -> dict[str, str]:
    """Version and inputs, for whoever wants to do it again."""
    made = provenance_of(recordings[0])
    for i, recording in enumerate(recordings[1:], 2):
        made |= {f"source {i}": recording.source, f"sha256 {i}": recording.digest}
    return made


def _matched(
    first: Recording, second: Recording, *, ordered: bool
) -> tuple[list[tuple[str, tuple[Record, Record]]], list[str]]:
    """Which channel is compared with which."""
    common = [name for name in first.channels if name in second.channels]
    if common and not ordered:
        alone = sorted({*first.channels, *second.channels} - set(common))
        notes = [f"not in both recordings, and not compared: {', '.join(alone)}"] if alone else []
        return [(name, (first[name], second[name])) for name in common], notes
    if len(first) != len(second):
        raise UsageError(
            f"the channels do not pair: {', '.join(first.channels)} before, {', '.join(second.channels)} after; name "
            "as many of each (channels, --channels; against, --against)"
        )
    pairs = list(zip(first, second, strict=True))
    notes = [f"channel {a.name} is compared with {b.name}" for a, b in pairs if a.name != b.name and a.name and b.name]
    return [(name_of(a, b), (a, b)) for a, b in pairs], notes


def name_of(first: Record | Fit, second: Record | Fit) -> str:
    """One name for both."""
    return " / ".join(dict.fromkeys(name for name in (first.name, second.name) if name))


def demand_fit(records: Sequence[Record]) -> list[str]:
    """What must stand beside the numbers of records that support the job.

    Raises
    ------
    DataError
        One of them does not, or two are the same.
    """
    alerts = []
    for i, record in enumerate(records):
        quality = inspect(record)
        if quality.refusal:
            raise DataError(f"record {i + 1}: {quality.refusal}")
        alerts += [f"record {i + 1}: {finding}" for finding in quality.warnings]
        for j, other in enumerate(records[:i]):
            if len(other.values) == len(record.values) and np.array_equal(other.values, record.values):
                raise DataError(f"records {j + 1} and {i + 1} hold the same readings; there is nothing to compare")
    return alerts


def gathered(records: Sequence[Record], recipe: Recipe) -> tuple[Joint, tuple[Fit, ...], list[str]]:
    """The joint likelihood of records, the fit of each, and what must stand beside the numbers.

    Outliers are left out, and sinusoids taken out as the fits found them. Where one record has Gauss-Markov noise it is
    asked of all, and compared at one time constant.
    """
    demand_one_kind(records)
    records, notes = _without_outliers(records, recipe)
    symbols = [s for s in symbols_of(recipe.terms) if not TERMS[s].periodic]
    band = common_band(records, recipe.band)
    fits = _fits(records, recipe.terms, band, recipe)
    shown = dict.fromkeys((*symbols, *(e.symbol for fit in fits for e in fit)))
    if len(shown) > len(symbols):
        fits = _fits(records, ",".join(shown), band, recipe)
    constants = [e.shape[0] for fit in fits for e in fit if e.shape]
    constant = math.exp(sum(map(math.log, constants)) / len(constants)) if constants else None
    quiet = [_without_lines(record, fit) for record, fit in zip(records, fits, strict=True)]
    notes += [
        f"record {i + 1}: sinusoids were taken out, at {', '.join(f'{line.frequency:.6g}' for line in fit.lines)} Hz"
        for i, fit in enumerate(fits)
        if fit.lines
    ]
    if constant is not None:
        notes.append(f"Gauss-Markov noise is compared at one time constant, {constant:.3g} s")
    return joint(quiet, tuple(shown), recipe.band, constant=constant), fits, notes


def _fits(records: Sequence[Record], terms: str, band: tuple[float, float], recipe: Recipe) -> tuple[Fit, ...]:
    """The fit of each record, in the common band where that leaves out a part of one."""
    low, high = band
    cut = any(r.rate / 2 > high * (1 + 1e-9) or 0.75 / r.duration <= low for r in records)
    used = (low * (1 - 1e-9), high * (1 + 1e-9)) if cut else recipe.band
    return tuple(identify(record, terms=terms, band=used, outliers="keep") for record in records)


def _without_outliers(records: Sequence[Record], recipe: Recipe) -> tuple[list[Record], list[str]]:
    """The records with their outliers lost, unless the recipe keeps them, and what is said of that."""
    if (recipe.outliers or "mark") != "mark":
        return list(records), []
    found = [robust.outliers(record) for record in records]
    notes = [
        f"record {i + 1}: {outliers.words(record.rate)}: left out of the comparison"
        for i, (record, outliers) in enumerate(zip(records, found, strict=True))
        if outliers.at.size
    ]
    return [robust.marked(record, outliers) for record, outliers in zip(records, found, strict=True)], notes


def _without_lines(record: Record, fit: Fit) -> Record:
    rates = record.rate_values
    for line in fit.lines:
        wave = line.term.sampled(record.rate).waveform
        assert wave is not None  # noqa: S101 - a sinusoid has one
        rates = rates - line.amplitude * wave(record.size)
    return Record(rates, record.rate, record.signal.unit, name=record.name) if fit.lines else record


def doubts(fits: Sequence[Fit]) -> list[str]:
    """Where a model does not explain its record."""
    return [
        f"record {i + 1}: {fit.goodness.verdict}; a difference of what it leaves out may pass for one of its terms"
        for i, fit in enumerate(fits)
        if fit.goodness is not None and not fit.goodness.explained
    ]


def _pair(name: str, records: tuple[Record, Record], recipe: Recipe, rng: "np.random.Generator") -> Pair:
    alerts = demand_fit(records)
    both, (first, second), said = gathered(records, recipe)
    changes = _changes(both, (first, second), recipe.level)
    try:
        ratios = ratios_of(records, (first, second), law_models(both, (first, second), changes), recipe)
    except DataError as error:
        ratios, alerts = None, [*alerts, str(error)]
    return Pair(
        name,
        test=homogeneity(both, rng),
        changes=changes,
        ratios=ratios,
        band=both.band,
        fits=(first, second),
        records=records,
        alerts=(*doubts((first, second)), *said, *alerts),
        alpha=alpha_of(recipe.level),
    )


def _changes(both: Joint, fits: tuple[Fit, Fit], level: float) -> tuple[Change, ...]:
    found: dict[str, Contrast | RampContrast] = {s: Contrast(both, i) for i, s in enumerate(both.symbols)}
    first, second = fits
    ramps = ramp_law(both, 0), ramp_law(both, 1)
    if ramps[0] is not None and ramps[1] is not None:
        found |= {e.symbol: RampContrast(ramps[0], ramps[1]) for e in first if TERMS[e.symbol].waveform is not None}
    kept = [e.symbol for e in first if e.symbol in found]
    p = [found[s].p for s in kept]
    return tuple(
        Change(
            s,
            both.signal,
            first[s],
            second[s],
            found[s].ratio,
            q,
            adjusted,
            Remembered(found[s].limits),
            alpha_of(level),
        )
        for s, q, adjusted in zip(kept, p, holm(p), strict=True)
    )


def law_models(both: Joint, fits: tuple[Fit, Fit], changes: Sequence[Change]) -> list[Model]:
    """What is supposed of each record for the law of the ratio: coefficients that are not told apart are common.

    What scatters at the longest averaging times is hardly seen by one record alone.
    """
    apart = [change.symbol for change in changes if change.significant]
    found = []
    for fit, values in zip(fits, partly_common(both, apart), strict=True):
        noise = [both.term(symbol, value) for symbol, value in values.items() if value > 0]
        ramps = [term for term in fit.model if term.row.waveform is not None and not term.row.periodic]
        found.append(Model((*noise, *ramps)))
    return found


def ratios_of(
    records: tuple[Record, Record], fits: tuple[Fit, Fit], supposed: Sequence[Model], recipe: Recipe
) -> Ratios:
    """The curves of both at the same averaging times, and the law of their ratio."""
    m = shared_factors(records, recipe.statistic, recipe.taus)
    before, after = (
        deviation(record, recipe.statistic, m=factors.tolist(), noise=fit.model)
        for record, factors, fit in zip(records, m, fits, strict=True)
    )
    law = ratio_law(records, recipe.statistic, m, supposed)
    ratio = after.variance / before.variance
    return Ratios(before, after, law.p(ratio), Remembered(partial(law.limits, ratio)))


def _of_fits(before: Any, after: Any, recipe: Recipe) -> Comparison:
    if not (isinstance(before, Fit) and isinstance(after, Fit)):
        raise UsageError("a fit can be compared with a fit only; give both records, which tell more")
    if before.signal is not after.signal:
        raise DataError(
            f"only sensors of one kind can be compared, not {before.signal.name} and {after.signal.name} signals"
        )
    common = [e.symbol for e in before if e.symbol in [other.symbol for other in after]]
    found = [IntervalContrast(before[s], after[s]) for s in common]
    p = [contrast.p for contrast in found]
    changes = tuple(
        Change(
            s, before.signal, before[s], after[s], c.ratio, q, adjusted, Remembered(c.limits), alpha_of(recipe.level)
        )
        for s, c, q, adjusted in zip(common, found, p, holm(p), strict=True)
    )
    pair = Pair(name_of(before, after), changes=changes, fits=(before, after), alpha=alpha_of(recipe.level))
    notes = ("compared by the intervals of the coefficients only: the records would tell more",)
    return Comparison((pair,), level=recipe.level, choices={}, notes=notes)
