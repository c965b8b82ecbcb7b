"""ClaimedNoise: the noise that a configuration, a data sheet, a limits file or a model states, and its settings."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from allanite.batch.specification import Limit, Specification
from allanite.core import ranges
from allanite.core.aliases import public
from allanite.core.errors import AllaniteError, DataError, UsageError, given as shown
from allanite.core.files import reason
from allanite.core.model import Model, Term
from allanite.core.names import demand_name
from allanite.core.plain import Value
from allanite.core.units import Signal
from allanite.core.validity import SETTLED
from allanite.exporting.exports import EXPORTS, target_named
from allanite.exporting.imported import Imported, models_of, noise_in, numbers, section_of
from allanite.phrases.phrase import join, say, spelled
from allanite.planning.datasheets import claimed
from allanite.terms import TERMS

CUTOFF, RATE = SETTINGS = "cutoff", "rate"  # what may be claimed beside noise

HERTZ = ranges.RATE._replace(what="a frequency")

ITEM = re.compile(r"(?:(?P<sensor>gyro|accel)\w*\s+)?"
                  r"(?:(?P<cutoff>low-?\s?pass|bandwidth|dlpf|cut-?off)|(?:output |sampling )?rate|odr)"
                  r"(?:\s+at|\s*[:=])?\s+(?P<value>(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(?P<kilo>k?)hz",
                  re.IGNORECASE)  # fmt: skip
"""A setting: ``lowpass 42 Hz``, ``gyro bandwidth 250 Hz``, ``output rate 1 kHz``."""


@dataclass(frozen=True, repr=False)
class ClaimedSetting(Value):
    """A setting that is claimed."""

    _checks: ClassVar = {"quantity": lambda name: demand_name("setting", name, SETTINGS)}

    # the -3 dB frequency of a low-pass filter, or the samples of the sensor in a second. One of "cutoff", "rate".
    quantity: str
    value: float  # Hz
    sensor: str = ""  # beginning of the name of the kind of sensor; empty for all

    def holds_for(self, signal: Signal) -> bool:
        """Whether it is a setting of this kind of sensor."""
        return signal.sensor.startswith(self.sensor)

    @property
    def settled(self) -> float:
        """Averaging time, s, from which a filter does not lower the deviation any more."""
        return SETTLED / self.value if self.quantity == CUTOFF else 0.0

    def words(self) -> str:
        """As it is written: ``gyro lowpass 42 Hz``."""
        name = {CUTOFF: "lowpass", RATE: "rate"}[self.quantity]
        return f"{self.sensor} {name} {self.value:g} Hz".strip()

    def _summary(self) -> str:
        return self.words()


def settings_in(text: str) -> tuple[tuple[ClaimedSetting, ...], str]:
    """The settings among the parts of a text, which commas and semicolons separate, and the text without them."""
    settings, groups = list[ClaimedSetting](), []
    for group in text.split(";"):
        kept = []
        for part in group.split(","):
            item = ITEM.fullmatch(part.strip())
            if item is None:
                kept.append(part)
                continue
            value = HERTZ.demand(float(item["value"]) * (1000 if item["kilo"] else 1))
            settings.append(ClaimedSetting(CUTOFF if item["cutoff"] else RATE, value, (item["sensor"] or "").lower()))
        groups.append(",".join(kept))
    return tuple(settings), ";".join(group for group in groups if group.strip()).strip()


SUFFIXES = {suffix for row in EXPORTS.values() for suffix in row.forms} | {".yml", ".xml", ".toml", ".txt", ".cfg"}
"""Suffixes of files of claims: a text with one of them is a path, also where there is no such file."""

KINDS = {"limits": say("limits"), "data sheet": say("data sheet")}
"""What kinds of claims are called, beside models and files of targets."""


@dataclass(frozen=True, repr=False)
class ClaimedNoise(Value):
    """Noise that is claimed.

    Attributes
    ----------
    source : str
        The file, the name of the data sheet, or the text of the model.
    kind : str
        What it is: "model", "data sheet", "limits", or the name of a target of `allanite.exporting.EXPORTS`.
    models : tuple of Model
        One for each kind of sensor, of limits as large as they are. Where the file of a target states a correlation
        time, the bias is GM.
    bound : bool
        Whether the values are upper bounds, as those of a data sheet; otherwise the noise has exactly these values.
    limits : Specification or None
        The limits of a limits file.
    rate : float or None
        Rate that the formulas of the file used, Hz.
    settings : tuple of ClaimedSetting
        Cut-off of the low-pass filter and rate of the sensor.
    """

    source: str
    kind: str
    models: tuple[Model, ...]
    bound: bool = False
    limits: Specification | None = None
    rate: float | None = None
    settings: tuple[ClaimedSetting, ...] = ()

    def of(self, signal: Signal) -> Model | None:
        """The model of a kind of sensor; None if there is none."""
        return next((model for model in self.models if model.signal is signal), None)

    def limits_of(self, channel: str, signal: Signal) -> tuple[Limit, ...]:
        """What is claimed of a channel, as limits: of a limits file, or of each term of the model."""
        if self.limits is not None:
            return self.limits.of(channel, signal)
        terms = (t for t in self.of(signal) or () if not t.row.periodic)
        return tuple(Limit(t.symbol, abs(t.value), signal.sheet[t.row.power], signal) for t in terms)

    @property
    def title(self) -> str:
        """Source and kind in a few words: ``imu.yaml (kalibr)``, with the settings."""
        noise = self.source
        if self.source and self.kind != "model":
            noise = say("{name} ({kind})", name=os.path.basename(self.source), kind=KINDS.get(self.kind, self.kind))
        return join(", ", filter(None, (noise, *(s.words() for s in self.settings))))

    @property
    def text(self) -> str:
        """What `claim_of` reads as this claim."""
        return ", ".join(filter(None, (self.source, *(s.words() for s in self.settings))))

    def _summary(self) -> str:
        texts = [str(self.limits)] if self.limits is not None else list(map(str, self.models))
        return f"of {self.title}: {join('; ', texts)}" if texts else f"of {self.title}"


@public
def claim_of(given: "str | os.PathLike[str] | Model | ClaimedNoise", origin: str | None = None,
             rate: float | None = None) -> ClaimedNoise:  # fmt: skip
    """The noise that a text, a file or a name claims.

    Parameters
    ----------
    given : str, path, Model or ClaimedNoise
        In this order: the path of a file of a target (kalibr, gazebo, px4 ...) or of limits (.toml); a model ``"N 0.3
        deg/sqrt(h), K 3 deg/h/sqrt(h)"`` or a value with its unit, those of several sensors separated by ``;``; the
        name of a data sheet. Behind any of them, or alone, settings: ``lowpass 42 Hz``, ``rate 100 Hz``, of one kind
        of sensor ``gyro lowpass 42 Hz``.
    origin : str, optional
        Name of the target whose file it is; otherwise the fields in it tell.
    rate : float, optional
        Sampling rate, Hz, for files with fields of discrete time.

    Returns
    -------
    ClaimedNoise

    Raises
    ------
    UsageError
        It is none of these, several targets have such fields with different meanings, or the rate is needed.
    DataError
        The file cannot be read, or has none of the fields.

    Examples
    --------
    >>> claim_of("0.66 deg/sqrt(h); N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)").models
    (<Model N = 0.66 deg/sqrt(h)>, <Model N = 0.05884 m/s/sqrt(h), K = 10 ug/sqrt(h)>)
    """
    if isinstance(given, ClaimedNoise | Model):
        return given if isinstance(given, ClaimedNoise) else ClaimedNoise(str(given), "model", (given,))
    text = os.fspath(given)
    settings, rest = ((), text) if os.path.isfile(text) else settings_in(text)
    if settings:
        noise = claim_of(rest, origin, rate) if rest else ClaimedNoise("", "model", ())
        return replace(noise, settings=settings)
    if origin or os.path.isfile(text) or os.path.splitext(text)[1] in SUFFIXES or not isinstance(given, str):
        return _of_file(text, origin or "", rate)
    if text[:1].isdigit() or text.split(" ")[0] in TERMS:
        return ClaimedNoise(text, "model", tuple(models_of(part.strip() for part in text.split(";"))))
    try:
        return ClaimedNoise(text, "data sheet", claimed(text), bound=True)
    except UsageError as error:
        _, meant = error.cure
        why = f"{shown(text)} is no file, no data sheet, and no model such as 'N 0.3 deg/sqrt(h), K 3 deg/h/sqrt(h)'"
        lists = f"did you mean the data sheet {meant}?" if meant else "'allanite explain' lists the data sheets"
        raise UsageError(f"{why}; {lists}", cure=error.cure) from None


def _of_file(path: str, origin: str | None, rate: float | None) -> ClaimedNoise:
    if path.lower().endswith(".toml") and not origin:
        limits = Specification.load(path)
        return ClaimedNoise(path, "limits", tuple(_limited(limits)), bound=True, limits=limits)
    try:
        text = Path(path).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path!r} cannot be read: {reason(error)}") from None
    noise = noise_in(text, target_named(origin), rate, path) if origin else recognized(text, rate, path)
    if not noise.models:
        raise DataError(f"{path!r} has no value above 0 in the fields of {noise.target}: it claims no noise")
    return ClaimedNoise(path, noise.target, noise.simulated, rate=noise.rate)


def _limited(limits: Specification) -> Iterator[Model]:
    """The models of sensors that are as large as the limits of all channels."""
    for signal in dict.fromkeys(limit.signal.name for limit in limits.limits):
        own = [limit for limit in limits.limits if limit.signal.name == signal and limit.symbol in TERMS]
        terms = [Term(limit.symbol, limit.maximum, limit.signal) for limit in own if not TERMS[limit.symbol].parameters]
        if terms:
            yield Model(tuple(terms))


def recognized(text: str, rate: float | None = None, name: str = "the text") -> Imported:
    """The noise in the text of a file of a target, which is recognized by its fields."""
    counts = {row.name: sum(bool(numbers(section_of(text, field, row), field.name)) for field in row.fields)
              for row in EXPORTS.values()}  # fmt: skip
    most = max(counts.values())
    if not most:
        known = ", ".join(row.name for row in EXPORTS.values() if row.fields)
        raise DataError(f"{name!r} has no field of a known target; these are known: {known}")
    readings, refused = list[Imported](), list[AllaniteError]()
    for row in (EXPORTS[target] for target, count in counts.items() if count == most):
        try:
            readings.append(noise_in(text, row, rate, name))
        except UsageError as error:
            refused.append(error)
    if refused:
        raise refused[0]
    if any(other.simulated != readings[0].simulated for other in readings[1:]):
        names = [imported.target for imported in readings]
        wanted = spelled(f"--claims-from {names[0]}", f"origin={names[0]!r}")
        raise UsageError(
            say("{name!r} may be a file of {targets}, whose fields mean different things: name its target, {option}",
                name=name, targets=join(" or ", names), option=wanted)
        )  # fmt: skip
    return readings[0]
