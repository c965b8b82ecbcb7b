"""Options that the commands of `allanite angle` share, and how their texts are read."""

from collections.abc import Callable
from typing import Any

import click

Option = Callable[[Callable[..., Any]], Callable[..., Any]]


def numbers(count: int, what: str) -> Callable[..., tuple[float, ...] | None]:
    """A callback that reads so many numbers with commas between them."""

    def parse(_: click.Context, __: click.Parameter, text: str | None) -> tuple[float, ...] | None:
        if text is None:
            return None
        try:
            found = tuple(float(part) for part in text.split(","))
        except ValueError:
            found = ()
        if len(found) != count:
            raise click.BadParameter(f"{what} wanted, not {text!r}")
        return found

    return parse


def orders_option(_: click.Context, __: click.Parameter, text: str) -> tuple[int, ...]:
    """Whole numbers with commas between them."""
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"whole numbers such as 128,256 are wanted, not {text!r}") from None


def words(_: click.Context, __: click.Parameter, text: str | None) -> tuple[str, ...] | None:
    """Names with commas between them."""
    return None if text is None else tuple(part.strip() for part in text.split(",") if part.strip())


def options(*several: Option) -> Option:
    """Several options as one."""

    def give(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(several):
            command = option(command)
        return command

    return give


ORDERS = click.option(
    "--orders",
    callback=orders_option,
    metavar="K,K,...",
    default="128,256",
    show_default=True,
    help="Harmonics of the angle.",
)
LEVEL = click.option("--level", type=float, default=0.95, show_default=True, help="Confidence level of intervals.")
OUTPUTS = options(
    click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page."),
    click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf."),
    click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output."),
    click.option("--csv", metavar="PATH", type=click.Path(), help="Write the numbers as CSV; - is standard output."),
    click.option("--force", is_flag=True, help="Overwrite files that exist."),
    click.option("--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output."),
)
EXPERIMENT = options(
    click.option("--latitude", type=float, required=True, metavar="DEG", help="Of the place."),
    click.option("--duration", type=float, required=True, metavar="S", help="Of the experiment."),
    click.option("--interval", type=float, default=10.0, show_default=True, metavar="S", help="Between readings."),
    click.option(
        "--q-law", default="exact", show_default=True, help="Of the outer angle: exact, or linear as printed."
    ),
    click.option("--turn-period", type=float, default=300.0, show_default=True, metavar="S", help="Auto-compensation."),
    click.option(
        "--sway", callback=numbers(2, "amplitude in deg and period in s are"), metavar="DEG,S", help="Roll and pitch."
    ),
)
