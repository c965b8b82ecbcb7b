"""Budget: the noise that quantization adds to a rate, stage by stage, compared with the measured noise."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

from allanite.extending import (  # isort: skip
    NO_DITHER, TERMS, Finding, Fit, Noise, Recipe, Record, RecordResult, Signal, UsageError, Value, View,
    coefficient_factor, noise_of, public, rounding, say, say_count, spelled, unit_of)  # fmt: skip

from .stage import Codes, Stage, TorqueScale, ampere_of, codes, converted, demand_in_range, electric, factor_of, gain_of

MATTERS = 0.01  # share of the measured variance below which a stage does not matter


@dataclass(frozen=True, repr=False)
class StageNoise(Value):
    """The noise added by one stage."""

    _also = ("share", "shown")

    stage: Stage
    symbol: str  # type of its noise: white rate noise, or quantization noise of the angle. One of "N", "Q".
    signal: Signal
    step: float  # size of its last bit: rate or angle, SI
    coefficient: float  # step / sqrt(12), for N times the square root of the sample interval; SI
    measured: float | None  # the coefficient identified in the record, SI; None if it is absent
    limit: float | None  # upper limit of the coefficient in the record, if it is absent
    # number of bits at which its share of the measured variance, or of the limit, would be below 1 %
    enough: int | None
    clipped: int  # number of samples at the ends of its range
    codes: Codes | None  # codes of the samples; None if they are not multiples of its step

    @classmethod
    def of(cls, rate: Record, fit: Fit, stage: Stage, per: float, clipped: int) -> Self:
        """The noise of a stage in whose unit is so much rate (angle), SI, against that of the rate."""
        symbol = "Q" if stage.rounds_angle else "N"
        step = stage.step * per
        coefficient = step / math.sqrt(12) * (1.0 if stage.rounds_angle else math.sqrt(rate.interval))
        measured, limit = next(((e.value, e.upper) for e in fit if e.symbol == symbol), (None, None))
        beside = measured if measured is not None else limit
        enough = None
        if beside:
            # each bit halves the coefficient
            enough = max(1, stage.bits + math.floor(math.log2(coefficient / (math.sqrt(MATTERS) * beside))) + 1)
        readings = rate.rate_values * rate.interval / step if stage.rounds_angle else rate.rate_values / step
        limit = limit if measured is None else None
        return cls(stage, symbol, rate.signal, step, coefficient, measured, limit, enough, clipped, codes(readings))

    def findings(self, rate: Record) -> Iterator[Finding]:
        """What must be known of the stage's rounding of a rate: no dither, missing codes, clipped samples."""
        view = View(Record(rate.rate_values, rate.rate, rate.signal.unit, rate.signal.kind))
        worth = self.step * (rate.rate if self.stage.rounds_angle else 1.0)
        # too little fast noise makes the rounding errors on a grid depend on the signal
        quiet = self.codes is not None and (view.fast < NO_DITHER * worth
                                            or rounding(view.steps, view.fast).nearby <= 2)  # fmt: skip
        if quiet:
            yield Finding("no dither", say("the noise of the signal is below {share:g} of the step of {stage}",
                                           share=NO_DITHER, stage=self.stage.name),
                          say("its rounding errors are not a noise: they depend on the signal, and this budget is not "
                              "valid"),
                          say("amplify before it, or add noise"))  # fmt: skip
        if self.codes is not None and self.codes.missing:
            what = say_count(self.codes.missing, "{count} code of {stage} never occurs, although adjacent codes are "
                             "frequent", "{count} codes of {stage} never occur, although adjacent codes are frequent",
                             stage=self.stage.name)  # fmt: skip
            consequence = say("its steps are uneven, and its noise is larger than in the budget")
            yield Finding("missing codes", what, consequence, say("check the converter"))
        if self.clipped:
            what = say_count(self.clipped, "{count} sample is at the ends of {stage}",
                             "{count} samples are at the ends of {stage}", stage=str(self.stage))  # fmt: skip
            yield Finding("clipped", what, say("the noise beyond the range is missing"), say("use a larger range"))

    @property
    def share(self) -> float | None:
        """Share of the measured variance; None if there is none."""
        return None if self.measured is None else (self.coefficient / self.measured) ** 2

    @property
    def matters(self) -> bool | None:
        """Whether that share is 1 % or more."""
        return None if self.share is None else self.share >= MATTERS

    def to(self, value: float | None) -> float | None:
        """A coefficient in its data-sheet unit."""
        return None if value is None else value / coefficient_factor(self.symbol, self.sheet_unit, self.signal)

    @property
    def sheet_unit(self) -> str:
        """Data-sheet unit of the coefficient."""
        return self.signal.sheet[TERMS[self.symbol].power]

    @property
    def shown(self) -> dict[str, Any]:
        """The coefficients in their data-sheet unit."""
        names = ("coefficient", "measured", "limit")
        return {"unit": self.sheet_unit} | {name: self.to(getattr(self, name)) for name in names}


@dataclass(frozen=True, eq=False, repr=False)
class Budget(RecordResult):
    """Quantization noise compared with the noise of a rate record; see `budget`.

    Attributes
    ----------
    record : Record
        The rate.
    noise : Noise
        What was identified of it.
    stages : tuple of StageNoise
        What each adds.
    findings : tuple of Finding
    """

    noise: Noise
    stages: tuple[StageNoise, ...]
    findings: tuple[Finding, ...] = ()

    @property
    def fit(self) -> Fit:
        """The rate noise."""
        return self.noise.fit

    @property
    def alerts(self) -> tuple[str, ...]:
        """What must stand beside the numbers."""
        return (*self.noise.doubts, *(str(finding) for finding in self.findings))


@public
def budget(
    record: Record, stages: Sequence[Stage], *, scale: TorqueScale | float | None = None, sense: float | None = None,
    recipe: Recipe | None = None, clipped: Sequence[int] | None = None,
) -> Budget:  # fmt: skip
    r"""Compute the noise that the quantization of each stage adds to a record.

    Rounding a rate to steps s adds errors that are uniform and, with enough noise before the rounding, independent:
    white rate noise with N = s sqrt(dt / 12), and no quantization noise Q, which is the rounding of an angle:
    Q = s / sqrt(12).

    Parameters
    ----------
    record : Record
        A rate (angle, increments, counts), or a current, a voltage or codes with what makes a rate of them.
    stages : sequence of Stage
        Stages in the order of the signal path; the first one defines the size of codes. A current or a voltage becomes
        a rate without them, too.
    scale : TorqueScale or float, optional
        Scale of the torquer, or rad/s per A; required for currents.
    sense : float, optional
        Gain of the current sensor, V per A; required for voltages.
    recipe : Recipe, optional
        How the rate noise is identified.
    clipped : sequence of int, optional
        Samples at the ends of each stage, where the record does not show them because it combines others.

    Returns
    -------
    Budget

    Raises
    ------
    UsageError
        A constant is missing or not positive.
    DataError
        More than 0.1 % of the samples are clipped, or the record cannot support the identification.

    References
    ----------
    W. R. Bennett, Bell Syst. Tech. J. 27 (1948) 446; B. Widrow, I. Kollar, Quantization Noise (Cambridge 2008).

    Examples
    --------
    >>> import allanite as al
    >>> noise = al.simulate(al.N(2.525648, "deg/sqrt(h)"), 20_000, 1000.0, rng=np.random.default_rng(1))
    >>> found = budget(noise, [Stage("output", 12, 500.0, "deg/s")])
    >>> [round(found.stages[0].to(found.stages[0].coefficient), 3), found.stages[0].matters]
    [0.134, False]
    """
    if not stages and record.signal.inertial:
        raise UsageError("name at least one stage, for example " + spelled("--stage 'ADC 12 5V'",
                                                                           "Stage('ADC', 12, 5.0, 'V')"))  # fmt: skip
    counts = [demand_in_range(record, stage) for stage in stages] if clipped is None else clipped
    rate, needs = record, spelled("--torquer or --torque-scale", "scale=...")
    if not record.signal.inertial:
        if scale is None:
            raise UsageError(f"{record.name!r} is in {record.unit!r}: give its relation to a rate, by the torquer's "
                             f"constants or scale factor ({needs})")  # fmt: skip
        ampere = ampere_of(record, sense, next(iter(stages), None))
        rate = converted(record, factor_of(scale), ampere, next(iter(counts), 0))
    noise = noise_of(rate, recipe or Recipe())
    rows = []
    for stage, count in zip(stages, counts, strict=True):
        per = unit_of(stage.unit).factor  # SI rate (angle) per unit of the stage
        if electric(stage.unit):
            if scale is None:
                raise UsageError(f"the stage {stage.name!r} is in {stage.unit}: its rate needs the torquer's scale "
                                 f"({needs})")  # fmt: skip
            per *= factor_of(scale) / gain_of(stage.unit, sense)
        rows.append(StageNoise.of(rate, noise.fit, stage, per, count))
    return Budget(rate, noise, tuple(rows), tuple(f for row in rows for f in row.findings(rate)))
