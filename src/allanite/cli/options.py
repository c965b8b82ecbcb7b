"""The options of the command line, each declared once, and the types of their values."""

import os
import re
from collections.abc import Callable, Sequence
from itertools import pairwise, takewhile
from typing import TYPE_CHECKING, Any

import click

from allanite.core import choices
from allanite.core.choices import DURATION, FLAG, HERTZ, INTEGER, LINES, NUMBER, ChoiceKind, ChoiceRow, choices_of
from allanite.core.errors import COLUMN, MEANINGS, RATE, SCALE, UNIT, UsageError
from allanite.core.names import demand_name
from allanite.core.ranges import POSITIVE, SEED, SIZE, TIME, Range
from allanite.reporting.language import ENGLISH, LANGUAGES
from allanite.study.recipe import IDENTIFYING as IDENTIFIES, READING, SELECTING, Recipe, load_toml

if TYPE_CHECKING:
    ParamType = click.ParamType[Any]
else:
    ParamType = click.ParamType  # generic only in newer versions


class Converted(ParamType):
    """The kind of a choice as a type of click."""

    def __init__(self, kind: ChoiceKind, within: Range | None = None) -> None:
        self.kind, self.name, self.within = kind, kind.name, within

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value, from its text or what a recipe holds."""
        try:
            return self.kind.parse(value, self.within)
        except UsageError as error:
            raise error.within(f"Invalid value for {param.get_error_hint(ctx)}" if param else self.name) from None


def number(within: Range) -> Converted:
    """The type of an option that is a number within a range."""
    return Converted(NUMBER, within)


def integer(low: int, high: int) -> Converted:
    """The type of an option that is an integer, from `low` to `high`."""
    return Converted(INTEGER, Range(low, high))


NAMES = Converted(choices.NAMES)

THREADS = ChoiceKind("threads", lambda value: None if value == "auto" else int(value),
                     form="a number of processors, at least 1, or auto", within=Range(1, 10_000))  # fmt: skip
"""A number of processors; "auto", all of them, is None."""

PLACES = {"--unit": rf"\b({COLUMN}|{UNIT})\b", "--rate": rf"\b({RATE})\b", "--scale": rf"\b({SCALE})\b",
          "--time": rf".*\[({UNIT})\]"}  # fmt: skip
"""The options that have them, and where."""


def demand_filled(words: Sequence[str]) -> None:
    """Refuse a command in which a placeholder was left.

    >>> demand_filled(["info", "a.csv", "--rate", "HZ"])
    Traceback (most recent call last):
        ...
    allanite.core.errors.UsageError: --rate HZ: put the sampling rate in Hz in the place of HZ
    """
    joined = (word.split("=", 1) for word in words if word.startswith("--") and "=" in word)
    for option, value in (*pairwise(words), *joined):
        match = re.search(PLACES[option], value) if option in PLACES else None
        if match:
            raise UsageError(f"{option} {value}: put {MEANINGS[match[1]]} in the place of {match[1]}")


def with_commas(words: list[str], command: click.Command) -> list[str]:
    """The words of a command in which names that stand behind a list belong to it: they are no files."""
    files = (isinstance(param, click.Argument) and isinstance(param.type, click.Path) for param in command.params)
    params = command.params if any(files) else []
    lists = {word for p in params if getattr(getattr(p.type, "kind", None), "control", "") == "list" for word in p.opts}
    at = next((i + 1 for i, word in enumerate(words[:-2]) if word in lists), len(words))
    more = list(takewhile(lambda word: re.fullmatch(r"\w+", word) and not os.path.exists(word), words[at + 1 :]))
    end = at + 1 + len(more)
    return [*words[:at], *filter(None, [",".join(words[at:end])]), *words[end:]]


Decorator = Callable[[Any], Any]


def _load_recipe(ctx: click.Context, param: click.Parameter, path: str | None) -> str | None:
    """Take the keys of a TOML file as defaults, which the command line overrides."""
    if path is None:
        return None
    options = {p.name: p for p in ctx.command.params if isinstance(p, click.Option) and p.name}
    inside = {name: p for name, p in options.items() if name not in ("recipe", *OUTPUTS, "coefficients", *FLAGS)}
    spelled = {word.lstrip("-").replace("-", "_"): name for name, p in inside.items() for word in p.opts}
    choices = {}
    for typed, value in load_toml(path).items():
        key = spelled.get(typed, typed)
        if key in options and key not in inside:
            raise UsageError(f"{path}: {key!r} is no key of a recipe; give {options[key].opts[0]} at the command line")
        demand_name("key", key, inside, where=" in the recipe")
        try:
            choices[key] = _kept(inside[key], value)
        except UsageError as error:
            raise error.within(f"{path}: {typed}") from None
    ctx.default_map = {**(ctx.default_map or {}), **choices}
    return path


def _kept(option: click.Option, value: Any) -> Any:
    """The value of a key as a default of its option; refused if it is of another type or form."""
    if isinstance(option.type, Converted):
        kind = option.type.kind
    else:
        form = "a path" if isinstance(option.type, click.Path) else "a number or text"
        kind = FLAG if option.is_flag else LINES if option.multiple else ChoiceKind("", str, form=form)
    parsed = kind.parse(value)
    return parsed if option.multiple else value


Names = tuple[str, ...]


class Option(click.Option):
    """An option with `synonyms` that are suggested, not taken, and `old` names that are taken, not shown."""

    def __init__(self, *args: Any, synonyms: Names = (), unlike: Names = (), old: Names = (), **form: Any) -> None:
        super().__init__(*args, **form)
        self.synonyms, self.unlike, self.old = synonyms, unlike, old

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Add it with its old names."""
        super().add_to_parser(parser, ctx)
        for name in self.old:
            table = parser._long_opt if name.startswith("--") else parser._short_opt
            table[name] = parser._long_opt[self.opts[0]]


class Alone(Option):
    """An option whose value may be omitted: what follows is taken for it only if it is one."""

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Give back to the parser what is no value."""
        super().add_to_parser(parser, ctx)
        for name in self.opts:
            row = parser._long_opt[name]
            row.process = self._given(row.process)

    def _given(self, process: Any) -> Any:
        def given(value: Any, state: Any) -> None:
            if isinstance(value, str) and value not in ("yes", "no") and not (value[:1].isdigit() and "," in value):
                state.rargs.insert(0, value)
                value = self.flag_value
            process(value, state)

        return given


def path_option(name: str, help: str, *synonyms: str) -> Decorator:  # noqa: A002 - the word of click
    """An option that names a file to be written."""
    return click.option(f"--{name}", metavar="PATH", type=click.Path(), help=help, cls=Option, synonyms=synonyms)


OUTPUTS = ("report", "plot", "csv", "json")  # names of the options that write a result

SHOWN = ("lang", "details", "brief", "force", "quiet")
"""Options about what is printed, and whether files are overwritten."""

FLAGS = (*SHOWN, "strict")  # options about writing and the exit code, which a recipe does not hold


def option_of(choice: ChoiceRow) -> Decorator:
    """The option of a choice."""
    if choice.kind is FLAG:
        return click.option(*choice.options, choice.name, is_flag=True, default=choice.default, help=choice.text)
    form: dict[str, Any] = {"type": Converted(choice.kind, choice.within)}
    if choice.kind.many:
        form = {"multiple": True, "callback": lambda _, __, values: values or None}
    form |= {"metavar": choice.metavar or None, "help": choice.text, "cls": Option, "synonyms": choice.synonyms,
             "unlike": choice.unlike, "old": choice.old}  # fmt: skip
    if choice.kind.alone:
        form |= {"cls": Alone, "is_flag": False, "flag_value": choice.kind.alone}
    return click.option(*choice.options, choice.name, **form)


OPTIONS: dict[str, Decorator] = {
    "file": click.argument("file", type=click.Path()),
    "optional file": click.argument("file", required=False, type=click.Path()),
    "some files": click.argument("files", nargs=-1, type=click.Path(), metavar="[FILE]..."),
    "files": click.argument("files", nargs=-1, required=True, type=click.Path(), metavar="FILE..."),
    "recipe": click.option("--recipe", metavar="TOML", type=click.Path(), is_eager=True, callback=_load_recipe,
        help="Read options from a file; the command line overrides them."),
    "seed": click.option("--seed", type=Converted(INTEGER, SEED), metavar="N", default=1, show_default=True,
        help="Seed of the random number generator."),
    "threads": click.option("--threads", type=Converted(THREADS), default="auto", show_default=True, metavar="N",
        help="Processors to use at once, or auto: all of them. The results are the same.",
        cls=Option, synonyms=("jobs", "workers", "cpus")),
    "orders": click.option("--orders", type=Converted(choices.INTEGERS), metavar="K,K,...", default="128,256",
        show_default=True, help="Harmonics of the angle to estimate."),
    "report": path_option("report", "Write a report: HTML, or PDF if PATH ends in .pdf.",
        "out", "output", "o", "html", "pdf", "save"),
    "plot": path_option("plot", "Write the figure: .png, .svg or .pdf; with {channel} in PATH one file a channel.",
        "figure", "png", "svg"),
    "json": path_option("json", "Write all results as JSON; - is standard output."),
    "csv": path_option("csv", "Write the numbers as CSV; - is standard output."),
    "coefficients": click.option("--coefficients", "--table", "coefficients", metavar="PATH", type=click.Path(),
        help="Write coefficients and values read off the curve as CSV; - is standard output."),
    "limits file": click.option("--limits", metavar="TOML", type=click.Path(),
        help="Check the coefficients against the limits in this file, or 'N < 0.15 deg/sqrt(h), B < 3 deg/h'; "
        "exit code 4 if one is exceeded."),
    "strict": click.option("--strict", is_flag=True,
        help="Exit with code 3 if a channel has no result, or no model explains its noise."),
    "lang": click.option("--lang", metavar="LANG", default=ENGLISH,
        help=f"Language of the summary, report and figure: {', '.join(LANGUAGES)}.  [default: {ENGLISH}]",
        cls=Option, synonyms=("language",)),
    "details": click.option("--details", is_flag=True, envvar="ALLANITE_DETAILS",
        help="Print all numbers, not the first screen of them."),
    "brief": click.option("--brief", is_flag=True, help="Print a line for each channel."),
    "force": click.option("--force", is_flag=True, help="Overwrite existing files.",
        cls=Option, synonyms=("overwrite", "yes")),
    "quiet": click.option("--quiet", is_flag=True, help="Print errors only, and what is written to standard output."),
    # options of the same name whose meaning differs between verbs
    "simulated rate": click.option("--rate", "--fs", "rate", type=Converted(HERTZ), required=True, metavar="HZ",
        help="Sampling rate."),
    "simulated unit": click.option("--unit", help="Unit of the samples.  [default: deg/h, ug]"),
    "simulated channels": click.option("--channels", type=NAMES, default="1", show_default=True, metavar="N",
        help="Number of independent channels, or their names, e.g. azimuth,tilt."),
    "simulated outliers": click.option("--outliers", metavar="SHARE SIZE",
        help="Outliers: '0.01% 20' (sigma) or '0.01% 50 deg/h'."),
    "simulated dither": click.option("--dither", metavar="HOW",
        help="Dither added before rounding and removed after: 'random' or '400 Hz 20' (steps)."),
    "reading interval": click.option("--interval", type=number(TIME), default=10.0, show_default=True, metavar="S",
        help="Sampling interval."),
    "reference rate": click.option("--reference", metavar="RATE", help="The true rate, in deg/h or e.g. '12.4 deg/h'."),
    "known bias": click.option("--bias", metavar="RATE", help="Known bias to subtract, in deg/h or e.g. '3 ug'."),
    "reference angle": click.option("--reference", required=True, metavar="COLUMN",
        help="Angle of the reference encoder."),
    "angle unit": click.option("--unit", help="Unit of angles, overrides the header: deg, rad, arcsec ..."),
    "angle time": click.option("--time", default="time", show_default=True, metavar="COLUMN",
        help="Seconds after h = 0."),
    "models": click.option("--model", "models", multiple=True, metavar="TERMS",
        help="Noise of a sensor without a file, e.g. 'N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)'; repeatable."),
    "origin": click.option("--file-of", "origin", metavar="TARGET", cls=Option, old=("--from",),
        help="VALUE is a file of this target: read its coefficients."),
    "claimed": click.option("--claims", "claims", multiple=True, metavar="FILE",
        help="Configuration of a filter or simulator, e.g. of kalibr; repeatable.", cls=Option, synonyms=("config",)),
    "filter": click.option("--filter", "filter_name", metavar="NAME",
        help="complementary, second-order, kalman, mahony, madgwick, bortz or accelerometer.  "
        "[default: complementary]"),
    "horizon": click.option("--horizon", "duration", type=Converted(DURATION), metavar="TIME",
        help="Time to predict without a recording.  [default: 1 h]", cls=Option, old=("--duration",)),
    "estimated sigma": click.option("--sigma", type=number(POSITIVE), metavar="ARCSEC",
        help="Noise of a sample.  [default: estimated]"),
    "given sigma": click.option("--sigma", type=number(SIZE), default=1.0, show_default=True, metavar="ARCSEC",
        help="Noise of a sample."),
    "angle trend": click.option("--trend", type=integer(0, 2), default=0, show_default=True,
        help="Degree of a polynomial drift estimated jointly."),
    "target": click.option("--to", "target", metavar="TARGET",
        help="Program that reads the file: kalibr, vins-mono, px4, ...; 'allanite explain' lists them.  "
        "[default: datasheet]", cls=Option, synonyms=("target", "format")),
    "autopilot": click.option("--to", "autopilot", metavar="NAME",
        help="Write temperature polynomials as parameters of px4 or ardupilot, to --output; --degree is 3 then.",
        cls=Option, synonyms=("target", "format")),
    "written file": click.option("--output", "-o", "output", metavar="PATH", type=click.Path(),
        help="Write the file; - is standard output. The suffix chooses the form if there are several.",
        cls=Option, synonyms=("out", "report", "save")),
    "written parameters": click.option("--output", "-o", "output", metavar="PATH", type=click.Path(),
        help="Write the parameters; - is standard output."),
    "lines that come": path_option("record", "Keep the lines that come in this file."),
    "corrected angles": path_option("corrected", "Write corrected angles as CSV."),
    "corrected record": path_option("corrected", "Write the corrected record (of --apply if given)."),
}  # fmt: skip

RECIPE = {name: option_of(row) for name, row in choices_of(Recipe).items()}  # the options of a recipe, by its keys
IDENTIFYING = (*IDENTIFIES, "strict")  # options of every verb that identifies noise
RESULTS = (*OUTPUTS, *SHOWN)  # options of every verb that has a result
RECORDING = (*READING, *SELECTING, "recipe", "threads")  # options of every verb that reads a recording


def options(*wanted: str | Decorator, settings: tuple[type[Any], ...] = ()) -> Decorator:
    """Give a command these options: names of choices in its `settings`, in `OPTIONS` or of a recipe, or its own."""
    own = {name: option_of(row) for kind in settings for name, row in choices_of(kind).items()}
    known = RECIPE | OPTIONS | own

    def give(command: Any) -> Any:
        for option in reversed(wanted):
            command = (known[option] if isinstance(option, str) else option)(command)
        return command

    return give
