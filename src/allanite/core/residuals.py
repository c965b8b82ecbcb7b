"""Residuals: what a model leaves of a record, whether that is white, Gaussian and steady, and why not."""

from dataclasses import dataclass
from typing import Any

from .arrays import FloatArray
from .finding import Finding
from .fit import REJECTED, Fit, Goodness, chance
from .plain import Value
from .scope import APPROXIMATE, EXPLAINED, UNEXPLAINED, Scope, graded, worst

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
        return worst(self.grade, "" if self.goodness is None else self.goodness.grade) != UNEXPLAINED

    @property
    def statement(self) -> "Statement":
        """Whether the model explains the record; the likeliest reason comes first."""
        return statement(worst(self.grade, "" if self.goodness is None else self.goodness.grade), None, self)

    @property
    def verdict(self) -> str:
        """The same in one sentence."""
        return str(self.statement)

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


@dataclass(frozen=True)
class Statement:
    """How well a model explains a record, in words.

    Attributes
    ----------
    grade : str
        One of `GRADES`; empty where the method does not test it.
    head : str
        The grade with the p value of the test: ``explained (goodness of fit p = 0.29)``.
    points : tuple of str
        Why, what was supposed beside the terms, and what else is known, a sentence each.
    """

    grade: str
    head: str = ""
    points: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "; ".join(filter(None, (self.head, *self.points)))


def statement(grade: str, fit: Fit | None, left: Residuals | None) -> Statement:
    """How well a model explains a record: the grade, the test, the reasons, what was supposed."""
    if not grade:
        return Statement("")
    good = fit.goodness if fit is not None else left.goodness if left is not None else None
    scope = None if fit is None else fit.scope
    test = "" if good is None else f" (goodness of fit {chance(good.p)})"
    why = left.reasons if left is not None else good.reasons if good is not None else ()
    remarks = () if good is None else good.remarks
    told = (e for e in fit or () if e.status == "not valid" and e.reason != REJECTED)
    wrong = tuple(f"{e.symbol} is not valid: {e.reason}" for e in told)
    if grade == UNEXPLAINED:
        if good is not None and good.grade != UNEXPLAINED:  # a p value that rejects nothing is not said
            said = f"{graded(grade)}, although the spectrum fits"
            return Statement(grade, said, (*why, *wrong, *remarks))
        said = f"{graded(grade)}: no model of these terms explains the record{test}"
        return Statement(grade, said, (*why, *wrong, *_tried(scope), *remarks))
    widened = ("the intervals allow for what the model misses",) if scope is not None and scope.misfit else ()
    supposed = () if scope is None else scope.sentences
    return Statement(grade, graded(grade, scope) + test, (*wrong, *widened, *why, *supposed, *remarks))


def _tried(scope: Scope | None) -> tuple[str, ...]:
    """What can still be done about a model that explains nothing."""
    if scope is None:
        return ()
    if scope.choice == "auto":
        return ("low-pass filters, masks and bands of frequencies were tried; none makes these terms explain it",)
    return ("let the fit look for a filter and for the frequencies that the terms explain (--band auto)",)


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
