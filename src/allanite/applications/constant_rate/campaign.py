"""From a recording to its rates: the noise that their errors follow from, experiment, bias, north."""

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from allanite.applications.choices import RateChoices

from allanite.extending import (  # isort: skip
    SHORTEST, TERMS, ChannelResult, DataError, Finding, Fit, Inspected, Job, Model, Noise, Progress, Recipe, Record,
    Signal, Source, Term, UsageError, Value, automatic, block_means, described, join, noise_of, open_recording, public,
    run_together, say, say_count, spelled, unit_of, written)  # fmt: skip

from .earth import North, earth_rate, north
from .estimates import RateEstimate, reversal, subtract_bias
from .experiments import Experiment
from .predict import rank
from .run import ExperimentSettings, by_duration, estimate, experiment, fits

BLOCKS = (1.0, 0.4, 0.2, 0.1)
"""Lengths of blocks, s, whose noise is identified if no model explains the full rate; the first success is used."""

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
                note = say_count(m, "the noise was identified from blocks of {count} sample ({length:.3g} s), which "
                                 "the model explains; at the full rate: {statement}",
                                 "the noise was identified from blocks of {count} samples ({length:.3g} s), which the "
                                 "model explains; at the full rate: {statement}", length=m / record.rate,
                                 statement=join("; ", (noise.statement.head, *noise.statement.points[:1])))  # fmt: skip
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


DURATIONS = (1.0, 3.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)  # measuring times that are compared, s
MIN_INTERVALS = 20  # intervals of a measuring time below which its scatter says little


@described
@dataclass(frozen=True, repr=False)
class RateSettings(RateChoices, Value):
    """What is measured of a recording; with a latitude the earth's rate is the reference, or north is found.

    Attributes
    ----------
    experiment : ExperimentSettings
        Intervals, methods, target; its `reference` is overruled by `latitude`.
    signal : Signal or None
        The kind of sensor that `reference` and `bias` are of, if they are given.
    latitude : float or None
        Degrees. For a vertical axis the earth's rate is the reference, for a horizontal one north is found.
    position_method : str
        Estimator of the whole record, for north and the bias.
    """

    experiment: ExperimentSettings = field(default_factory=ExperimentSettings)
    noise: Model | None = None
    signal: Signal | None = None
    durations: tuple[float, ...] = DURATIONS

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.horizontal and self.latitude is None:
            raise UsageError(f"finding north needs the latitude: give {spelled('--latitude', 'latitude=...')}")

    @property
    def vertical(self) -> bool:
        """Whether the earth's rate at the latitude is the true rate."""
        return self.latitude is not None and not self.horizontal

    def experiment_on(self, record: Record) -> ExperimentSettings:
        """The settings of the experiment on a record, whose reference may be the earth's rate."""
        if self.signal is not None and self.signal is not record.signal:
            raise DataError(say("the given true rate or bias belongs to another type of sensor: {sensor}",
                                sensor=self.signal.name))  # fmt: skip
        interval = self.experiment.interval
        if interval > record.duration and interval != ExperimentSettings.interval:
            too_long = f"the interval of {interval:g} s is longer than the record of {record.duration:g} s"
            shorter = f"{record.duration / 10:.3g}"
            option = spelled(f"--interval {shorter}", f"interval={shorter}")
            raise UsageError(f"{too_long}; give a shorter one, as {option}", cure=(f"{interval:g}", shorter))
        if self.latitude is None or self.horizontal or record.signal.name != "gyro":
            return self.experiment
        return replace(self.experiment, reference=earth_rate(self.latitude))

    def north(self, rate: RateEstimate, second: RateEstimate | None, level: float) -> North | None:
        """North, from the rates of one or two positions of a horizontal axis; None of a vertical one."""
        if not self.horizontal or self.latitude is None:
            return None
        return north(rate, self.latitude, second=second, turned=self.turned, near=self.near, level=level)

    def choices(self, unit: str) -> dict[str, Any]:
        """The choices under the names of the command line; rates in the SI unit `unit`."""
        chosen, options = self.experiment, self.experiment.options
        plain = {**vars(self), **vars(chosen), **vars(options), "bias": chosen.bias or None}
        plain["reference"] = None if self.vertical else chosen.reference
        plain["noise"] = None if self.noise is None else written(self.noise)
        for key in ("reference", "bias", "allowed"):
            plain[key] = None if plain[key] is None else f"{float(plain[key])!r} {unit}"
        for key in ("methods", "dither", "durations"):
            plain[key] = list(plain[key]) or None
        plain |= {"split_gaps": chosen.gaps == "split", "no_times": not self.durations}
        inner = ("experiment", "options", "signal", "gaps")
        return {k: v for k, v in plain.items() if k not in inner and v is not None}


@dataclass(frozen=True, eq=False, repr=False)
class RateChannel(ChannelResult):
    """The measurement of one channel; `refusal` says why there is none."""

    experiment: Experiment | None = None
    by_duration: tuple[Experiment, ...] = ()
    estimates: tuple[RateEstimate, ...] = ()
    bias: RateEstimate | None = None
    north: North | None = None
    by_reversal: Experiment | None = None
    whole: RateEstimate | None = None
    alerts: tuple[str, ...] = ()

    @property
    def certain(self) -> tuple[RateEstimate, ...]:
        """The estimates whose limits hold with certainty: those of counts without noise."""
        return tuple(e for e in self.estimates if e.limits is not None)

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings about the data that matter to the rate."""
        return tuple(finding for finding in self.quality.warnings if str(finding) in self.alerts)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, of the noise with its curve."""
        return super().to_dict(level) | {"fit": None if self.fit is None else self.fit.to_dict(level)}

    def _summary(self) -> str:
        return f"{self.record.name!r}: {self.refusal or self.experiment}"


@dataclass(frozen=True, eq=False, repr=False)
class RateStudy(Job[RateChannel]):
    """The rates of a recording, and the settings that they were measured with."""

    _channel = RateChannel

    settings: RateSettings = field(default_factory=RateSettings)

    def _explained(self, channel: RateChannel) -> bool:
        """Whether a model explains the noise of a channel, if none was given."""
        return self.settings.noise is not None or (channel.noise is not None and channel.noise.explained)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        signal = self.settings.signal or self.channels[0].record.signal
        second = self.provenance.get("source 2")
        return super().choices() | self.settings.choices(signal.unit) | ({"second": second} if second else {})


@public
def measure_rates(
    source: Source, recipe: Recipe | None = None, settings: RateSettings | None = None, *, second: Source | None = None,
    progress: Progress | None = None, **choices: Any,
) -> RateStudy:  # fmt: skip
    """Measure the constant rate of every channel of a recording with every method.

    Parameters
    ----------
    source : Recording, Record, path, table or array
    recipe : Recipe, optional
        How to read, how the noise is identified, the level of intervals.
    settings : RateSettings, optional
    second : Recording, Record or path, optional
        The same gyro after it was turned; read with the same recipe. Removes the bias.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.
    **choices
        Fields of `Recipe`: ``measure_rates(x, rate=400, unit="deg/h")``.

    Raises
    ------
    DataError
        No channel can be measured.
    UsageError
        An option is wrong, or a required one is missing.
    """
    recipe, settings = (recipe or Recipe()).but(choices), settings or RateSettings()
    recordings = [open_recording(s, recipe, progress=progress) for s in (source, second) if s is not None]
    kind, work = partial(RateStudy, settings=settings), partial(_measured, recipe=recipe, settings=settings)
    return run_together(kind, recordings, recipe, work, RateChannel.refused, doing="measuring", progress=progress)


def _measured(seen: Inspected, recipe: Recipe, settings: RateSettings) -> RateChannel:
    record, chosen = seen.record, settings.experiment_on(seen.record)
    noise, model, alerts, settled, source = noise_of_rates(record, recipe, chosen.interval, settings.noise)

    measured = experiment(record, model, chosen)
    measured = replace(measured, notes=(*source, *measured.notes))
    asked = settings.durations != DURATIONS
    durations = tuple(d for d in settings.durations if asked or d * MIN_INTERVALS <= record.duration)
    short = [d for d in durations if asked and not fits(record, d)]
    methods = measured.methods[: None if measured.start.size == 1 else 1] if np.isfinite(record.values).all() else ()
    wholes = tuple(_whole(record, method, model, chosen) for method in methods)
    estimates = wholes if measured.start.size == 1 else ()
    if any(e.limits is not None for e in estimates):  # an ideal staircase has no noise that could be identified
        noise, alerts, settled = None, (), (*settled, "short")
    heading = bias = turned = None
    if len(seen.records) > 1 or settings.horizontal:
        method = settings.position_method if model is not None else "mean"
        first, *rest = (_whole(position, method, model, settings.experiment) for position in seen.records)
        second = rest[0] if rest else None
        heading = settings.north(first, second, recipe.level)
        if second is None or settings.turned != 180:
            estimates = estimates or (first,)
        else:
            rate, bias = reversal(first, second)
            estimates = (rate,)
            other = experiment(seen.records[1], model, chosen)
            alike = (other.methods, other.duration) == (measured.methods, measured.duration)
            turned = measured.reversed_by(other) if alike else None
    warned = (say("second recording: {finding}", finding=str(f)) if i else str(f)
              for i, quality in enumerate(seen.qualities)
              for f in quality.warnings if f.name not in settled)  # fmt: skip
    unfit = (say("{time:g} s is not measured: it needs three samples, and has to fit into {length:g} s",
                 time=d, length=record.duration) for d in short)  # fmt: skip
    return RateChannel(record, seen.quality, noise, experiment=measured,
                       by_duration=by_duration(record, durations, model, chosen), estimates=estimates,
                       bias=bias, north=heading, by_reversal=turned, whole=next(iter(wholes), None),
                       alerts=(*alerts, *map(str, measured.findings), *unfit, *warned))  # fmt: skip


def _whole(record: Record, method: str, model: Model | None, chosen: ExperimentSettings) -> RateEstimate:
    rate = estimate(record, method, model=model, target=chosen.target, dither=chosen.dither, options=chosen.options)
    return subtract_bias(rate, chosen.bias, record.signal.unit) if chosen.bias else rate
