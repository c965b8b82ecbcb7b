"""Curves, spectra or surfaces of every channel, of several files as one, and as expected of a given model."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar

from allanite.core.aliases import size_and_rate
from allanite.core.choices import described
from allanite.core.curve import Curve, Surface
from allanite.core.display_units import readable_unit
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.names import told_apart
from allanite.core.plain import Value
from allanite.core.record import Record
from allanite.core.spectrum import Spectrum, side_factor
from allanite.parallel.processors import how_many
from allanite.phrases.phrase import join, say, spelled
from allanite.statistics import Expectation, Expectations, deviation, expectation, statistic_named
from allanite.statistics.confidence.bias import demand_bias
from allanite.statistics.confidence.supposed import Supposing
from allanite.statistics.dynamic import dynamic
from allanite.statistics.spectra.estimators import MAX_SEGMENT
from allanite.statistics.spectra.spectrum import deviation_of_spectrum, method_named, of_raw, spectrum

from .channels import Inspected, Progress, Source, run
from .curves import joints
from .job import Job, joined
from .keeper import STRIDES, WHOLE, Keeper, demand_grid, demand_sums
from .modelled import NoiseSettings, demand_no_recording
from .noise import begun_in, noise_in
from .recipe import IDENTIFYING, READING, SELECTING, Recipe, chosen
from .results import ChannelResult
from .settings import DensityChoices, DeviationChoices, LengthChoices, WindowChoices

Result = Curve | Spectrum | Surface


@described
@dataclass(frozen=True, repr=False)
class Deviations(DeviationChoices, Value):
    """Statistics over averaging time; of `bias`, those statistics take it that have this correction."""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "statistic", tuple(statistic_named(name).name for name in self.statistic))
        if not self.statistic:
            raise UsageError("give at least one statistic")
        if not any(self._biases(name) for name in self.statistic):
            demand_bias(self.bias, statistic_named(self.statistic[0]))
        if self.edf == "published" and not self.intervals:
            raise UsageError("published degrees of freedom are those of the intervals: they need intervals")

    @property
    def fitted(self) -> bool:
        """The intervals, or the bias correction, assume a noise."""
        return self.intervals or self.bias in ("exact", "model")

    def _biases(self, name: str) -> bool:
        """Whether a statistic takes the bias correction."""
        try:
            demand_bias(self.bias, statistic_named(name))
        except UsageError:
            return False
        return True

    def measure(self, record: Record, fit: Fit | None) -> Iterator[Result]:
        """One curve per statistic."""
        single = "published" in (self.bias, self.edf)
        noise: Supposing | None = (None if single else fit) or ("auto" if self.fitted or single else None)
        for name in self.statistic:
            curve = deviation(
                record, name, taus=self.taus, m=self.m, noise=noise, bias=self.bias if self._biases(name) else None,
                join=self.join, divisor=self.divisor, edf=self.edf, power_law=self.power_law,
                threads=max(self.threads, how_many()),
            )  # fmt: skip
            yield curve if self.intervals else replace(curve, law=None, supposes=None)

    def keeping(self, head: Record, size: int) -> Keeper:
        """What keeps the samples of a record that is read in parts, if the settings need no more than sums."""
        demand_sums(self)
        demand_grid(self.taus, self.m, head.rate)
        return Keeper(head, self.statistic)

    def kept(self, seen: Inspected, keeper: Keeper, fit: Fit | None) -> tuple[Result, ...]:
        """One curve per statistic, from what was kept."""
        return keeper.curves(fit if self.intervals else None, self.taus, self.m)

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions about a record that is read in parts."""
        return (STRIDES,)


@described
@dataclass(frozen=True, repr=False)
class Densities(DensityChoices, Value):
    """A power spectral density, or the deviation that it amounts to; attributes as for `spectrum` and its methods."""

    def __post_init__(self) -> None:
        super().__post_init__()
        side_factor(self.sides)
        if self.deviation is not None:
            object.__setattr__(self, "deviation", statistic_named(self.deviation).name)
        self._row()

    def _row(self) -> Any:
        settings = {key: getattr(self, key) for key in ("segment", "window", "bandwidth", "tapers", "weights")}
        return method_named(self.estimator, **{key: value for key, value in settings.items() if value is not None})

    @property
    def fitted(self) -> bool:
        """The value of `fit`."""
        return self.fit

    def measure(self, record: Record, fit: Fit | None) -> Iterator[Result]:
        """One spectrum, or its deviation."""
        bins = self.bins if self.deviation is None else None
        density = spectrum(record, self._row(), sides=self.sides, bins=bins or None)
        yield density if self.deviation is None else deviation_of_spectrum(density, self.deviation)

    def keeping(self, head: Record, size: int) -> Keeper:
        """What keeps the samples of a record that is read in parts, if the estimator needs no more than sums."""
        row = self._row()
        if not hasattr(row, "in_parts"):
            raise UsageError(f"{WHOLE} no estimator {self.estimator!r}: choose welch, or allow more memory with "
                             f"{spelled('--memory', 'memory=')}")  # fmt: skip
        return Keeper(head, ("oadev",) if self.fit else (), row.in_parts(head, size))

    def kept(self, seen: Inspected, keeper: Keeper, fit: Fit | None) -> tuple[Result, ...]:
        """One spectrum, or its deviation, from what was kept."""
        bins = self.bins if self.deviation is None else None
        density = of_raw(keeper.raw(), seen.first, self._row().title, sides=self.sides, bins=bins or None)
        return (density if self.deviation is None else deviation_of_spectrum(density, self.deviation),)

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions about a record that is read in parts."""
        return (say("segments of at most {count} samples, by default an eighth of the record, in a record read in "
                    "parts", count=MAX_SEGMENT),)  # fmt: skip


@described
@dataclass(frozen=True, repr=False)
class Windows(WindowChoices, Value):
    """A statistic in sliding windows of the record; attributes as for `dynamic`."""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "statistic", statistic_named(self.statistic).name)

    @property
    def fitted(self) -> bool:
        """The noise is not identified, since it may change."""
        return False

    def measure(self, record: Record, fit: Fit | None) -> Iterator[Result]:
        """One surface."""
        yield dynamic(record, self.statistic, taus=self.taus, m=self.m, window=self.window, step=self.step)

    def keeping(self, head: Record, size: int) -> Keeper:
        """Refuse a record that is read in parts."""
        raise UsageError(f"{WHOLE} no sliding windows: allow more memory with {spelled('--memory', 'memory=')}, or use "
                         "deviation")  # fmt: skip

    def kept(self, seen: Inspected, keeper: Keeper, fit: Fit | None) -> tuple[Result, ...]:
        """Nothing is kept."""
        return ()

    notes: ClassVar[tuple[str, ...]] = ()


@dataclass(frozen=True, eq=False, repr=False)
class Measured(ChannelResult):
    """The values of one channel, or the reason (`refusal`) why there are none."""

    values: tuple[Result, ...] = ()
    alerts: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class Survey(Job[Measured]):
    """Curves, spectra or surfaces of every channel, and the settings used."""

    _channel = Measured

    settings: Deviations | Densities | Windows = field(default_factory=Deviations)

    @property
    def values(self) -> tuple[Result, ...]:
        """All values, in the order of the channels; each has the name of its channel."""
        return tuple(value for channel in self.channels for value in channel.values)

    @property
    def fits(self) -> dict[str, Fit]:
        """The fit of a channel, by its name."""
        return {channel.record.name: channel.fit for channel in self.channels if channel.fit is not None}

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        used = (*READING, *SELECTING, *(IDENTIFYING if self.settings.fitted else ("level",)))
        return self.recipe.to_dict(used) | chosen(self.settings)


def survey(source: Source, settings: Deviations | Densities | Windows, recipe: Recipe | None = None, *,
           progress: Progress | None = None) -> Survey:  # fmt: skip
    """Compute curves, spectra or surfaces of every channel of a recording."""
    recipe = recipe or Recipe()

    def work(seen: Inspected) -> Measured:
        noise, alerts, keeper = None, tuple[str, ...](), seen.keeper
        if settings.fitted:
            try:
                noise = noise_in(seen, recipe)
                alerts = noise.doubts
            except DataError as error:
                alerts = (say("noise not identified, so no model is shown: {reason}", reason=str(error)),)
        fit = None if noise is None else noise.fit
        values = tuple(settings.measure(seen.record, fit) if keeper is None else settings.kept(seen, keeper, fit))
        shown = tuple(value.to(settings.to or readable_unit(value.unit)) for value in values)
        jumps = () if fit is None else joints([v for v in values if isinstance(v, Curve)], fit)
        return Measured(seen.first, seen.quality, noise, values=shown, alerts=(*alerts, *jumps, *seen.alerts))

    begin = partial(begun_in, recipe=recipe) if settings.fitted else None
    return run(partial(Survey, settings=settings), source, recipe, work, Measured.refused, keeping=settings.keeping,
               begin=begin, in_parts_too=settings.notes, doing="measuring", progress=progress)  # fmt: skip


def side_by_side(surveys: Sequence[Survey], files: Sequence[str]) -> Survey:
    """Surveys of several files as one: each channel has the name of its file before its own."""
    if len(surveys) == 1:
        return surveys[0]
    pairs = list(zip(told_apart(files), surveys, strict=True))
    return replace(
        surveys[0],
        channels=tuple(_of_file(name, channel, len(study.channels)) for name, study in pairs for channel in study),
        findings=tuple(replace(f, what=join(": ", (name, f.what))) for name, study in pairs for f in study.findings),
        notes=tuple(dict.fromkeys(note for study in surveys for note in study.notes)),
        provenance=joined([study.provenance for study in surveys]),
    )


def _of_file(file: str, channel: Measured, count: int) -> Measured:
    """A channel with the name of its file before its own, which the only one of a file does not need."""
    name = f"{file} {channel.record.name}" if count > 1 else file
    values = tuple(replace(value, name=name) for value in channel.values)
    return replace(channel, record=replace(channel.record, name=name), values=values)


@dataclass(frozen=True, repr=False)
class TheorySettings(LengthChoices, NoiseSettings):
    """A model, and the length of a record for which its curves are expected: `duration` in s, or `samples`."""

    @property
    def asked(self) -> bool:
        """Whether any of it is given."""
        return self != TheorySettings()


def expected_curves(source: Source | None, settings: TheorySettings, wanted: Deviations,
                    recipe: Recipe | None = None) -> Expectation:  # fmt: skip
    """The expected curves of a model that is given instead of a recording."""
    recipe, model = recipe or Recipe(), settings.instead_of(source)
    if model is None:
        end = settings.duration or (settings.samples or 0) / (recipe.rate or math.inf)
        first = f"{end:g}" if end else "TIME"
        raise UsageError(
            f"{spelled('--duration and --samples are', 'duration and samples are')} the length of a record of a model; "
            f"for the beginning of a recording: {spelled(f'--until {first}', f'until={first}')}"
        )
    demand_no_recording(settings, recipe)
    if wanted.m is not None or wanted.to is not None:
        raise UsageError(f"{spelled('--m and --to apply', 'm and to apply')} to a recording: give averaging times in "
                         "seconds, " + spelled("--taus 1,10,100", "taus=(1, 10, 100)"))  # fmt: skip
    size = None
    if settings.duration is not None or settings.samples is not None:
        if recipe.rate is None:
            raise UsageError(f"the length of a record needs its sampling rate: {spelled('--rate HZ', 'rate=...')}")
        size, _ = size_and_rate(settings.samples, recipe.rate, settings.duration)
    tau = "log" if wanted.taus == Deviations.taus else wanted.taus
    return expectation(model, wanted.statistic, tau=tau, rate=recipe.rate, size=size, name=settings.name)


def expected_of_models(source: Source | None, models: Sequence[str], settings: TheorySettings, wanted: Deviations,
                       recipe: Recipe) -> Expectation | Expectations:  # fmt: skip
    """The expected curves of each model, or of what the settings give; the rest is that of `expected_curves`."""
    each = [replace(settings, model=model) for model in models] or [settings]
    expectations = tuple(expected_curves(source, model_settings, wanted, recipe) for model_settings in each)
    return expectations[0] if len(expectations) == 1 else Expectations(expectations)
