"""Residuals: what a model leaves of a record, whether that is white, Gaussian and steady, and why not."""

from dataclasses import dataclass
from typing import Any

from .arrays import FloatArray
from .finding import Finding
from .fit import Fit, Goodness, chance
from .plain import Value
from .scope import APPROXIMATE, EXPLAINED, UNEXPLAINED, worst

SURE = 1e-3
"""p value of a check below which it says that the model does not explain the record."""


@dataclass(frozen=True, repr=False)
class Check(Value):
    """One question asked of the residuals.

    `value` is the size of what would be wrong, `p` the probability of more by chance.
    """

    name: str
    title: str
    value: float
    p: float
    meaning: str

    @property
    def passed(self) -> bool:
        """Whether chance makes it."""
        return self.p >= SURE


@dataclass(frozen=True, eq=False, repr=False)
class Residuals(Value):
    """What a model leaves of a record, as `allanite.residuals` gives it; the series itself: `allanite.whitened`.

    Attributes
    ----------
    name, rate, size
        Of the record.
    goodness : Goodness or None
        Observed over expected power by cells of frequency, of the fit.
    checks : tuple of Check
        Correlation of neighbours, tails, level in halves and eighths; none where too little is left to be asked.
    findings : tuple of Finding
        What is likely wrong, beside what `goodness` says of the spectrum; empty if the model explains the record.
    correlation : array, shape (20,)
        Of residuals 1 to 20 samples apart.
    level, level_error : arrays, shape (8,)
        Rms of each eighth, and its standard error.
    time, low, high : arrays, shape (about 400,)
        Middles of stretches, s, with the least and the largest residual of each.
    expected, observed : arrays, shape (about 200,)
        Quantiles of the normal distribution, and those of the residuals.
    """

    name: str
    rate: float
    size: int
    goodness: Goodness | None
    checks: tuple[Check, ...]
    findings: tuple[Finding, ...]
    correlation: FloatArray
    level: FloatArray
    level_error: FloatArray
    time: FloatArray
    low: FloatArray
    high: FloatArray
    expected: FloatArray
    observed: FloatArray

    @property
    def grade(self) -> str:
        """Of the residuals themselves: a finding makes the model approximate, a fatal one wrong."""
        return worst(EXPLAINED, *(UNEXPLAINED if finding.fatal else APPROXIMATE for finding in self.findings))

    @property
    def explained(self) -> bool:
        """Whether the model can be believed, if only approximately."""
        return self.grade != UNEXPLAINED and (self.goodness is None or self.goodness.explained)

    @property
    def verdict(self) -> str:
        """One sentence; the likeliest reason comes first."""
        return verdict(worst(self.grade, "" if self.explained else UNEXPLAINED), None, self)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the model does not explain the record, the likeliest first: rounding, the spectrum, level and tails."""
        found = [(finding.name != "no dither", str(finding)) for finding in self.findings]
        spectral = () if self.goodness is None else self.goodness.reasons
        first = tuple(text for late, text in found if not late)
        return tuple(dict.fromkeys((*first, *spectral, *(text for late, text in found if late))))

    def __getitem__(self, name: str) -> Check:
        return next(check for check in self.checks if check.name == name)

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: a check a row."""
        rows = [[check.name, check.title, check.value, check.p, check.meaning] for check in self.checks]
        return ["check", "", "value", "p", "meaning"], rows

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        p = None if self.goodness is None else self.goodness.p
        return super().to_dict(level) | {"explained": self.explained, "gof_p": p}

    def _summary(self) -> str:
        return f"of {self.name!r}: {self.verdict}"


def verdict(grade: str, fit: Fit | None, left: Residuals | None) -> str:
    """How well a model explains a record, in a sentence: the grade, the test, the reasons, what was supposed."""
    good = fit.goodness if fit is not None else left.goodness if left is not None else None
    scope = None if fit is None else fit.scope
    if not grade:
        return ""
    test = "" if good is None else f" (goodness of fit {chance(good.p)})"
    why = left.reasons if left is not None else good.reasons if good is not None else ()
    if grade != UNEXPLAINED and fit is not None:
        why = (*(f"{e.symbol} is not valid: {e.reason}" for e in fit if e.status == "not valid"), *why)
    if grade == UNEXPLAINED:
        said = (f"no model of these terms explains the record{test}", *why)
    elif scope is not None and scope.misfit:
        said = (
            f"the model explains the record within {100 * scope.within:.2g} % of the power{test}; the limits allow "
            "for it",
            *why,
        )
    elif grade == APPROXIMATE:
        said = (f"the model explains the spectrum of the record{test}, with a reservation", *why)
    else:
        said = (f"the model explains the record{test}",)
    supposed = () if scope is None or grade == UNEXPLAINED else scope.sentences
    remarks = () if good is None else good.remarks
    head, *rest = (*said, *supposed, *remarks)
    return "; ".join((f"{head}: {rest[0]}" if why and rest else head, *(rest[1:] if why else rest)))


@dataclass(frozen=True, eq=False, repr=False)
class Shared(Value):
    """What channels have in common: correlations of their residuals, as `allanite.shared` gives them.

    Attributes
    ----------
    names : tuple of str
        The channels.
    fast, slow : arrays, shape (channels, channels)
        Correlation of the residuals sample by sample, and of their means over 64 stretches of the record.
    findings : tuple of Finding
        Pairs that share more than chance makes them.
    """

    names: tuple[str, ...]
    fast: FloatArray
    slow: FloatArray
    findings: tuple[Finding, ...]

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: a pair of channels a row."""
        pairs = [(i, j) for i in range(len(self.names)) for j in range(i + 1, len(self.names))]
        rows = [[self.names[i], self.names[j], float(self.fast[i, j]), float(self.slow[i, j])] for i, j in pairs]
        return ["channel", "and", "fast", "slow"], rows
