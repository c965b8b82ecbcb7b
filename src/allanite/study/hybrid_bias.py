"""Where the bias ratio of TheoBR and TheoH is not that of the noise: the curve is wrong beyond the joint."""

from collections.abc import Iterable

import numpy as np

from allanite.core.curve import Curve
from allanite.core.model import ModelLike, model_of
from allanite.phrases.phrase import say
from allanite.phrases.wording import spelled
from allanite.statistics import STATISTICS
from allanite.statistics.moments.moments import by_term

SEEN = 0.05
"""Relative error of a deviation above which a note is given."""


def joints(curves: Iterable[Curve], noise: ModelLike) -> tuple[str, ...]:
    """A note for each curve whose bias ratio is wrong under this noise by more than 5 % of the deviation."""
    notes = list[str]()
    for curve in curves:
        parts = STATISTICS[curve.statistic].parts
        offset = np.abs(curve.tau * curve.rate / curve.m - parts[-1].tau_factor) if parts else np.ones(0)
        late = np.flatnonzero(offset < 1e-6)
        if not late.size:
            continue
        theo1, model, ratios = parts[-1], model_of(noise), list[float]()
        for i in map(
            int, late[[0, -1]]
        ):  # expected deviation with the bias ratio of the curve over the Allan deviation
            own = by_term(theo1, model, int(curve.m[i]), curve.size, curve.rate).sum()
            aim = by_term(STATISTICS[theo1.target], model, 1, None, 1 / float(curve.tau[i])).sum()
            ratios.append(float(np.sqrt(curve.factor[i] * own / aim)))
        first, last = ratios
        if max(abs(first - 1), abs(last - 1)) < SEEN:
            continue
        notes.append(say(
            "the bias ratio of {statistic} assumes one kind of noise: under the identified noise the deviation is "
            "{first:.2f} times the Allan deviation at {start:g} s and {last:.2f} times at {end:g} s ({cure} "
            "corrects it)",
            statistic=curve.statistic, start=curve.tau[late[0]], end=curve.tau[late[-1]], first=first, last=last,
            cure=spelled("--bias model", "bias='model'"),
        ))  # fmt: skip
        if len(parts) > 1:
            what = say("{statistic} jumps there, where it passes from oadev to TheoBR", statistic=curve.statistic)
            notes.append(what)
    return tuple(notes)
