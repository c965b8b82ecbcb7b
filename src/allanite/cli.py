"""The command line: parse, analyze, render. One verb is one function and one line of `VERBS`."""

import errno
import os
import shutil
import sys
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from allanite import __version__
from allanite.errors import AllaniteError
from allanite.report.files import write
from allanite.report.outputs import OUTPUTS, STDOUT, demand_outputs
from allanite.verbs.rate import rate

if TYPE_CHECKING:
    from allanite.study import Recipe, Study

WIDTH = 120
"""Columns of text that no terminal bounds."""

DEFECT, DATA, INTERRUPTED = 1, 3, 130
TRACKER = "https://github.com/allanite/allanite/issues"


class Failure(click.ClickException):
    """What ends the program with a sentence on stderr and the exit code `status`; `trace` is for who asked for it."""

    def __init__(self, message: str, status: int, trace: str = "") -> None:
        super().__init__(message)
        self.status, self.trace = status, trace


class Front(click.Group):
    """A group of verbs that ends with a sentence and the exit codes of the design, never with a traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the verb; whatever goes wrong becomes a `Failure`."""
        try:
            super().invoke(ctx)
            sys.stdout.flush()
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except Exception as error:
            if isinstance(error, OSError) and error.errno == errno.EPIPE:
                _close_stdout()
                return
            raise _failure(error, debug=ctx.params["debug"]) from None

    def main(self, *args: Any, **extra: Any) -> Any:
        """Parse, run, and end the program."""
        extra["standalone_mode"] = False
        try:
            code = super().main(*args, **extra) or 0
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            code = error.exit_code
        except click.Abort:
            code = _complain("interrupted", INTERRUPTED)
        except Failure as failure:
            code = _complain(failure.message, failure.status)
            click.echo(failure.trace, err=True, nl=False)
        except click.ClickException as error:
            code = _complain(error.format_message(), error.exit_code)
            context = getattr(error, "ctx", None)
            if context is not None:
                click.echo(f"try '{context.command_path} --help'", err=True)
        sys.exit(code)


def _complain(message: str, code: int) -> int:
    click.echo(click.style("error: ", fg="red", bold=True) + message, err=True)
    return code


def _failure(error: Exception, *, debug: bool) -> Failure:
    if isinstance(error, AllaniteError):
        return Failure(str(error), error.exit_code)
    if isinstance(error, MemoryError):
        advice = "read fewer channels (--channels) or a part of the record (--from, --until)"
        return Failure(f"there is not enough memory; {advice}", DATA)
    what = f"{type(error).__name__}: {error}".removesuffix(": ")
    report = f"this is a defect of allanite ({what}); please report it with the command and the file: {TRACKER}"
    return Failure(report, DEFECT, "".join(traceback.format_exception(error)) if debug else "")


def _close_stdout() -> None:
    """The reader has seen enough: nothing more is written, not even at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _names(_: click.Context, __: click.Parameter, text: str | None) -> tuple[str, ...] | None:
    return None if text is None else tuple(name.strip() for name in text.split(","))


def _numbers(text: str) -> tuple[float, ...] | None:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        return None


def _taus(_: click.Context, __: click.Parameter, text: str | None) -> str | tuple[float, ...] | None:
    return None if text is None else _numbers(text) or text


def _band(_: click.Context, __: click.Parameter, text: str | None) -> tuple[float, ...] | None:
    if text is None:
        return None
    numbers = _numbers(text)
    if numbers is None or len(numbers) != 2:
        raise click.BadParameter(f"two frequencies in Hz are wanted, as 0.01,10, not {text!r}")
    return numbers


def _reading(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command its file, and the options that say what is in it."""
    for option in reversed(READING):
        command = option(command)
    return command


READING = (
    click.argument("file", type=click.Path()),
    click.option("--rate", type=float, metavar="HZ", help="Sampling rate; wins over what the file says."),
    click.option("--unit", help="Unit of the readings: deg/s, deg/h, rad/s, arcsec, g, m/s^2, ..."),
    click.option("--kind", help="What a reading is: rate, increment, angle or count."),
    click.option("--scale", type=float, help="Worth of one step of the readings, in --unit."),
    click.option(
        "--channels", callback=_names, metavar="A,B,...", help="Columns by name or number; all that fit if left out."
    ),
    click.option("--time", help="The column of time stamps."),
    click.option(
        "--from", "start", type=float, metavar="S", help="Start of the window, seconds after the first sample."
    ),
    click.option("--until", type=float, metavar="S", help="End of the window."),
    click.option("--quiet-window", type=float, metavar="S", help="Take the stillest stretch of this length, seconds."),
)


@click.command()
@_reading
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
def info(file: str, *, json: str | None, force: bool, **choices: Any) -> None:
    """Say what is in FILE, and whether it is fit for the job."""
    paths = {} if json is None else {"json": json}
    demand_outputs(paths, inputs=[file], force=force)
    from allanite.report.progress import bar
    from allanite.study import examine

    with bar(shown=sys.stderr.isatty()) as progress:
        study = examine(file, _recipe(None, choices), progress=progress)
    if json != STDOUT:
        _print_table(study)
    if json is not None:
        _put(json, OUTPUTS["json"](study, json), force=force)
    if all(channel.refusal for channel in study.channels):
        raise click.exceptions.Exit(DATA)


@click.command()
@_reading
@click.option("--statistic", metavar="NAME", help="Statistic of the curve.  [oadev]")
@click.option("--taus", callback=_taus, metavar="GRID", help="octave, decade, log, all, or seconds as 1,10,100.  [log]")
@click.option("--terms", metavar="QNBKR", help="Terms to look for.  [auto]")
@click.option("--method", metavar="NAME", help="How the coefficients are found.  [whittle]")
@click.option("--band", callback=_band, metavar="LO,HI", help="Frequencies that are used, Hz.")
@click.option("--level", type=float, help="Confidence level of intervals.  [0.95]")
@click.option("--recipe", metavar="TOML", type=click.Path(), help="All of these choices from a file; options here win.")
@click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page.")
@click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf.")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--csv", metavar="PATH", type=click.Path(), help="Write the curves as CSV; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
@click.option(
    "--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output by --json or --csv."
)
def analyze(file: str, *, recipe: str | None, force: bool, quiet: bool, **choices: Any) -> None:
    """Find the noise coefficients of every channel of FILE, with intervals.

    Prints a table for each channel; --report writes the page with the figures.
    """
    paths = {name: path for name in OUTPUTS if (path := choices.pop(name)) is not None}
    demand_outputs(paths, inputs=[file, *([recipe] if recipe else [])], force=force)
    from allanite.report.progress import bar
    from allanite.study import analyze as run

    plan = _recipe(recipe, choices)
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        study = run(file, plan, progress=progress)
    silent = STDOUT in paths.values()
    if not (quiet or silent):
        _print_table(study)
    for name, path in paths.items():
        _put(path, OUTPUTS[name](study, path), force=force)
        if path != STDOUT and not quiet:
            click.echo(f"{name}: {path}", err=silent)


def _put(path: str, data: bytes, *, force: bool) -> None:
    if path == STDOUT:
        click.echo(data, nl=False)
    else:
        write(path, data, force=force)


def _recipe(path: str | None, choices: dict[str, Any]) -> "Recipe":
    """What the recipe file says, and over it what the command line says."""
    from allanite.study import Recipe

    base = Recipe.load(path).to_dict() if path else {}
    return Recipe.from_dict(base | {key: value for key, value in choices.items() if value is not None})


def _print_table(study: "Study") -> None:
    from allanite.report import table

    terminal = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns if terminal else WIDTH
    text = table(study, width=width, color=terminal and "NO_COLOR" not in os.environ)
    # a terminal that does not know a letter gets its number, not an error
    encoding = sys.stdout.encoding or "utf-8"
    click.echo(text.encode(encoding, "backslashreplace").decode(encoding), nl=False)


VERBS: dict[str, click.Command] = {
    "info": info,
    "analyze": analyze,
    "rate": click.command("rate")(_reading(rate)),
}


@click.group(cls=Front, commands=VERBS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="allanite")
@click.option("--debug", is_flag=True, envvar="ALLANITE_DEBUG", help="Show where a defect is.")
def main(debug: bool) -> None:
    """Noise coefficients of gyroscopes and accelerometers, with honest intervals."""


if __name__ == "__main__":
    main()
