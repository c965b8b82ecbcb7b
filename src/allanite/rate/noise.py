"""The noise of a record, for predictions of its rates."""

from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.record import SHORTEST, Record
from allanite.core.units import unit_of
from allanite.identification import automatic, identify
from allanite.prepare import block_means
from allanite.rate import rank
from allanite.study.analysis import Recipe
from allanite.terms import TERMS

BLOCKS = (1.0, 0.4, 0.2, 0.1)
"""Blocks in which the noise is identified where it cannot be at the full rate, s: the first that a model explains."""

HIDDEN = 1.2
"""Ratio of standard errors from which noise that was not identified is mentioned."""


def identified(record: Record, recipe: Recipe) -> tuple[Fit | None, tuple[str, ...]]:
    """The noise of a record; where none explains it at the full rate, that of the angle taken less often.

    Dither and coarse counts make lines that no term describes. Taken every second, they fold onto white noise of the
    angle, which is what they are to a rate.
    """
    # what a rate is estimated under are these five; dither is no line to be taken out, but part of the estimator
    terms = automatic() if recipe.terms == "auto" else recipe.terms
    try:
        fit = identify(record, terms=terms, band=recipe.band, lines=False)
    except DataError as error:
        return None, (f"no noise model: {error}",)
    if fit.goodness is None or fit.goodness.explained:
        return fit, ()
    for seconds in BLOCKS:
        m = round(seconds * record.rate)
        if m < 2 or record.size // m < SHORTEST:
            continue
        coarse = identify(block_means(record, m), terms=terms, lines=False)
        if coarse.goodness is not None and coarse.goodness.explained:
            note = (
                f"the noise was identified from blocks of {m} readings ({m / record.rate:.3g} s), which it explains; "
            )
            return coarse, (note + f"at the full rate {fit.goodness.verdict}",)
    return None, (
        f"{fit.goodness.verdict}; so there are no predictions and no optimal method: give the noise (--noise)",
    )


def supposed(fit: Fit, size: int, rate: float) -> tuple[Model, tuple[str, ...]]:
    """The model, with the noise at its upper limits that was not identified but would matter to the accuracy."""
    present = {t.symbol for t in fit.model}
    absent = [e for e in fit if e.symbol not in present and e.upper is not None and TERMS[e.symbol].waveform is None]
    worst = Model((*fit.model, *(Term(e.symbol, e.upper or 0.0, fit.signal) for e in absent)))
    bound, seen = (rank(model, n=size, rate=rate).best for model in (worst, fit.model))
    if bound < HIDDEN * seen:
        return fit.model, ()
    unit = fit.signal.sheet[0]
    limits = ", ".join(str(worst[e.symbol]) for e in absent)
    factor = unit_of(unit).factor
    return worst, (
        f"the record is too short to show all of its noise; what was not identified is supposed at its upper limit "
        f"({limits}): the best standard error is then {bound / factor:.2g} {unit}, without it {seen / factor:.2g}; "
        "give the noise if you know it (--noise)",
    )
