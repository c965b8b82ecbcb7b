"""``allanite rate``: the constant rate of a gyro by every method, with confidence limits."""

from typing import TYPE_CHECKING, Any

import click

from allanite.core.errors import UnitError, UsageError

from .deliver import carry_out, given, outputs, recipe_of, settings_of
from .options import IDENTIFYING, NAMES, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.core.units import Signal
    from allanite.rate.study import RateSettings


@click.command()
@options(
    "file",
    *RECORDING,
    "measuring interval",
    click.option("--methods", type=NAMES, metavar="A,B,...", help="Names of estimators, as mean,optimal.  [all]"),
    click.option("--target", metavar="WHAT", help="If the rate wanders: its mean, centre or start.  [mean]"),
    click.option("--noise", metavar="TERMS", help="The noise, as 'N 0.003 deg/sqrt(h), Q 0.2 arcsec'.  [identified]"),
    "latitude",
    "reference rate",
    click.option("--bias", metavar="RATE", help="A known bias to subtract, in deg/h or as '3 ug'."),
    click.option("--horizontal", is_flag=True, help="The axis is horizontal: find north at --latitude."),
    click.option("--second", metavar="FILE", type=click.Path(), help="The same gyro, turned: removes the bias."),
    click.option("--turned", type=float, metavar="DEG", help="How far it was turned.  [180]"),
    click.option(
        "--near",
        type=float,
        metavar="DEG",
        help="Approximate heading, degrees; resolves the two north solutions.  [90]",
    ),
    click.option("--position-method", metavar="NAME", help="Estimator for north and the bias.  [optimal]"),
    "dither lines",
    "rate window",
    click.option("--lines", type=int, metavar="N", help="Lines of the estimator conditional."),
    click.option("--allowed", metavar="RATE", help="Deviation of a line of conditional that is kept."),
    click.option("--quantum", type=float, help="Step of the angle in --unit, where readings are not counts."),
    click.option("--certified", is_flag=True, help="Search the staircase until none can be better."),
    "split-gaps",
    click.option("--most", type=int, metavar="N", help="Most intervals that are measured."),
    "measuring durations",
    click.option("--no-times", is_flag=True, help="Do not compare measuring times."),
    *IDENTIFYING,
    *RESULTS,
)
def rate(file: str, second: str | None, **choices: Any) -> None:
    """Measure the constant rate of every channel of FILE.

    Measures it in short intervals, by every method. Prints how the methods scatter, the errors that the noise predicts,
    and which method to use.
    """
    out = outputs(choices, [file, second, choices["recipe"]])
    from allanite.rate.study import measure_rates

    recipe = recipe_of(choices)
    settings = _settings(given(choices))
    carry_out(lambda tell: measure_rates(file, recipe, settings, second=second, progress=tell), out)


def _settings(given: dict[str, Any]) -> "RateSettings":
    """The settings of a study from the options that were given, which are taken out of `given`."""
    from allanite.core.notation import parse_model
    from allanite.rate import EstimatorSettings, ExperimentSettings
    from allanite.rate.study import RateSettings

    if "latitude" in given and "reference" in given and not given["horizontal"]:
        raise UsageError("the true rate is given twice: by --latitude and by --reference")
    signals = _rates(given)
    if given.pop("no_times"):
        given["durations"] = ()
    if "noise" in given:
        given["noise"] = parse_model(given["noise"])
    given["gaps"] = "split" if given.pop("split_gaps") else "error"
    given["options"] = settings_of(EstimatorSettings, given)
    given["experiment"] = settings_of(ExperimentSettings, given)
    return RateSettings(**given, signal=signals[-1] if signals else None)


def _rates(given: dict[str, Any]) -> "list[Signal]":
    """Replace the texts of rates by their SI values; the signals that they are of."""
    signals = []
    for key in ("reference", "bias", "allowed"):
        if key in given:
            given[key], signal = _quantity(str(given[key]))
            signals.append(signal)
    if len({signal.name for signal in signals}) > 1:
        raise UsageError("the true rate and the bias are given in units of different sensors")
    return signals


def _quantity(text: str) -> "tuple[float, Signal]":
    """A number with the unit of a signal, or in deg/h: its SI value and the signal."""
    from allanite.core.units import signal_with, unit_of

    number, _, unit = text.strip().partition(" ")
    found = unit_of(unit.strip() or "deg/h")
    signal = signal_with(found.dimension)
    if signal is None:
        raise UnitError(f"a rate has a unit such as deg/h or ug, not {unit!r}")
    try:
        return float(number) * found.factor, signal
    except ValueError:
        raise UsageError(f"a rate is a number and its unit, as '12.4 deg/h', not {text!r}") from None
