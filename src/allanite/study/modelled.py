"""What follows from the noise of every channel, or from a given model: plans, checks, state spaces."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np

from allanite.core.aliases import size_and_rate
from allanite.core.choices import described
from allanite.core.curve import Curve
from allanite.core.encoding import read_key, read_plain
from allanite.core.errors import DataError, UsageError, unfit
from allanite.core.fit import Fit
from allanite.core.model import Model
from allanite.core.plain import Header, Value, read_fields, stored_fields
from allanite.core.record import Record
from allanite.core.syntax import split_quantities
from allanite.core.units import convert
from allanite.core.validity import Quality
from allanite.phrases.phrase import join, say, spelled
from allanite.planning.datasheets import claimed, sensor as typical
from allanite.planning.plan import DURATIONS, RecordingPlan, plan
from allanite.planning.selfcheck import SelfCheck, selfcheck
from allanite.statespace import StateSpace, state_space
from allanite.statistics import deviation

from .channels import Inspected, Progress, Source, run
from .job import Job, provenance_of
from .noise import begun_in, noise_in
from .recipe import IDENTIFYING, READING, SELECTING, Recipe, chosen
from .results import Noise, noise_dict, noise_from
from .settings import CheckChoices, NoiseChoices, PlanChoices, StateSpaceChoices


def ways() -> str:
    """The choices that give a noise without a recording."""
    return spelled("--model, --sensor or --datasheet", "model, sensor or datasheet")


@described
@dataclass(frozen=True, repr=False)
class NoiseSettings(NoiseChoices, Value):
    """The source of the noise if there is no recording."""

    identifies: ClassVar[bool] = False
    """Whether the options of the identification also apply to a given model."""

    def given(self) -> Model | None:
        """The given model, or that of the sensor or of the data sheet; None if there is none of them."""
        makers = ((self.model, Model), (self.sensor, typical), (self.datasheet, lambda text: claimed(text)[0]))
        given = [(text, make) for text, make in makers if text is not None]
        if len(given) > 1:
            raise UsageError(f"the noise is given twice: use only one of {ways()}")
        return given[0][1](given[0][0]) if given else None

    def instead_of(self, source: object) -> Model | None:
        """The given model; None if there is a `source` in its place."""
        model = self.given()
        if (model is None) == (source is None):
            raise UsageError(f"give either a recording, or the noise with {ways()}")
        return model

    @property
    def name(self) -> str:
        """What the given model is called."""
        return self.sensor or self.datasheet or ""

    def counting(self, *, recorded: bool) -> tuple[str, ...]:
        """The keys of a recipe that apply, for a recording or a given model."""
        if recorded:
            return (*READING, *SELECTING, *IDENTIFYING)
        return ("rate", *(IDENTIFYING if self.identifies else ()))


@described
@dataclass(frozen=True, repr=False)
class PlanSettings(PlanChoices, NoiseSettings):
    """Choices of a plan: `durations` in s, `accuracy` as a share, `ramp` as for `plan`."""

    durations: tuple[float, ...] = DURATIONS


@described
@dataclass(frozen=True, repr=False)
class SelfCheckSettings(CheckChoices, NoiseSettings):
    """Choices of a check; limits as shares, see `SelfCheck.exceeded`."""

    identifies: ClassVar[bool] = True

    @property
    def limits(self) -> dict[str, float]:
        """The given limits, as shares, by the names used by `SelfCheck.exceeded`."""
        keys = {"bias": "max_bias", "coverage": "min_coverage", "false": "max_false", "missed": "max_missed"}
        return {name: getattr(self, key) for name, key in keys.items() if getattr(self, key) is not None}


@described
@dataclass(frozen=True, repr=False)
class StateSpaceSettings(StateSpaceChoices, NoiseSettings):
    """Choices of a state space: `ripple` as a share, `turn_on` with its unit, others as for `state_space`."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.tau) != 2:
            raise UsageError(f"expected two averaging times, e.g. 1,1000 or '1 s,1 h', not {self.tau!r}")

    def bias(self, si: str) -> float:
        """The turn-on bias in the unit `si`."""
        if self.turn_on is None:
            return 0.0
        quantities = split_quantities(self.turn_on.split())
        if len(quantities) != 1 or not quantities[0][1]:
            raise UsageError(f"a bias has the form '3 deg/h', not {self.turn_on!r}")
        return convert(*quantities[0], si)


Use = PlanSettings | SelfCheckSettings | StateSpaceSettings  # what a noise model is used for

Random = np.random.Generator
Result = RecordingPlan | SelfCheck | StateSpace


@dataclass(frozen=True)
class Supposed:
    """A noise, and the sampling rate and length of its record; no length for a given model."""

    model: Model
    rate: float
    name: str = ""
    size: int | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Modelled(Value):
    """What follows from the noise of one channel, or the reason (`refusal`) why there is no result."""

    name: str
    rate: float
    record: Record | Header | None = None  # as quality and noise: None for a given model
    quality: Quality | None = None
    noise: Noise | None = None
    result: Result | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def fit(self) -> Fit | None:
        """The identified noise."""
        return None if self.noise is None else self.noise.fit

    @property
    def missing(self) -> str:
        """Terms that were looked for and not identified, with their limits: the result does not include them."""
        absent = (e for e in self.fit or () if e.value is None
                  and (e.upper is not None or e.status == "not observable"))  # fmt: skip
        return join(", ", (say("{symbol} {words}", symbol=e.symbol, words=e.words()) for e in absent))

    @cached_property
    def curve(self) -> Curve | None:
        """The measured Allan deviation."""
        if self.noise is None or not isinstance(self.record, Record):
            return None
        return deviation(self.record, "oadev", taus="log", noise=self.noise.fit)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data: the name, the result, and the noise from which it follows."""
        own: dict[str, Any] = {"rate": self.rate} if self.result is None else self.result.to_dict()
        return {"name": self.name, **own, "record": self.record and self.record.to_dict(level),
                "quality": self.quality and self.quality.to_dict(level), **noise_dict(self.noise, level),
                "alerts": list(self.alerts), "refusal": self.refusal}  # fmt: skip

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Modelled":
        """The value written by `to_dict`, whose type is that of the result; the record has no samples."""
        if not isinstance(data, dict):
            raise unfit(data, "a table")
        stored = read_fields(cls, data, "record", "noise", "result")
        record = read_key(data, "record", Header | None)
        result = read_plain(data, dict(stored_fields(cls))["result"]) if "type" in data else None
        return cls(**stored, record=record, noise=noise_from(data), result=result)


@dataclass(frozen=True, eq=False, repr=False)
class ModelJob(Job[Modelled]):
    """What follows from each noise, and the settings; `channels` has one item for a given model."""

    _channel: ClassVar = Modelled

    settings: Use = field(default_factory=PlanSettings)

    def _summary(self) -> str:
        return ", ".join(channel.name or "model" for channel in self.channels)

    @property
    def exceeded(self) -> list[str]:
        """Which limits of the settings are significantly exceeded, in sentences; only a check has limits."""
        return []

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        recorded = any(channel.record is not None for channel in self.channels)
        return self.recipe.to_dict(self.settings.counting(recorded=recorded)) | chosen(self.settings)


class RecordingPlans(ModelJob):
    """How long to record each channel."""


class SelfChecks(ModelJob):
    """Results of the identification on simulated records with each channel's noise."""

    @property
    def exceeded(self) -> list[str]:
        """Which limits of the settings are significantly exceeded, in sentences."""
        limits = self.settings.limits if isinstance(self.settings, SelfCheckSettings) else {}
        checks = [(c.name, c.result) for c in self.channels if isinstance(c.result, SelfCheck)]
        return [f"{name} {what}".strip() for name, check in checks for what in check.exceeded(**limits)]


class StateSpaces(ModelJob):
    """A state space of each channel's noise."""


def _plan(settings: PlanSettings, _: Random, noise: Supposed, __: Recipe, ___: Progress) -> RecordingPlan:
    return plan(noise.model, noise.rate, durations=settings.durations, accuracy=settings.accuracy, ramp=settings.ramp)


def _check(settings: SelfCheckSettings, rng: Random, noise: Supposed, recipe: Recipe, tell: Progress) -> SelfCheck:
    n = noise.size
    if n is None or settings.duration is not None or settings.samples is not None:
        n, _ = size_and_rate(settings.samples, noise.rate, settings.duration)
    return selfcheck(noise.model, n, noise.rate, records=settings.records, rng=rng, terms=recipe.terms,
                     method=recipe.method, band=recipe.band, level=recipe.level, progress=tell)  # fmt: skip


def _space(settings: StateSpaceSettings, _: Random, noise: Supposed, __: Recipe, ___: Progress) -> StateSpace:
    bias = settings.bias(noise.model.signal.unit)
    if noise.size is not None and not bias and all(t.symbol == "N" for t in noise.model):
        raise DataError(say("only white noise was identified, which belongs to the measurement: a filter needs no "
                            "states for it"))  # fmt: skip
    low, high = settings.tau
    return state_space(noise.model, noise.rate, tau=(low, high), ripple=settings.ripple, order=settings.order,
                       turn_on=bias, measurement=settings.measurement)  # fmt: skip


KINDS: dict[type[NoiseSettings], tuple[type[ModelJob], Callable[..., Result]]] = {
    PlanSettings: (RecordingPlans, _plan), SelfCheckSettings: (SelfChecks, _check),
    StateSpaceSettings: (StateSpaces, _space),
}  # fmt: skip
"""The type of result for these settings, and the function applied to each noise."""


def run_model_job(source: Source | None, settings: Use, recipe: Recipe | None = None, *,
                  progress: Progress | None = None) -> ModelJob:  # fmt: skip
    """What follows from the noise of each channel of a recording, or from the model that the settings give."""
    recipe, given = recipe or Recipe(), settings.instead_of(source)
    job, make = KINDS[type(settings)]
    rng = np.random.default_rng(settings.seed if isinstance(settings, SelfCheckSettings) else None)
    kind, work = partial(job, settings=settings), partial(make, settings, rng)
    tell = progress or (lambda what, fraction: None)
    if given is not None:
        demand_no_recording(settings, recipe)
        if recipe.rate is None:
            raise UsageError(f"a model needs a sampling rate above 0: {spelled('--rate HZ', 'rate=...')}")
        noise = Supposed(given, recipe.rate, settings.name)
        made = Modelled(noise.name, noise.rate, result=work(noise, recipe, tell))
        return kind((made,), recipe, (), (), provenance_of())
    assert source is not None  # noqa: S101 - one of them is there

    def follow(seen: Inspected) -> Modelled:
        record, noise = seen.record, noise_in(seen, recipe)
        wrong = [e for e in noise.fit if e.status == "not valid"] if noise.explained else []
        missing = (say("{symbol} is left out of the model because its coefficient is not valid: {reason}",
                       symbol=e.symbol, reason=e.reason) for e in wrong)  # fmt: skip
        alerts = (*noise.doubts, *missing, *seen.alerts)
        made = partial(Modelled, record.name, record.rate, record, seen.quality, noise, alerts=alerts)
        try:
            model = noise.usable(unexplained=settings.unexplained)
            supposed = Supposed(model, record.rate, record.name, record.size)
            return made(work(supposed, recipe, lambda what, share: tell(f"{record.name} {what}".strip(), share)))
        except DataError as error:
            return made(refusal=str(error))

    return run(kind, source, recipe,
               follow, lambda seen, why: Modelled(seen.name, seen.record.rate, seen.record, seen.quality, refusal=why),
               begin=partial(begun_in, recipe=recipe), progress=progress)  # fmt: skip


def demand_no_recording(settings: NoiseSettings, recipe: Recipe) -> None:
    """Refuse options of a recording beside a given model."""
    usual, counting = Recipe(), settings.counting(recorded=False)
    for key in (*READING, *SELECTING, *IDENTIFYING):
        if key not in counting and getattr(recipe, key) != getattr(usual, key):
            option = spelled(f"--{'from' if key == 'start' else key.replace('_', '-')}", key)
            raise UsageError(f"{option} applies to a recording, but the noise is given by {ways()}; omit it")
