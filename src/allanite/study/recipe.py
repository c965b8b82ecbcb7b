"""Recipe: every choice of an analysis as plain data."""

import os
import stat
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

from allanite.core.display_units import showing
from allanite.core.errors import UsageError
from allanite.core.ranges import demand_pieces, demand_ranges
from allanite.core.validity import Band, demand_band
from allanite.interpretation.devices import device
from allanite.prepare.outliers import demand_choice
from allanite.readers.memory import bytes_of
from allanite.readers.options import stated_unit

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

READING = ("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset", "sincos")
"""Keys that describe the contents of the file."""

SELECTING = ("average", "exclude", "start", "until", "quiet_window", "outliers", "motion", "memory")
"""Keys that select samples, and whether all of them are in memory."""

IDENTIFYING = ("terms", "method", "ranges", "band", "mask", "level")
"""Keys of the identification."""

CURVE = ("statistic", "taus")
"""Keys of the curve of a study."""

SHOWING = ("device", "to", "about")
"""Keys of how a study is shown: likely causes in a device, units, and facts for the header."""

_NUMBERS = ("rate", "scale", "average", "start", "until", "quiet_window", "level", "columns", "offset")
_WORDS = ("unit", "kind", "time", "dtype", "statistic", "terms", "method", "outliers", "motion", "memory", "device")


@dataclass(frozen=True)
class Recipe:
    """Every choice of an analysis as plain data.

    The first group describes the contents of the file (None: taken from the file), the second selects the samples used,
    the others define the analysis. `outliers`: "mark" excludes them everywhere, "keep" uses them everywhere; by default
    they are excluded from the fit only. `motion`: "mark" leaves out the seconds in which the sensor moves, in all
    channels of its body; "refuse", the default, analyzes no record that moves for more than 2 % of the time. `unit` by
    sensor or column, as ``{"gyro": "deg/s", "ax": "g"}``, is kept as the text ``"gyro=deg/s,ax=g"``. `average`: means
    over so many seconds replace the samples, before anything else.
    `exclude`: pairs of seconds after the first sample, or ``"100..160,300..310"``, between which samples are missing.
    `memory`: what a record may take, as ``"1GB"``, beyond which it is read in parts; by default half of the memory
    available. `ranges`: averaging times, s, of each term's line for method "piecewise". `mask`: pairs of
    frequencies, Hz, or ``"0.4..2.1,19..20"``, between which the fit does not read the spectrum. `device` is a name in
    `DEVICES`, whose likely causes of each term are shown.
    """

    rate: float | None = None
    unit: str | Mapping[str, str] | None = None
    kind: str | None = None
    scale: float | str | None = None
    channels: tuple[str, ...] | None = None
    time: str | None = None
    dtype: str | None = None
    columns: int | None = None
    offset: int | None = None
    sincos: tuple[str, ...] | None = None
    average: float | None = None
    exclude: str | tuple[tuple[float, float], ...] | None = None
    start: float | None = None
    until: float | None = None
    quiet_window: float | None = None
    outliers: str | None = None
    motion: str | None = None
    memory: str | None = None
    statistic: str = "oadev"
    taus: str | tuple[float, ...] = "log"
    terms: str = "auto"
    method: str = "whittle"
    ranges: Mapping[str, tuple[float, float]] | None = None
    band: Band = "auto"
    mask: str | tuple[tuple[float, float], ...] | None = None
    level: float = 0.95
    device: str | None = None
    to: tuple[str, ...] | None = None
    about: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if isinstance(self.unit, Mapping):
            object.__setattr__(self, "unit", stated_unit(self.unit))
        for key in _NUMBERS:
            value = getattr(self, key)
            fine = isinstance(value, (int, float)) or (key == "scale" and isinstance(value, str))
            if value is not None and (isinstance(value, bool) or not fine):
                raise UsageError(f"{key} must be a number, not {value!r}")
        for key in _WORDS:
            value = getattr(self, key)
            if value is not None and not isinstance(value, str):
                raise UsageError(f"{key} must be a word, not {value!r}")
        if self.outliers is not None:
            demand_choice(self.outliers)
        self._demand_selecting()
        if not 0 < self.level < 1:
            raise UsageError(f"a confidence level must be between 0 and 1, not {self.level!r}")
        demand_band(self.band)
        if self.mask is not None:
            object.__setattr__(self, "mask", demand_pieces(self.mask, "Hz"))
        if self.ranges is not None:
            object.__setattr__(self, "ranges", demand_ranges(self.ranges))
        self._demand_showing()

    def _demand_selecting(self) -> None:
        """Refuse pieces or a size of memory that cannot be read."""
        if self.exclude is not None:
            object.__setattr__(self, "exclude", demand_pieces(self.exclude))
        if self.motion not in (None, "mark", "refuse"):
            raise UsageError(f"motion must be 'mark' or 'refuse', not {self.motion!r}")
        if self.memory is not None:
            bytes_of(self.memory)

    def _demand_showing(self) -> None:
        """Refuse a device, a unit or a fact that cannot be shown."""
        if self.device is not None:
            device(self.device)
        for unit in self.to or ():
            _demand_shown(unit)
        for line in self.about or ():
            if not line.partition("=")[2]:
                raise UsageError(f"facts about a device are given as KEY=VALUE, e.g. serial=SN-12, not {line!r}")

    @property
    def labels(self) -> dict[str, str]:
        """Facts about the device, by key."""
        lines = (line.partition("=") for line in self.about or ())
        return {key.strip(): value.strip() for key, _, value in lines}

    def to_dict(self, keys: tuple[str, ...] = (*READING, *SELECTING, *CURVE, *IDENTIFYING, *SHOWING)) -> dict[str, Any]:
        """Plain data of these keys; those not given are omitted."""
        return {key: value for key, value in chosen(self).items() if key in keys}

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
                raise UsageError(f"unknown key {key!r} in the recipe; known keys: {', '.join(known)}")
        values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in data.items()}
        return cls(**values)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Recipe":
        """A recipe from a TOML file."""
        return cls.from_dict(load_toml(path))


def _demand_shown(unit: str) -> None:
    """Refuse a unit in which no coefficient can be shown."""
    if not showing(unit):
        raise UsageError(f"no noise coefficient has the unit {unit!r}; give one of the signal, as deg/s or m/s^2, or "
                         "of a coefficient, as deg/s/sqrt(Hz)")  # fmt: skip


def chosen(settings: "DataclassInstance") -> dict[str, Any]:
    """Settings as plain data, under the names of the command line; those not given are omitted."""
    return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(settings).items() if v is not None}


def load_toml(path: str | os.PathLike[str], what: str = "recipe") -> dict[str, Any]:
    """The table of a TOML file, which messages call `what`.

    Raises
    ------
    UsageError
        The file cannot be read, or is not TOML.
    """
    import tomllib

    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise OSError("it is not a regular file")
        with open(path, "rb") as file:
            return tomllib.load(file)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"the {what} {os.fspath(path)!r} cannot be read: {error}") from None
