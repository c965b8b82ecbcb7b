"""The options that every verb shares: what is in the file, and what becomes of the result."""

from collections.abc import Callable
from typing import Any

import click


def names(_: click.Context, __: click.Parameter, text: str | None) -> tuple[str, ...] | None:
    """Words between commas."""
    return None if text is None else tuple(name.strip() for name in text.split(","))


def _numbers(text: str) -> tuple[float, ...] | None:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        return None


def taus(_: click.Context, __: click.Parameter, text: str | None) -> str | tuple[float, ...] | None:
    """The name of a grid, or seconds between commas."""
    return None if text is None else _numbers(text) or text


def band(_: click.Context, __: click.Parameter, text: str | None) -> tuple[float, ...] | None:
    """Two frequencies."""
    if text is None:
        return None
    numbers = _numbers(text)
    if numbers is None or len(numbers) != 2:
        raise click.BadParameter(f"two frequencies in Hz are wanted, as 0.01,10, not {text!r}")
    return numbers


def scale(_: click.Context, __: click.Parameter, text: str | None) -> str | float | None:
    """A number, or a number with its unit."""
    numbers = None if text is None else _numbers(text)
    return numbers[0] if numbers else text


def reading(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command its file, and the options that say what is in it."""
    for option in reversed(READING):
        command = option(command)
    return command


READING = (
    click.argument("file", type=click.Path()),
    click.option("--rate", type=float, metavar="HZ", help="Sampling rate; wins over what the file says."),
    click.option("--unit", help="Unit of the readings: deg/s, deg/h, rad/s, arcsec, g, m/s^2, ..."),
    click.option("--kind", help="What a reading is: rate, increment, angle or count."),
    click.option(
        "--scale",
        callback=scale,
        metavar="WORTH",
        help="Worth of one step of the readings: 0.01 (in --unit) or 0.01deg/s.",
    ),
    click.option(
        "--channels", callback=names, metavar="A,B,...", help="Columns by name or number; all that fit if left out."
    ),
    click.option("--time", help="The column of time stamps."),
    click.option(
        "--dtype",
        metavar="TYPE",
        help="The file is raw binary of this type: i2, >i2, f4, ..., or u4,6i2 for mixed rows.",
    ),
    click.option("--columns", type=int, metavar="N", help="Numbers in a row of raw binary."),
    click.option("--offset", type=int, metavar="BYTES", help="Bytes before the first row of raw binary."),
    click.option(
        "--from", "start", type=float, metavar="S", help="Start of the window, seconds after the first sample."
    ),
    click.option("--until", type=float, metavar="S", help="End of the window."),
    click.option("--quiet-window", type=float, metavar="S", help="Take the stillest stretch of this length, seconds."),
)


outliers = click.option(
    "--outliers",
    metavar="WORD",
    help="mark: leave them out of everything; keep: out of nothing.  [out of the fit, not of curves]",
)


def results(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that say where its result goes."""
    for option in reversed(RESULTS):
        command = option(command)
    return command


RESULTS = (
    outliers,
    click.option("--to", "unit_shown", metavar="UNIT", help="Unit of the result.  [deg/h, ug]"),
    click.option("--level", type=float, help="Confidence level of intervals.  [0.95]"),
    click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf."),
    click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output."),
    click.option("--csv", metavar="PATH", type=click.Path(), help="Write all values as CSV; - is standard output."),
    click.option("--force", is_flag=True, help="Overwrite files that exist."),
    click.option(
        "--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output by --json or --csv."
    ),
)


def factors(_: click.Context, __: click.Parameter, text: str | None) -> tuple[int, ...] | None:
    """Averaging factors between commas."""
    if text is None:
        return None
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"integers are wanted, as 1,10,100, not {text!r}") from None
