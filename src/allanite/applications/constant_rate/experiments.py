"""How the errors of every method scatter over the intervals of a record."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from allanite.extending import Finding, FloatArray, Signal, Value, join, plain, say, spelled

from .estimates import rate_factor, sheet_unit
from .predict import MAX_LOSS, Ranking

DRIFT = 3.0
"""Standard deviations by which neighbours must be more alike than independent intervals to be called a drift."""


class Scatter(NamedTuple):
    """How the rates of one method scatter over the intervals, SI."""

    # `low`, `high` are limits of `deviation` (chi-square); `neighbours` is the deviation from differences of
    # neighbouring intervals, which a slow drift does not reach; `bound` is three deviations; `worst` the largest error;
    # `total` the root mean square of the errors, NaN where the true rate is not known.
    method: str
    mean: float
    deviation: float
    low: float
    high: float
    neighbours: float
    bound: float
    worst: float
    predicted: float
    total: float


class Standing(NamedTuple):
    """A method beside that of least scatter."""

    # `half` bounds the error of one interval, SI; `ratio` is the scatter over the least, NaN where it is not compared
    method: str
    half: float
    ratio: float
    low: float
    high: float
    verdict: str


def ratio_of(a: FloatArray, b: FloatArray, t: float) -> tuple[float, float, float]:
    """Standard deviation of one series over that of another, with limits at a value of Student's t.

    Sums and differences of the two standardized series are uncorrelated where the ratio is right, so that the
    correlation of the two, which is high, narrows the limits.

    References
    ----------
    E. J. G. Pitman, Biometrika 31 (1939) 9; W. A. Morgan, ibid. 13.
    """
    value, correlation = float(a.std() / b.std()), float(np.corrcoef(a, b)[0, 1])
    c = 1 + 2 * (1 - correlation**2) * t**2 / (a.size - 2)
    narrow = math.sqrt(max(c - math.sqrt(max(c**2 - 1, 0.0)), 0.0))
    return value, value * narrow, value / narrow if narrow > 0 else math.inf


@dataclass(frozen=True, eq=False, repr=False)
class Experiment(Value):
    """Rates of all methods over the intervals of a record, SI.

    Attributes
    ----------
    name : str
        Channel.
    signal : Signal
    methods : tuple of str
    start : array, shape (k,)
        Start of each interval, s after the record's first sample.
    duration, rate : float
        Length of an interval, s; sampling rate, Hz.
    rates : array, shape (methods, k)
    reference : float
        The reference of the errors: the known rate, or the mean of the intervals by the last method.
    known : bool
        Whether the reference was given.
    predicted : array, shape (methods,)
        Standard errors under the model; NaN without one.
    ranking : Ranking or None
        Ranking of the methods under the model.
    left_out : dict
        Method -> why it could not be used.
    notes, findings
        What was omitted from the record; findings to report with the results.
    positions : int
        2 if the rates are half the differences of two positions.
    """

    _keys: ClassVar[dict[str, str]] = {"methods": "names", "known": "reference_known"}
    _also: ClassVar[tuple[str, ...]] = ("unit", "drift", "verdict")

    name: str
    signal: Signal
    methods: tuple[str, ...]
    start: FloatArray
    duration: float
    rate: float
    rates: FloatArray
    reference: float
    known: bool
    predicted: FloatArray
    ranking: Ranking | None = None
    left_out: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    positions: int = 1

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.signal.unit

    @property
    def errors(self) -> FloatArray:
        """Rates less the reference, shape (methods, k)."""
        return self.rates - self.reference

    def scatter(self, method: str, level: float = 0.68) -> Scatter:
        """How the rates of a method scatter."""
        row = self.methods.index(method)
        errors = self.errors[row]
        k = errors.size
        deviation = float(errors.std(ddof=1)) if k > 1 else math.nan
        low = high = neighbours = math.nan
        if k > 1:
            from scipy.special import gammaincinv

            tails = ((1 + level) / 2, (1 - level) / 2)
            low, high = (deviation * math.sqrt((k - 1) / (2 * float(gammaincinv((k - 1) / 2, p)))) for p in tails)
            neighbours = math.sqrt(float(np.square(np.diff(errors)).mean()) / 2)
        worst, predicted = float(errors[np.abs(errors).argmax()]), float(self.predicted[row])
        total = math.sqrt(float(np.square(errors).mean())) if self.known else math.nan
        return Scatter(method, float(errors.mean()), deviation, low, high, neighbours, 3 * deviation, worst, predicted,
                       total)  # fmt: skip

    def half_width(self, method: str, level: float = 0.95, *, of: int = 1) -> float:
        """Half width of the error of one interval by Student's t; `of` several methods at once by Bonferroni; SI."""
        from scipy.special import stdtrit

        degrees = self.start.size - 1
        t = float(stdtrit(degrees, 1 - (1 - level) / 2 / of)) if degrees else math.nan
        return t * self.scatter(method).deviation

    def standings(self, level: float = 0.95) -> tuple[Standing, ...]:
        """Every method beside the one that scatters least, which is chosen by the same data.

        With probability `level` the best of the m methods is not called worse: for it to be, one of the m - 1 ratios
        of another's scatter to its own must lie beyond its limit, each by chance (1 - level) / (m - 1). Half widths
        are those of all methods at once. Both suppose independent intervals.

        References
        ----------
        J. C. Hsu, Annals of Statistics 9 (1981) 1026: multiple comparisons with the best.
        """
        from scipy.special import stdtrit

        k, count, least = self.start.size, len(self.methods), int(self.rates.std(axis=1).argmin())
        t = float(stdtrit(k - 2, 1 - (1 - level) / max(count - 1, 2))) if k > 2 else math.nan
        best, standings = self.rates[least], []
        own = (1.0, 1.0, 1.0) if count > 1 and t > 0 and best.std() > 0 else (math.nan,) * 3
        for i, method in enumerate(self.methods):
            ratio, low, high = own if i == least or math.isnan(own[0]) else ratio_of(self.rates[i], best, t)
            word = say("as good") if high <= 1 + MAX_LOSS else say("worse") if low > 1 else say("undecided")
            verdict = "" if math.isnan(ratio) else say("least scatter") if i == least else word
            standings.append(Standing(method, self.half_width(method, level, of=count), ratio, low, high, verdict))
        return tuple(standings)

    @property
    def chosen(self) -> str:
        """The first method that scatters as little as any in these intervals, within `MAX_LOSS`; empty if unknown."""
        return next((s.method for s in self.standings() if s.ratio <= 1 + MAX_LOSS), "")

    @property
    def verdict(self) -> str:
        """Which method the scatter of the intervals speaks for, and how certain that is, in a sentence."""
        standings = self.standings()
        if len(standings) < 2:
            return ""
        if self.start.size < 3:
            shorter = f"{self.duration * self.start.size / 10 / self.positions:.3g}"
            return say("too few intervals to compare methods: give shorter ones ({option})",
                       option=spelled(f"--interval {shorter}", f"interval={shorter}"))  # fmt: skip
        if not self.chosen:
            return say("every interval gives the same rate: no scatter by which to compare methods")
        parts = [say("use {method}: in {count} intervals no other scatters less by more than {percent:g} %",
                     method=self.chosen, count=self.start.size, percent=100 * MAX_LOSS)]  # fmt: skip
        beaten = min((s for s in standings if s.low > 1 and s.high > 1 + MAX_LOSS), key=lambda s: s.ratio, default=None)
        if beaten is not None:
            parts.append(say("{method} scatters {ratio:.3g} times as much, at least {low:.3g} times",
                             method=beaten.method, ratio=beaten.ratio, low=beaten.low))  # fmt: skip
        least = min(standings, key=lambda s: s.ratio).method
        unsure = [s.method for s in standings if s.low <= 1 and s.high > 1 + MAX_LOSS]
        rivals = [least if method == self.chosen else method for method in unsure]
        if rivals:
            parts.append(say("not certain against {methods}", methods=", ".join(rivals)))
        return join("; ", parts)

    def reversed_by(self, second: "Experiment") -> "Experiment":
        """Half the differences of the intervals of two positions, in their order: the rate without a common bias."""
        k = min(self.start.size, second.start.size)
        rates = (self.rates[:, :k] - second.rates[:, :k]) / 2
        reference = self.reference if self.known else float(rates[-1].mean())
        return replace(self, start=self.start[:k], duration=2 * self.duration, rates=rates, reference=reference,
                       predicted=self.predicted / math.sqrt(2), notes=(), positions=2)  # fmt: skip

    @property
    def drift(self) -> str:
        """Drift of the rates over the record, as text; empty if there is none.

        By von Neumann's ratio of the mean square difference of neighbours to the variance, for the method with the
        least scatter.
        """
        k = self.start.size
        if k < 8:
            return ""
        errors = self.errors[int(self.errors.std(axis=1).argmin())]
        variance = float(errors.var())
        if not variance > 0:
            return ""
        ratio = float(np.square(np.diff(errors)).mean()) / (2 * variance) * (k - 1) / k
        if (1 - ratio) < DRIFT * math.sqrt((k - 2) / (k**2 - 1)):
            return ""
        part, (unit, factor) = max(1, k // 10), sheet_unit(self.signal)
        change = float(errors[part:].mean() - errors[:part].mean()) / factor
        return say("the rate drifts: adjacent intervals are more alike than independent ones (ratio {ratio:.2f}, not "
                   "1); the first {part} of {intervals} differ by {change:+.2g} {unit} from the rest", ratio=ratio,
                   part=part, intervals=k, change=-change, unit=unit)  # fmt: skip

    def scatters(self, unit: str | None = None, level: float = 0.68) -> list[Scatter]:
        """How the rates of every method scatter, in `unit`."""
        factor = rate_factor(unit or self.signal.sheet[0], self.signal)
        in_si = (self.scatter(method, level) for method in self.methods)
        return [Scatter(s.method, *(v / factor for v in s[1:])) for s in in_si]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI."""
        rates = dict(zip(self.methods, self.rates.tolist(), strict=True))
        methods = [{**self.scatter(method)._asdict(), "rates": rates[method]} for method in self.methods]
        standings = [standing._asdict() for standing in self.standings(level)]
        return super().to_dict(level) | {"methods": plain(methods), "standings": plain(standings)}

    def _summary(self) -> str:
        return f"{self.name} {self.start.size} intervals of {self.duration:g} s: {', '.join(self.methods)}"
