"""The special jobs: ``allanite rate``, ``quantization``, ``compensate`` and ``vertical``."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import (  # isort: skip
    CompensationChoices, EstimatorChoices, FitChoices, IntervalChoices, RateChoices, VerticalChoices
)  # fmt: skip
from allanite.core.choices import NUMBERS
from allanite.core.errors import UnitError, UsageError
from allanite.core.ranges import POSITIVE, REAL

from .deliver import Extra, Outputs, carry_out, demand_recording, given, outputs, recipe_of, rendered, settings_of
from .helping import command
from .options import IDENTIFYING, RECORDING, RESULTS, Converted, Option, integer, number, options, path_option
from .streams import complain

if TYPE_CHECKING:
    from allanite.applications.attitude.scenarios import VerticalDesign
    from allanite.applications.constant_rate.campaign import RateSettings, RateStudy
    from allanite.exporting.target import ThermalTarget


@command()
@options(
    "file", *RECORDING,
    click.option("--stage", "stages", multiple=True, metavar="'NAME BITS SCALE'",
        help="A quantizer in the signal path, e.g. 'ADC 12 5V', 'ADC 12 5V gain=10' or 'output 16 100deg/s'; "
        "repeatable."),
    click.option("--torquer", metavar="A=X,...",
        help="Constants of the torquer in SI: turns, field (T), span (m), radius (m), inertia (kg m^2), spin (rad/s), "
        "sides."),
    click.option("--torque-scale", "scale_factor", type=number(REAL), metavar="K", cls=Option, old=("--scale-factor",),
        help="Or the scale factor of the torquer, rad/s per A."),
    click.option("--sense", type=number(POSITIVE), metavar="V/A", help="Gain of the current sensor, for voltages."),
    click.option("--coupling", type=Converted(NUMBERS, REAL), metavar="XX,XY,YX,YY",
        help="Two channels are the currents of the x and y torquers: rates about x and y over the scale factor, "
        "e.g. 0,-1,1,0 with cross-coupling in XX and YY."),
    *IDENTIFYING, path_option("rates", "Write the rates as a recording: .csv, .npz, ..."), *RESULTS,
)  # fmt: skip
def quantization(file: str, **choices: Any) -> None:
    """Estimate quantization (no error budget).

    Compares each stage of the signal path of FILE with the recorded noise. A current (--unit A), a voltage or codes
    (--unit 1) are converted to rates with the constants of the torquer.
    """
    out = outputs(choices, [file, choices["recipe"]], also=("rates",))
    demand_recording(out.paths.get("rates"))
    from allanite.applications.signals import Stage, TorqueScale
    from allanite.applications.signals.budgeting import PathSettings, budget_file

    torquer, factor = choices["torquer"], choices["scale_factor"]
    if torquer is not None and factor is not None:
        raise UsageError("the scale factor is given twice: use either --torquer or --torque-scale")
    scale = factor if torquer is None else TorqueScale.parse(torquer)
    settings = PathSettings(tuple(Stage.parse(text) for text in choices["stages"]), scale, choices["sense"],
                            choices["coupling"])  # fmt: skip
    extra = Extra(recordings={"rates": lambda study: study.rates})
    carry_out(lambda tell: budget_file(file, recipe_of(choices), settings, progress=tell), out, extra)


@command()
@options(
    "file", *RECORDING, "regressors", "derivative_of", "degree", "lags", "trend", "every", "smooth", "blocks", "least",
    "split_gaps", "beside", "interpolate", "use",
    click.option("--apply", "apply_to", metavar="FILE", type=click.Path(),
        help="Also correct this file, which is not used for the fit."),
    *IDENTIFYING, path_option("save", "Write the regressions, to be used with --use."), "corrected record", "autopilot",
    click.option("--instance", type=integer(0, 99), metavar="N",
        help="Number of the sensor there.  [default: the first]"),
    "written parameters", *RESULTS, settings=(CompensationChoices, FitChoices),
)  # fmt: skip
def compensate(file: str, **choices: Any) -> None:
    """Remove temperature-dependent errors.

    Estimates and removes the part of each channel of FILE that depends on other columns, such as a temperature. Prints
    the coefficients with confidence intervals and p-values, and the Allan deviation before and after. The noise model
    of the fit has the terms Q, N, B and K, or those given by --terms.
    """
    apply_to, autopilot, instance = (choices.pop(key) for key in ("apply_to", "autopilot", "instance"))
    read = [file, apply_to, *(choices[key] for key in ("beside", "use", "recipe"))]
    out = outputs(choices, read, also=("save", "corrected"))
    demand_recording(out.paths.get("corrected"))
    from allanite.applications.compensation.compensating import compensate_file
    from allanite.applications.compensation.regression import to_json
    from allanite.applications.compensation.settings import CompensationSettings, FitSettings
    from allanite.exporting.temperature import demand_settings, temperature_parameters

    row = _autopilot(autopilot, instance, out)
    recipe = recipe_of(choices)
    usual = {} if row is None else {"degree": row.order}
    settings = CompensationSettings(fit=settings_of(FitSettings, choices), **usual | given(choices))
    if row is not None:
        demand_settings(row, settings)

    def parameters(study: Any) -> bytes:
        made = temperature_parameters(study, str(autopilot), instance=instance)
        for alert in made.alerts:
            complain(f"allanite: {alert}")
        return made.data

    data: dict[str, Callable[[Any], str | bytes]] = {"save": lambda study: to_json(study.regressions),
                                                     "output": parameters}  # fmt: skip
    extra = Extra(data, {"corrected": lambda study: study.corrected})
    carry_out(lambda tell: compensate_file(file, recipe, settings, apply_to=apply_to, progress=tell), out, extra)


def _autopilot(name: str | None, instance: int | None, out: Outputs) -> "ThermalTarget | None":
    """The row of --to, which goes with --output."""
    from allanite.exporting.temperature import thermal_target

    if name is not None and "output" in out.paths:
        return thermal_target(name, instance)
    if name is not None:
        raise UsageError(f"--to {name} writes a file of parameters: name it with --output PATH; - is standard output")
    if "output" in out.paths or instance is not None:
        raise UsageError("--output and --instance are for the parameters of an autopilot: add --to px4 or --to "
                         "ardupilot; a corrected record is written with --corrected PATH")  # fmt: skip
    return None


DESIGNING = ("duration", "gyro_bias", "accelerometer_bias", "scenarios", "seed")
"""Options that apply without a recording."""

USUAL_DURATION_S = 3600.0  # horizon without a recording, s


@command()
@options(
    "optional file", *RECORDING, "gyro", "accelerometer", "filter", "time_constant", "bias_time", "gate",
    click.option("--coning", "samples", type=integer(1, 2), metavar="N",
                 help="Samples of the coning correction of bortz.  [default: 2]"),
    "axes", "keep_bias", "horizon",
    click.option("--gyro-bias", metavar="RATE", help="Constant bias of the gyro without a recording, e.g. '10 deg/h'."),
    click.option("--accelerometer-bias", metavar="BIAS",
                 help="Constant bias of the accelerometer without a recording, e.g. '50 ug'."),
    click.option("--scenarios", is_flag=True,
                 help="Without a recording: simulate all filters at rest, under acceleration and in oscillation."),
    "seed", *IDENTIFYING, *RESULTS, settings=(VerticalChoices,),
)  # fmt: skip
def vertical(file: str | None, **choices: Any) -> None:
    """Find roll and pitch.

    Takes three gyros and three accelerometers. The time constant with the least error follows from the noise, which is
    identified from the static recording FILE. Without FILE, --gyro and --accelerometer give the noise; prints the time
    constant, the predicted error by source and the loss against the optimal filter.
    """
    out = outputs(choices, [file, choices["recipe"]])
    if file is None:
        carry_out(lambda tell: _design(choices), out)
        return
    given = [key for key in DESIGNING if key != "seed" and choices.pop(key)]
    if given:
        raise UsageError(f"--{given[0].replace('_', '-')} applies without a recording only; omit it, or FILE")
    choices.pop("seed")
    from allanite.applications.attitude.result import VerticalSettings
    from allanite.applications.attitude.tuning import vertical as job

    identifying, choices["method"] = choices["method"], choices.pop("filter_name")
    settings = settings_of(VerticalSettings, choices)
    recipe = recipe_of({**choices, "method": identifying})
    carry_out(lambda tell: job(file, settings=settings, recipe=recipe, progress=tell), out)


def _design(choices: dict[str, Any]) -> "VerticalDesign":
    """The best filter for the given noise."""
    from allanite.applications.attitude import optimal_time_constant
    from allanite.applications.attitude.prediction import biases
    from allanite.applications.attitude.scenarios import design
    from allanite.core.model import Model

    if choices["gyro"] is None or choices["accelerometer"] is None:
        raise UsageError("give a recording, or the noise of both sensors with --gyro and --accelerometer, e.g. --gyro "
                         "'N 0.3 deg/sqrt(h), B 10 deg/h' --accelerometer 'N 100 ug/sqrt(Hz)'")  # fmt: skip
    allowed = {"gyro", "accelerometer", "rate", "level", "recipe", *DESIGNING}
    extra = [key for key, value in choices.items() if value not in (None, False) and key not in allowed]
    if extra:
        name = {"filter_name": "filter", "samples": "coning", "start": "from"}.get(extra[0], extra[0].replace("_", "-"))
        raise UsageError(f"--{name} applies to a recording, but none is given; omit it, or give FILE")
    noise = Model(choices["gyro"]), Model(choices["accelerometer"])
    bias = choices["gyro_bias"] or 0.0, choices["accelerometer_bias"] or 0.0
    seed, rate, duration = choices["seed"], choices["rate"], choices["duration"] or USUAL_DURATION_S
    optimum = optimal_time_constant(*noise, duration=duration, rate=rate, gyro_bias=bias[0], accelerometer_bias=bias[1])
    return design(optimum, bias=biases(*bias)[0], scenarios=choices["scenarios"], rate=rate, seed=seed)


@command()
@options(
    "file", *RECORDING, "interval", "methods", "target",
    "noise", "latitude", "reference rate", "known bias", "horizontal",
    click.option("--second", metavar="FILE", type=click.Path(),
        help="The same gyro in a second position: removes the bias."),
    "turned", "near", "position_method", "dither", "window", "lines",
    click.option("--allowed", metavar="RATE",
        help="Largest deviation of a regression line that the conditional estimator keeps."),
    "quantum", "certified", "descent", "split_gaps", "most", "durations",
    click.option("--no-times", is_flag=True, help="Do not compare measuring times."),
    *IDENTIFYING, path_option("readings", "Write the rate of every interval by every estimator as CSV."),
    path_option("closeup", "Draw the first interval: slopes of the regression lines by their start, the staircase over "
                "the counts."),
    *RESULTS, settings=(IntervalChoices, EstimatorChoices, FitChoices, RateChoices),
)  # fmt: skip
def rate(file: str, second: str | None, **choices: Any) -> None:
    """Measure a rotation rate, not a sampling rate.

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
        pairs = ((channel.record, channel.experiment) for channel in study)
        first = [first_of(record, experiment, study.settings) for record, experiment in pairs
                 if experiment is not None and isinstance(record, Record)]  # fmt: skip
        return rendered(first, "plot", out.paths["closeup"], out.lang)

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
        unit_row = unit_of(unit.strip() or "deg/h")
        signal = signal_with(unit_row.dimension)
        if signal is None:
            raise UnitError(f"a rate has a unit such as deg/h or ug, not {unit!r}")
        try:
            given[key] = float(number) * unit_row.factor
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
