"""``allanite rate``: the constant rate of a gyro by every estimator, with confidence intervals."""

from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import EstimatorChoices, FitChoices, IntervalChoices, RateChoices
from allanite.core.errors import UnitError, UsageError

from .deliver import Extra, carry_out, given, outputs, recipe_of, settings_of
from .forms import encoded
from .options import IDENTIFYING, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.applications.constant_rate.campaign import RateSettings, RateStudy


@click.command()
@options(
    "file", *RECORDING, "interval", "methods", "target",
    "noise", "latitude", "reference rate", "known bias", "horizontal",
    click.option("--second", metavar="FILE", type=click.Path(),
        help="The same gyro in a second position: removes the bias."),
    "turned", "near", "position_method",
    "dither", "window", "lines",
    click.option("--allowed", metavar="RATE",
        help="Largest deviation of a regression line that the conditional estimator keeps."),
    "quantum", "certified", "split_gaps", "most", "durations",
    click.option("--no-times", is_flag=True, help="Do not compare measuring times."),
    *IDENTIFYING,
    click.option(
        "--readings", metavar="PATH", type=click.Path(),
        help="Write the rate of every interval by every estimator as CSV.",
    ),
    click.option(
        "--closeup", metavar="PATH", type=click.Path(),
        help="Draw the first interval: slopes of the regression lines by their start, the staircase over the counts.",
    ),
    *RESULTS, settings=(IntervalChoices, EstimatorChoices, FitChoices, RateChoices),
)  # fmt: skip
def rate(file: str, second: str | None, **choices: Any) -> None:
    """Estimate the constant rate of a gyro.

    Measures the rate of every channel of FILE in short intervals with every estimator. Prints the scatter of each
    estimator, the standard error predicted by the noise model, and the recommended estimator.
    """
    out = outputs(choices, [file, second, choices["recipe"]], also=("readings", "closeup"))
    if "closeup" in out.paths:
        from allanite.reporting.style import demand_figure_path

        demand_figure_path(out.paths["closeup"], force=out.force)
    from allanite.applications.constant_rate.campaign import measure_rates
    from allanite.core.record import Record
    from allanite.reporting import to_csv
    from allanite.reporting.views.rate import first_of

    recipe = recipe_of(choices)
    settings = _settings(given(choices))

    def closeups(study: "RateStudy") -> str | bytes:
        """The figure of the first interval of every channel."""
        first = [
            first_of(channel.record, channel.experiment, study.settings)
            for channel in study
            if channel.experiment is not None and isinstance(channel.record, Record)
        ]
        return encoded(first, "plot", out.paths["closeup"], out.lang)

    extra = Extra({"readings": lambda study: to_csv(study, coefficients=True), "closeup": closeups})
    carry_out(lambda tell: measure_rates(file, recipe, settings, second=second, progress=tell), out, extra)


def _settings(given: dict[str, Any]) -> "RateSettings":
    """The settings of a study from the options given, which are taken out of `given`."""
    from allanite.applications.constant_rate import EstimatorSettings, ExperimentSettings
    from allanite.applications.constant_rate.campaign import RateSettings
    from allanite.core.units import signal_with, unit_of

    if "latitude" in given and "reference" in given and not given["horizontal"]:
        raise UsageError("the true rate is given twice: use either --latitude or --reference")
    signals = []
    for key in [key for key in ("reference", "bias", "allowed") if key in given]:
        # a number with the unit of a signal, or in deg/h
        number, _, unit = str(given[key]).strip().partition(" ")
        found = unit_of(unit.strip() or "deg/h")
        signal = signal_with(found.dimension)
        if signal is None:
            raise UnitError(f"a rate has a unit such as deg/h or ug, not {unit!r}")
        try:
            given[key] = float(number) * found.factor
        except ValueError:
            words = f"a rate is a number with its unit, e.g. '12.4 deg/h', not {str(given[key])!r}"
            raise UsageError(words) from None
        signals.append(signal)
    if len({signal.name for signal in signals}) > 1:
        raise UsageError("the true rate and the bias have units of different sensors")
    if given.pop("no_times"):
        given["durations"] = ()
    given["gaps"] = "split" if given.pop("split_gaps") else "error"
    given["options"] = settings_of(EstimatorSettings, given)
    given["experiment"] = settings_of(ExperimentSettings, given)
    return RateSettings(**given, signal=signals[-1] if signals else None)
