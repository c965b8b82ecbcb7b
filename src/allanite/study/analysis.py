"""The only place that composes: from a recording and a recipe to a study."""

import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property, partial
from typing import Any

from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.finding import Quality
from allanite.core.fit import Fit
from allanite.core.limits import demand_level
from allanite.core.record import Record, Recording
from allanite.core.residuals import Residuals, Shared
from allanite.core.version import __version__
from allanite.identification import METHODS, identify
from allanite.identification.checks.residuals import residuals
from allanite.identification.checks.shared import shared
from allanite.prepare import inspect, mark_outliers, quiet_window, trim
from allanite.prepare.outliers import demand_choice
from allanite.readers import read
from allanite.statistics import deviation

READING = ("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset")
"""Choices of a recipe that say what the file holds."""


@dataclass(frozen=True)
class Recipe:
    """Every choice of an analysis as plain data.

    The first group says what the file holds (None: taken from the file), the second what is done with it. `outliers`:
    "mark" leaves them out of everything, "keep" out of nothing; None leaves them out of the fit, and not of curves.
    """

    rate: float | None = None
    unit: str | None = None
    kind: str | None = None
    scale: float | str | None = None
    channels: tuple[str, ...] | None = None
    time: str | None = None
    dtype: str | None = None
    columns: int | None = None
    offset: int | None = None
    start: float | None = None
    until: float | None = None
    quiet_window: float | None = None
    outliers: str | None = None
    statistic: str = "oadev"
    taus: str | tuple[float, ...] = "log"
    terms: str = "auto"
    method: str = "whittle"
    band: tuple[float, float] | None = None
    level: float = 0.95

    def __post_init__(self) -> None:
        for key in ("rate", "scale", "start", "until", "quiet_window", "level", "columns", "offset"):
            value = getattr(self, key)
            fine = isinstance(value, (int, float)) or (key == "scale" and isinstance(value, str))
            if value is not None and (isinstance(value, bool) or not fine):
                raise UsageError(f"{key} is a number, not {value!r}")
        for key in ("unit", "kind", "time", "dtype", "statistic", "terms", "method", "outliers"):
            value = getattr(self, key)
            if value is not None and not isinstance(value, str):
                raise UsageError(f"{key} is a word, not {value!r}")
        if self.outliers is not None:
            demand_choice(self.outliers)
        demand_level(self.level)
        if self.band is not None and (len(self.band) != 2 or not all(isinstance(f, (int, float)) for f in self.band)):
            raise UsageError(f"a band is two frequencies in Hz, not {self.band!r}")

    def to_dict(self) -> dict[str, Any]:
        """Plain data; what was left open is left out."""
        return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self).items() if v is not None}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Recipe":
        """A recipe from plain data, for example a TOML table.

        Raises
        ------
        UsageError
            A key is unknown; the message lists the known ones.
        """
        known = [f.name for f in fields(cls)]
        for key in data:
            if key not in known:
                raise UsageError(f"unknown key {key!r} in the recipe; known are {', '.join(known)}")
        values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in data.items()}
        return cls(**values)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Recipe":
        """A recipe from a TOML file."""
        import tomllib

        try:
            with open(path, "rb") as file:
                return cls.from_dict(tomllib.load(file))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise UsageError(f"the recipe {os.fspath(path)!r} cannot be read: {error}") from None


@dataclass(frozen=True, eq=False)
class Channel:
    """What was found of one channel; `refusal` says why nothing was, if nothing was.

    `leftover` makes `residuals`, when they are first asked for.
    """

    record: Record
    quality: Quality
    curve: Curve | None = None
    fit: Fit | None = None
    refusal: str = ""
    leftover: Callable[[], Residuals] | None = None

    @cached_property
    def residuals(self) -> Residuals | None:
        """What the model leaves of the record; None without a model of all frequencies, or by a method without one."""
        return None if self.leftover is None else self.leftover()

    @property
    def explained(self) -> bool:
        """Whether there is a model, and nothing says that it does not explain the record."""
        good = self.residuals or (self.fit.goodness if self.fit else None)
        return self.fit is not None and (good is None or good.explained)

    @property
    def verdict(self) -> str:
        """Whether the model explains the record, in a sentence; empty where the method does not say."""
        good = self.residuals or (self.fit.goodness if self.fit else None)
        return "" if good is None else good.verdict

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.record.name,
            "rate": self.record.rate,
            "size": self.record.size,
            "unit": self.record.unit,
            "kind": self.record.kind,
            "history": list(self.record.history),
            "quality": self.quality.to_dict(),
            "refusal": self.refusal,
            "curves": [] if self.curve is None else [self.curve.to_dict(level)],
            "fit": None if self.fit is None else self.fit.to_dict(level),
            "residuals": None if self.residuals is None else self.residuals.to_dict(),
        }


@dataclass(frozen=True, eq=False)
class Study:
    """Recording, recipe, and what was found; `notes` are what was assumed when reading, `provenance` what made it."""

    channels: tuple[Channel, ...]
    recipe: Recipe
    notes: tuple[str, ...]
    provenance: dict[str, str]

    @cached_property
    def shared(self) -> Shared | None:
        """What the channels have in common beyond their models; None where fewer than two can be compared."""
        fits = {c.record.name: c.fit for c in self.channels if c.fit is not None and c.leftover is not None}
        records = tuple(c.record for c in self.channels if c.record.name in fits)
        if len(records) < 2 or len({record.size for record in records}) > 1:
            return None
        return shared(Recording(records), fits, outliers=self.recipe.outliers or "mark")

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "allanite": 1,
            "type": "Study",
            "channels": [channel.to_dict(self.recipe.level) for channel in self.channels],
            "shared": None if self.shared is None else self.shared.to_dict(),
            "recipe": self.recipe.to_dict(),
            "notes": list(self.notes),
            "provenance": self.provenance,
        }


def analyze(
    source: Recording | Record | str | os.PathLike[str],
    recipe: Recipe | None = None,
    *,
    progress: Callable[[str, float], None] | None = None,
) -> Study:
    """The main job: noise coefficients of every channel, with intervals, and the curve they explain.

    Parameters
    ----------
    source : Recording, Record or path
        A path is read with the recipe's options.
    recipe : Recipe, optional
        All choices; the defaults are the ordinary analysis.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Returns
    -------
    Study
        Channels that cannot support the job carry the reason and no numbers.

    Raises
    ------
    DataError
        The file cannot be read, or none of its channels supports the job.
    UsageError
        An option is wrong, or one that is needed is missing.
    """
    recipe = recipe or Recipe()
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    recording = recording_of(source, recipe)
    channels = []
    for i, record in enumerate(recording):
        tell(f"analysing {record.name}", (i + 0.3) / (len(recording) + 0.3))
        channels.append(_analyze_channel(_looked_at(record, recording), recipe))
    tell("done", 1.0)
    return _study(channels, recipe, recording)


def examine(
    source: Recording | Record | str | os.PathLike[str],
    recipe: Recipe | None = None,
    *,
    progress: Callable[[str, float], None] | None = None,
) -> Study:
    """What is in a recording, and whether it is fit for the job: a study without numbers.

    Parameters, errors and result are those of `analyze`; no channel has a curve or a fit.
    """
    recipe = recipe or Recipe()
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    recording = recording_of(source, recipe)
    channels = []
    for i, record in enumerate(recording):
        tell(f"looking at {record.name}", (i + 0.3) / (len(recording) + 0.3))
        channels.append(_looked_at(record, recording))
    tell("done", 1.0)
    return Study(tuple(channels), recipe, recording.notes, provenance_of(recording))


def _study(channels: list[Channel], recipe: Recipe, recording: Recording) -> Study:
    if all(channel.refusal for channel in channels):
        raise DataError("; ".join(f"{channel.record.name or 'the record'}: {channel.refusal}" for channel in channels))
    return Study(tuple(channels), recipe, recording.notes, provenance_of(recording))


def _looked_at(record: Record, recording: Recording) -> Channel:
    quality = Quality((*recording.findings, *inspect(record).findings))
    return Channel(record, quality, refusal=quality.refusal)


def recording_of(source: Recording | Record | str | os.PathLike[str], recipe: Recipe) -> Recording:
    """The part of the recording that the recipe wants."""
    whole = trim(_whole(source, recipe), recipe.start, recipe.until)
    part = whole if recipe.quiet_window is None else quiet_window(whole, recipe.quiet_window)
    if recipe.outliers != "mark":
        return part
    return replace(part, records=tuple(mark_outliers(record) for record in part))


def fitted(record: Record, recipe: Recipe) -> Fit:
    """The noise of a channel as the recipe wants it identified.

    A method that reads a curve reads that of the recipe's statistic, or the fit says that it cannot.
    """
    row = METHODS.get(recipe.method)
    readable = row is not None and recipe.statistic in row.allowed
    fit = identify(
        record,
        method=recipe.method,
        terms=recipe.terms,
        statistic=recipe.statistic if readable else None,
        band=recipe.band,
        outliers=recipe.outliers or "mark",
    )
    if row is None or readable or not row.allowed:
        return fit
    note = f"method {recipe.method!r} does not read {recipe.statistic}: the coefficients are those of {row.statistic}"
    return replace(fit, notes=(*fit.notes, note))


def _whole(source: Recording | Record | str | os.PathLike[str], recipe: Recipe) -> Recording:
    if isinstance(source, Recording):
        return source
    if isinstance(source, Record):
        return Recording((source,))
    options = {key: getattr(recipe, key) for key in READING}
    return read(source, **options)


def _analyze_channel(seen: Channel, recipe: Recipe) -> Channel:
    if seen.refusal:
        return seen
    record = seen.record
    try:
        fit = fitted(record, recipe)
        curve = deviation(record, recipe.statistic, taus=recipe.taus, noise=fit.model)
    except DataError as error:
        return replace(seen, refusal=str(error))
    leftover = None
    if fit.goodness is not None and recipe.band is None:
        leftover = partial(residuals, record, fit, outliers=recipe.outliers or "mark")
    return replace(seen, curve=curve, fit=replace(fit, curve=curve), leftover=leftover)


def provenance_of(recording: Recording) -> dict[str, str]:
    """Version and input, for whoever wants to do it again."""
    import platform

    return {
        "allanite": __version__,
        "python": platform.python_version(),
        "source": recording.source,
        "sha256": recording.digest,
    }
