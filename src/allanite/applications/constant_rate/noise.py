"""The noise that the errors of a rate follow from."""

from dataclasses import replace
from typing import NamedTuple

from allanite.extending import (
    SHORTEST,
    TERMS,
    DataError,
    Fit,
    Model,
    Noise,
    Recipe,
    Record,
    Term,
    automatic,
    block_means,
    join,
    noise_of,
    say,
    say_count,
    spelled,
    unit_of,
)

from .predict import rank

BLOCKS = (1.0, 0.4, 0.2, 0.1)
"""Lengths of blocks for which the noise is identified if no model explains the full rate, s; the first success is
used.
"""

MIN_RATIO = 1.2  # ratio of standard errors from which noise that was not identified is mentioned


FAST = ("quantized", "resampled", "lines", "slope")
"""Findings about single samples: where the noise is that of blocks, its alert says so already."""


class RateNoise(NamedTuple):
    """The noise of a channel: identified, the model that is used, alerts, findings that need no other words, notes."""

    # There is no model where the noise is not explained.
    noise: Noise | None = None
    model: Model | None = None
    alerts: tuple[str, ...] = ()
    settled: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def noise_of_rates(record: Record, recipe: Recipe, interval: float, given: Model | None = None) -> RateNoise:
    """The noise that rates of `interval` seconds are measured under; as given, or identified."""
    # Where no model explains the record, it is that of means over blocks of samples: dither and coarse counts make
    # lines that no term describes; averaged over a second, they fold onto white angle noise, which is what they are to
    # a rate.
    if given is not None:
        return RateNoise(model=given, settled=("short",))
    # what a rate is estimated under are these five; dither is no line to be removed, but part of the estimator
    terms = automatic() if recipe.terms == "auto" else recipe.terms
    size = min(round(interval * record.rate), record.size)
    try:
        noise = noise_of(record, recipe, terms=terms, lines=False)
        if noise.explained:
            return RateNoise(noise, *_supposed(noise.fit, size, record.rate))
        for m in (round(seconds * record.rate) for seconds in BLOCKS):
            if m < 2 or record.size // m < SHORTEST:
                continue
            coarse = noise_of(block_means(record, m), replace(recipe, band="auto"), terms=terms, lines=False)
            if coarse.verdict and coarse.explained:
                model, alerts = _supposed(coarse.fit, size, record.rate)
                if record.kind == "count":
                    counted = say("the noise was identified from counts over {length:.3g} s, which the model "
                                  "explains: dither and single pulses, which are faster, are part of Q",
                                  length=m / record.rate)  # fmt: skip
                    return RateNoise(coarse, model, alerts, FAST, (counted,))
                note = say_count(
                    m,
                    "the noise was identified from blocks of {count} sample ({length:.3g} s), which the model "
                    "explains; at the full rate: {statement}",
                    "the noise was identified from blocks of {count} samples ({length:.3g} s), which the model "
                    "explains; at the full rate: {statement}",
                    length=m / record.rate, statement=join("; ", (noise.statement.head, *noise.statement.points[:1])),
                )  # fmt: skip
                return RateNoise(coarse, model, (note, *alerts), FAST)
    except DataError as error:
        return RateNoise(alerts=(say("no noise model: {reason}", reason=str(error)),))
    lacking = say("no predictions and no optimal method without a noise model: give it with {option}",
                  option=spelled("--noise", "noise=..."))  # fmt: skip
    return RateNoise(noise, alerts=(lacking,))


def _supposed(fit: Fit, n: int, rate: float) -> tuple[Model, tuple[str, ...]]:
    """The model, with the noise at its upper limits that was not identified but would matter to n samples."""
    # Angle noise counts whatever rounding can cause: dither is that to a rate.
    valid = tuple(fit.valid or ())
    folded = tuple(t for t in fit.model if t.row.edge and t.symbol not in {v.symbol for v in valid})
    model = Model((*valid, *folded)) if valid or folded else fit.usable()
    present = {t.symbol for t in model}
    absent = [e for e in fit if e.symbol not in present and e.upper is not None and TERMS[e.symbol].waveform is None]
    worst = Model((*model, *(Term(e.symbol, e.upper or 0.0, fit.signal) for e in absent)))
    bound, best = (rank(noise, size=n, rate=rate).best for noise in (worst, model))
    if bound < MIN_RATIO * best:
        return model, ()
    unit = fit.signal.sheet[0]
    limits = ", ".join(str(worst[e.symbol]) for e in absent)
    factor = unit_of(unit).factor
    return worst, (say("the record is too short to determine all of its noise; terms that were not identified are "
                       "assumed at their upper limits ({limits}): the best standard error is then {supposed:.2g} "
                       "{unit}, without them {seen:.2g}; give the noise if you know it ({option})", limits=limits,
                       supposed=bound / factor, unit=unit, seen=best / factor,
                       option=spelled("--noise", "noise=...")),)  # fmt: skip
