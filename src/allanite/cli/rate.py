"""``allanite rate``: the constant rate of a laser gyro, by every method, and how sure each is."""

import shutil
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from allanite.core.files import write
from allanite.reporting.outputs import STDOUT, demand_outputs

if TYPE_CHECKING:
    from allanite.core.units import Signal
    from allanite.rate.study import RateChoices, RateStudy

WIDTH = 120
"""Columns of text that no terminal bounds."""

READ = (
    *("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset"),
    *("start", "until", "quiet_window", "terms", "level"),
)
"""Options that are the recipe's."""

OUTPUTS = ("report", "plot", "json")

OPTIONS = (
    click.option("--interval", type=float, metavar="S", default=120.0, help="Measuring time.  [120]"),
    click.option("--methods", metavar="A,B,...", help="Names of methods, for example mean,optimal.  [all]"),
    click.option("--target", metavar="WHAT", default="mean", help="If the rate wanders: its mean, centre or start."),
    click.option("--noise", metavar="TERMS", help="The noise, as 'N 0.003 deg/sqrt(h), Q 0.2 arcsec'.  [identified]"),
    click.option("--terms", metavar="QNBKR", help="Terms to look for.  [auto]"),
    click.option("--latitude", type=float, metavar="DEG", help="The earth's rate there is the true rate."),
    click.option("--reference", metavar="RATE", help="The true rate, in deg/h or as '12.4 deg/h'."),
    click.option("--bias", metavar="RATE", help="A known bias to subtract, in deg/h or as '3 ug'."),
    click.option("--horizontal", is_flag=True, help="The axis is horizontal: find north at --latitude."),
    click.option("--second", metavar="FILE", type=click.Path(), help="The same gyro, turned: removes the bias."),
    click.option("--turned", type=float, default=180.0, metavar="DEG", help="How far it was turned.  [180]"),
    click.option("--near", type=float, default=90.0, metavar="DEG", help="What is known of the heading.  [90]"),
    click.option("--dither", metavar="HZ,...", help="Frequencies of the dither's residual, to be taken out."),
    click.option("--window", metavar="NAME", default="hamming", help="Window of the method hamming."),
    click.option("--lines", type=int, metavar="N", help="Lines of the method conditional."),
    click.option("--quantum", type=float, help="Step of the angle in --unit, where readings are no counts."),
    click.option("--certified", is_flag=True, help="Search the staircase until none can be better."),
    click.option("--split-gaps", is_flag=True, help="Measure between lost readings."),
    click.option("--no-times", is_flag=True, help="Do not compare measuring times."),
    click.option("--level", type=float, help="Confidence level of intervals.  [0.95]"),
    click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page."),
    click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf."),
    click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output."),
    click.option("--force", is_flag=True, help="Overwrite files that exist."),
    click.option("--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output by --json."),
)


def options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of this verb."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@options
def rate(file: str, *, force: bool, quiet: bool, second: str | None, **choices: Any) -> None:
    """Measure the constant rate of every channel of FILE in short intervals, by every method.

    Prints how the methods scatter, what the noise lets one expect, and which method to use.
    """
    paths = {name: path for name in OUTPUTS if (path := choices.pop(name)) is not None}
    demand_outputs(paths, inputs=[file, *([second] if second else [])], force=force)
    from allanite.rate.study import measure_rates
    from allanite.reporting.progress import bar
    from allanite.study.analysis import Recipe

    recipe = Recipe.from_dict({key: choices[key] for key in READ if choices.get(key) is not None})
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        study = measure_rates(file, recipe, _choices(**choices), second=second, progress=progress)
    silent = STDOUT in paths.values()
    if not (quiet or silent):
        _print(study)
    for name, path in paths.items():
        _put(path, _encoded(study, name, path), force=force)
        if path != STDOUT and not quiet:
            click.echo(f"{name}: {path}", err=silent)


def _choices(*, latitude: float | None, reference: str | None, bias: str | None, **rest: Any) -> "RateChoices":
    from allanite.core.errors import UsageError
    from allanite.core.notation import parse_model
    from allanite.rate import RATE_ESTIMATORS, Options, Plan
    from allanite.rate.study import DURATIONS, RateChoices

    if latitude is not None and reference is not None:
        raise UsageError("the true rate is given twice: by --latitude and by --reference")
    known = [None if text is None else _quantity(text) for text in (reference, bias)]
    signals = [quantity[1] for quantity in known if quantity is not None]
    if len({signal.name for signal in signals}) > 1:
        raise UsageError("the true rate and the bias are given in units of different sensors")
    noise, dither = rest["noise"], rest["dither"]
    return RateChoices(
        plan=Plan(
            interval=rest["interval"],
            methods=_words(rest["methods"]) or tuple(RATE_ESTIMATORS),
            target=rest["target"],
            dither=() if dither is None else tuple(_number(text, "--dither") for text in _words(dither)),
            options=Options(rest["window"], rest["lines"], None, rest["quantum"], rest["certified"]),
            reference=None if known[0] is None else known[0][0],
            bias=0.0 if known[1] is None else known[1][0],
            gaps="split" if rest["split_gaps"] else "error",
        ),
        model=None if noise is None else parse_model(noise),
        signal=signals[-1] if signals else None,
        latitude=latitude,
        horizontal=rest["horizontal"],
        turned=rest["turned"],
        near=rest["near"],
        durations=() if rest["no_times"] else DURATIONS,
    )


def _quantity(text: str) -> "tuple[float, Signal]":
    """A number with the unit of a signal, or in deg/h: its SI value and the signal."""
    from allanite.core.errors import UnitError
    from allanite.core.units import signal_with, unit_of

    number, _, unit = text.strip().partition(" ")
    found = unit_of(unit or "deg/h")
    signal = signal_with(found.dimension)
    if signal is None:
        raise UnitError(f"a rate has a unit such as deg/h or ug, not {unit!r}")
    return _number(number, text) * found.factor, signal


def _words(text: str | None) -> tuple[str, ...]:
    return () if text is None else tuple(part.strip() for part in text.split(","))


def _number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"{option!r} wants a number, not {text!r}") from None


def _print(study: "RateStudy") -> None:
    from allanite.reporting.rate import rate_text

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDTH
    encoding = sys.stdout.encoding or "utf-8"
    click.echo(rate_text(study, width).encode(encoding, "backslashreplace").decode(encoding), nl=False)


def _encoded(study: "RateStudy", name: str, path: str) -> bytes:
    from allanite.reporting import rate as report
    from allanite.reporting.plain import to_json

    made: dict[str, Callable[[], bytes]] = {
        "report": lambda: report.rate_page(study).encode(),
        "plot": lambda: report.rate_figure(study, path),
        "json": lambda: to_json(study).encode(),
    }
    return made[name]()


def _put(path: str, data: bytes, *, force: bool) -> None:
    if path == STDOUT:
        click.echo(data, nl=False)
    else:
        write(path, data, force=force)
