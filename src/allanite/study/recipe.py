"""Recipe: every choice of an analysis as plain data."""

import os
import shlex
import stat
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from allanite.core.choices import (  # isort: skip
    BAND, HERTZ, INSTANT, LINES, RANGES, SYMBOLS, WORD, WORTH, ChoiceKind, Choices, choice, choices_of, described,
    named, pieces
)  # fmt: skip
from allanite.core.errors import UsageError, unfit
from allanite.core.files import reason
from allanite.core.names import demand_name
from allanite.core.ranges import LEVEL, TIME, Range, demand_band

from .settings import grid

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


# these are imported when a value is given, since the help reads the rows and no more


def _accepted(function: str) -> Callable[[Any], Any]:
    """The value, unless a function of `allanite` refuses it."""

    def demand(value: Any) -> Any:
        module, _, name = function.rpartition(".")
        getattr(import_module(f"allanite.{module}"), name)(value)
        return value

    return demand


def _statistic(name: str) -> str:
    from allanite.statistics import statistic_named

    return statistic_named(name).name


def _stated(key: str) -> Callable[[Any], Any]:
    """The value, unless it is refused where a file is read."""

    def demand(value: Any) -> Any:
        from allanite.readers.options import Options

        Options(**{key: value})
        return value

    return demand


def _unit(unit: str | Mapping[str, str]) -> str:
    from allanite.readers.options import stated_unit

    return str(_stated("unit")(stated_unit(unit)))


def _units_shown(units: tuple[str, ...]) -> tuple[str, ...]:
    from allanite.core.display_units import showing

    for unit in units:
        if not showing(unit):
            raise UsageError(f"no noise coefficient has the unit {unit!r}; give one of the signal, as deg/s or m/s^2, "
                             "or of a coefficient, as deg/s/sqrt(Hz)")  # fmt: skip
    return units


def _facts(lines: tuple[str, ...]) -> tuple[str, ...]:
    for line in lines:
        if not line.partition("=")[2]:
            raise UsageError(f"facts about a device are given as KEY=VALUE, e.g. serial=SN-12, not {line!r}")
    return lines


@described
@dataclass(frozen=True)
class Recipe(Choices):
    """Every choice of an analysis as plain data; what describes a file is taken from it where it is None.

    Attributes
    ----------
    unit : str or dict, optional
        Unit of the samples; by sensor or column, as ``{"gyro": "deg/s", "ax": "g"}``, which is kept as the text
        ``"gyro=deg/s,ax=g"``.
    exclude, mask : str or pairs of numbers, optional
        Seconds after the first sample between which samples are missing, and frequencies, Hz, between which the fit
        does not read the spectrum, as ``"100..160,300..310"``.
    device : str, optional
        Likely causes of each term in a device of `DEVICES` are shown.
    """

    # fmt: off
    rate: float | None = choice("HZ", "Sampling rate; overrides the file.", group="reading",
                                synonyms=("samplerate", "sampling rate", "sampling frequency", "frequency", "hz",
                                          "odr"), flags=("--rate", "--fs"), kind=HERTZ, demand=_stated("rate"))
    unit: str | Mapping[str, str] | None = choice(
        "UNIT", "Unit of the samples: deg/s, rad/s, arcsec, g, m/s^2, ...; by sensor or column: gyro=deg/s,accel=g.",
        kind=ChoiceKind("unit", _unit, lambda name, value: _unit(
            value if isinstance(value, Mapping) else WORD.demand(name, value)),
            takes=(str, dict), form="a unit such as deg/s, or gyro=deg/s,accel=g"),
        group="reading", synonyms=("units",))
    kind: str | None = choice(
        "", "What a sample is: rate, increment, angle, count or value.", group="reading", demand=_stated("kind"))
    scale: float | str | None = choice("STEP", "Scale factor per count: 0.01 (in --unit) or 0.01deg/s.", kind=WORTH,
                                       group="reading", demand=_stated("scale"))
    channels: tuple[str, ...] | None = choice("A,B,...", "Columns by name or number.", told="all recognized",
                                              group="reading", synonyms=("axis", "axes", "column"))
    time: str | None = choice("", "Column of the time stamps.", group="reading", synonyms=("stamps", "time column"))
    dtype: str | None = choice("TYPE", "The file is raw binary of this type: i2, >i2, f4, ..., u4,6i2 for mixed rows, "
                               "or kfgins.", group="reading")
    columns: int | None = choice("N", "Numbers per row of raw binary.", group="reading", within=Range(1, 1e6))
    offset: int | None = choice("BYTES", "Bytes before the first row of raw binary.", group="reading",
                               within=Range(0, 2**63 - 1))
    sincos: tuple[str, ...] | None = choice(
        "S,C,...", "Columns of sine and cosine, in pairs: their angle is analyzed.", group="reading", parts=())
    average: float | None = choice("TIME", "First of all replace the samples by means over this time.", kind=INSTANT,
                                   within=TIME, group="selecting", synonyms=("decimate", "downsample"))
    exclude: str | tuple[tuple[float, float], ...] | None = choice(
        "S..S,...", "Pieces to leave out, s after the first sample: 100..160,300..310; they become gaps.",
        kind=pieces("s"), group="selecting", synonyms=("cut", "drop"))
    start: float | None = choice("TIME", "Start of the window after the first sample: 600, 10min.", kind=INSTANT,
                                 group="selecting", synonyms=("start", "begin", "skip"), flags=("--from",))
    until: float | None = choice("TIME", "End of the window after the first sample: 3600, 1h.", kind=INSTANT,
                                 within=TIME, group="selecting", synonyms=("end", "stop"))
    quiet_window: float | None = choice(
        "TIME", "Use the most stationary window of this length.", kind=INSTANT, within=TIME, group="selecting",
        parts=())
    outliers: str | None = choice("WORD", "mark: exclude everywhere; keep: use everywhere.", told="exclude from the "
                                  "fit only", group="selecting", demand=_accepted("prepare.outliers.demand_choice"))
    motion: str | None = choice(
        "WORD", "mark: leave out the seconds in which the sensor moves; refuse: no analysis beyond 2 % of them.",
        told="refuse; of a live stream mark", group="selecting", demand=_accepted("prepare.transform.demand_motion"))
    memory: str | None = choice(
        "SIZE", "Memory that a record may take, e.g. 1GB; a larger one is read in parts.",
        told="half of what is available", group="selecting", demand=_accepted("readers.parts.bytes_of"))
    statistic: str = choice("NAME", "Statistic of the curve.", default="oadev", group="curve",
        synonyms=("stat", "type"), demand=_statistic)
    taus: str | tuple[float, ...] = grid("log")
    terms: str = choice("QNBKR", "Noise terms to look for.", kind=SYMBOLS, default="auto", group="identifying",
        synonyms=("noise",))
    method: str = choice(
        "NAME", "whittle, or for comparison gls, joint, nnls, piecewise, ls, curve, slopes.", default="whittle",
        group="identifying", synonyms=("estimator", "algorithm"), parts=("whittle",))
    ranges: Mapping[str, tuple[float, float]] | None = choice(
        "N=LO:HI,...", "Averaging times through which method piecewise draws the line of each term, s.", kind=RANGES,
        group="identifying", parts=())
    band: str | tuple[float, float] = choice(
        "BAND", "Frequencies to fit: auto (detects filters and disturbed bands), all, or LO,HI in Hz.", kind=BAND,
        default="auto", group="identifying", synonyms=("frequencies",), demand=demand_band)
    mask: str | tuple[tuple[float, float], ...] | None = choice(
        "HZ..HZ,...", "Frequencies that the fit leaves out, beside those it finds: 0.4..2.1,19..20.", kind=pieces("Hz"),
        group="identifying")
    level: float = choice("", "Confidence level of intervals.", default=0.95, group="identifying",
        synonyms=("confidence", "ci"), within=LEVEL)
    device: str | None = choice("NAME", "Likely causes of each term in it: stabilizer, mscsg, rlg, fog, mems, "
                                "accelerometer.", group="showing", demand=_accepted("interpretation.devices.device"))
    to: tuple[str, ...] | None = choice(
        "UNIT,...", "Units of the coefficients: deg/s, ug/sqrt(Hz), ...", told="those of data sheets", group="showing",
        demand=_units_shown, flags=("--output-unit",), old=("--to",))
    about: tuple[str, ...] | None = choice("KEY=VALUE", "For the header of the report: serial, operator, date, "
                                           "temperature, ...", kind=LINES, group="showing", demand=_facts)
    # fmt: on

    @property
    def labels(self) -> dict[str, str]:
        """Facts about the device, by key."""
        lines = (line.partition("=") for line in self.about or ())
        return {key.strip(): value.strip() for key, _, value in lines}

    def to_dict(self, keys: tuple[str, ...] | None = None) -> dict[str, Any]:
        """Plain data of these keys, by default all; those not given are omitted."""
        return {key: value for key, value in chosen(self).items() if keys is None or key in keys}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Recipe":
        """A recipe from plain data, for example a TOML table; keys are names of fields or of options.

        Raises
        ------
        UsageError
            A key is unknown; the message lists the known ones.
        """
        if not isinstance(data, dict):
            raise unfit(data, "a table of choices")
        rows, values = choices_of(cls), dict[str, Any]()
        options = {key: name for name, row in rows.items() for key in row.keys}
        for key, value in data.items():
            name = options.get(key, key)
            demand_name("key", name, rows, where=" in the recipe")
            values[name] = tuple(value) if isinstance(value, list) else value
        return cls(**values)

    def but(self, choices: Mapping[str, Any]) -> "Recipe":
        """The recipe with other choices, by their keys."""
        return Recipe.from_dict(self.to_dict() | dict(choices)) if choices else self

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Recipe":
        """A recipe from a TOML file."""
        return cls.from_dict(load_toml(path))


READING, SELECTING, IDENTIFYING = (named(Recipe, group) for group in ("reading", "selecting", "identifying"))
"""Keys that describe the contents of the file, that select samples, and of the identification."""


def command_of(recipe: Recipe, *words: str, last: tuple[str, ...] = ()) -> str:
    """A command line of these words, with `last` behind them, that reads and selects as a recipe does."""
    rows = ((row, getattr(recipe, key)) for key, row in choices_of(Recipe).items() if key in (*READING, *SELECTING))
    own = (word for row, value in rows if value != row.default for word in row.words(value))
    return shlex.join([*words, *own, *last])


def chosen(settings: "DataclassInstance") -> dict[str, Any]:
    """Settings as plain data, under the names of the command line; those not given are omitted."""
    return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(settings).items() if v is not None}


def load_toml(path: str | os.PathLike[str], what: str = "recipe") -> dict[str, Any]:
    """The table of a TOML file, which messages call `what`."""
    import tomllib

    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise UsageError(f"the {what} {os.fspath(path)!r} is not a regular file; give the path of a TOML file")
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as error:
        raise UsageError(f"the {what} {os.fspath(path)!r} cannot be read: {reason(error)}; check its path") from None
    except UnicodeDecodeError:
        raise UsageError(f"the {what} {os.fspath(path)!r} is not text in UTF-8; save it as UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"the {what} {os.fspath(path)!r} cannot be read as TOML: {error}") from None
