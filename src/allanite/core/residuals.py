"""Residuals: what a model does not explain of a record; whether it is white, Gaussian and stationary."""

from dataclasses import dataclass
from typing import Any

from allanite.phrases.phrase import Phrase, join, say, spelled

from .arrays import FloatArray
from .fit import REJECTED, Fit, Goodness, chance, tested
from .plain import Value
from .validity import APPROXIMATE, EXPLAINED, UNEXPLAINED, Finding, Scope, worst

MIN_CHECK_P = 1e-3  # p-value of a check below which the model does not explain the record


@dataclass(frozen=True, repr=False)
class Check(Value):
    """One test of the residuals."""

    # `value` is the size of the deviation, `p` its p-value.
    name: str
    title: str
    value: float
    p: float
    meaning: str

    @property
    def passed(self) -> bool:
        """Whether the deviation can be due to chance."""
        return self.p >= MIN_CHECK_P


@dataclass(frozen=True, eq=False, repr=False)
class Residuals(Value):
    """The residuals of a record, as returned by `allanite.residuals`; for the series itself see `allanite.whitened`.

    Attributes
    ----------
    name, rate, size
        Name, sampling rate and size of the record.
    goodness : Goodness or None
        Observed over expected power by cells of frequency, of the fit.
    checks : tuple of Check
        Autocorrelation, tails, and stationarity over halves and eighths; empty if there are too few samples.
    findings : tuple of Finding
        Likely causes, beside what `goodness` says about the spectrum; empty if the model explains the record.
    correlation : array, shape (20,)
        Autocorrelation at lags of 1 to 20 samples.
    level, level_error : arrays, shape (8,)
        RMS of each eighth of the record, and its standard error.
    time, low, high : arrays, shape (about 400,)
        Centres of stretches of the record, s, with the smallest and largest residual in each.
    expected, observed : arrays, shape (about 200,)
        Quantiles of the normal distribution and of the residuals.
    """

    _alike = ("level level_error", "time low high", "expected observed")

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
        """Grade from the residuals alone: a finding makes the model approximate, a fatal finding unexplained."""
        return worst(EXPLAINED, *(UNEXPLAINED if finding.fatal else APPROXIMATE for finding in self.findings))

    @property
    def explained(self) -> bool:
        """Whether the model explains the record, at least approximately."""
        return worst(self.grade, "" if self.goodness is None else self.goodness.grade) != UNEXPLAINED

    @property
    def statement(self) -> "Statement":
        """Whether the model explains the record; the most likely reason comes first."""
        return statement(worst(self.grade, "" if self.goodness is None else self.goodness.grade), None, self)

    @property
    def verdict(self) -> str:
        """The verdict in one sentence."""
        return str(self.statement)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the model does not explain the record: rounding, spectrum, level and tails, the likeliest first."""
        sentences = [(finding.name != "no dither", str(finding)) for finding in self.findings]
        spectral = () if self.goodness is None else self.goodness.reasons
        first = tuple(text for late, text in sentences if not late)
        return tuple(dict.fromkeys((*first, *spectral, *(text for late, text in sentences if late))))

    def __getitem__(self, name: str) -> Check:
        return next(check for check in self.checks if check.name == name)

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: one row per check."""
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
    """How well a model explains a record, as text."""

    grade: str  # one of `GRADES`; empty if the method does not test it
    head: str = ""  # the grade with the p-value of the test: ``explained (goodness of fit p = 0.29)``
    points: tuple[str, ...] = ()  # reasons, assumptions beyond the terms, and other remarks, one sentence each

    def __str__(self) -> str:
        return join("; ", filter(None, (self.head, *self.points)))


def statement(grade: str, fit: Fit | None, left: Residuals | None) -> Statement:
    """How well a model explains a record: the grade, the test, the reasons, the assumptions."""
    if not grade:
        return Statement("")
    good: Goodness | None = getattr(left if fit is None else fit, "goodness", None)
    scope = None if fit is None else fit.scope
    why = left.reasons if left is not None else good.reasons if good is not None else ()
    remarks = () if good is None else good.remarks
    contradicted = (e for e in fit or () if e.status == "not valid" and e.reason != REJECTED)
    wrong = tuple(say("{symbol} is not valid: {reason}", symbol=e.symbol, reason=e.reason) for e in contradicted)
    if grade == UNEXPLAINED:
        findings = (*(() if left is None else left.findings), *(() if fit is None else fit.findings))
        cause = next((finding for finding in findings if finding.fatal), None)
        head, tried = _rejection(good, scope, "" if cause is None else cause.what)
        more = "" if cause is None else join("; ", filter(None, (cause.consequence, cause.remedy)))
        why = tuple(filter(None, (more if cause is not None and text == str(cause) else text for text in why)))
        return Statement(grade, head, (*why, *wrong, *tried, *remarks))
    widened = (say("the intervals allow for the misfit"),) if scope is not None and scope.misfit else ()
    supposed = (*(() if scope is None else scope.sentences), *(() if fit is None else fit.supposed))
    return Statement(grade, tested(grade, scope, good), (*wrong, *widened, *why, *supposed, *remarks))


def _rejection(good: Goodness | None, scope: Scope | None, cause: str) -> tuple[Phrase, tuple[Phrase, ...]]:
    """That the model does not explain the record, and what was tried, or can be."""
    if good is not None and good.grade != UNEXPLAINED:  # a p-value that does not reject the model is omitted
        head = say("not explained: {why}", why=cause) if cause else say("not explained, although the spectrum fits")
        return head, ()
    head = say("not explained: no model of these terms explains the record")
    if good is not None:
        head = say("{said} (goodness of fit {p})", said=head, p=chance(good.p))
    if scope is None or scope.choice != "auto":
        return head, () if scope is None else (try_band(),)
    tried = say("low-pass filters, vibration, steps, a warm-up and power of any other shape were tried beside the "
                "terms; none of them explains the record")  # fmt: skip
    return head, (tried,)


def try_band() -> Phrase:
    """What to try if a band was chosen by hand."""
    option = spelled("--band auto", "band='auto'")
    return say("let the fit detect a filter and choose the band: {option}", option=option)


@dataclass(frozen=True, eq=False, repr=False)
class Shared(Value):
    """Correlations between the residuals of channels, as returned by `allanite.shared`.

    Attributes
    ----------
    names : tuple of str
        The channels.
    fast, slow : arrays, shape (channels, channels)
        Correlation of the residuals sample by sample, and of their means over 64 stretches of the record.
    findings : tuple of Finding
        Pairs with a significant correlation.
    """

    names: tuple[str, ...]
    fast: FloatArray
    slow: FloatArray
    findings: tuple[Finding, ...]

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: one row per pair of channels."""
        pairs = [(i, j) for i in range(len(self.names)) for j in range(i + 1, len(self.names))]
        rows = [[self.names[i], self.names[j], float(self.fast[i, j]), float(self.slow[i, j])] for i, j in pairs]
        return ["channel", "and", "fast", "slow"], rows
