"""What follows from a noise model, written out, of a typical sensor, or of a recording: plans, checks, state spaces."""

from typing import TYPE_CHECKING, Any

import click

from .deliver import carry_out, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, Duration, options

if TYPE_CHECKING:
    from allanite.study.modelled import ModelJob
    from allanite.study.modelling import Use

EXCEEDED = 4
"""Exit code where a limit is exceeded."""

NOISE = ("optional file", "model", "sensor", *RECORDING, *IDENTIFYING)
"""A recording, or a model of its noise."""


@click.command()
@options(
    *NOISE,
    "planned durations",
    click.option("--accuracy", type=float, metavar="PERCENT", help="Wanted relative standard error.  [10]"),
    click.option("--ramp/--no-ramp", default=None, help="Allow for a ramp of unknown size.  [if the model has one]"),
    *RESULTS,
)
def plan(file: str | None, **choices: Any) -> None:
    """Say how long to record for a wanted accuracy.

    The noise is that of --model or --sensor, or what a first recording FILE shows. Nothing is simulated.
    """
    from allanite.study.modelling import PlanSettings

    _run(PlanSettings, file, choices)


@click.command()
@options(
    *NOISE,
    "duration",
    "samples",
    click.option("--records", type=int, metavar="N", help="Records that are simulated.  [100]"),
    "seed",
    click.option("--max-bias", type=float, metavar="PERCENT", help="Limit: bias of the coefficients."),
    click.option("--min-coverage", type=float, metavar="PERCENT", help="Limit: coverage of the intervals."),
    click.option("--max-false", type=float, metavar="PERCENT", help="Limit: records with absent terms reported."),
    click.option("--max-missed", type=float, metavar="PERCENT", help="Limit: records with terms not found."),
    *(option for option in RESULTS if option != "plot"),
)
def selfcheck(file: str | None, **choices: Any) -> None:
    """Check the identification on simulated records.

    Prints bias, spread, coverage and errors beside the Cramer-Rao bound. The noise is that of --model or --sensor, or
    what a recording FILE shows, whose length is then taken. If a limit is given and exceeded by more than two
    Monte-Carlo standard errors, the exit code is 4.
    """
    from allanite.study.modelling import SelfCheckSettings

    found = _run(SelfCheckSettings, file, choices)
    for sentence in found.exceeded:
        click.echo(f"limit exceeded: {sentence}", err=True)
    if found.exceeded:
        raise click.exceptions.Exit(EXCEEDED)


@click.command()
@options(
    *NOISE,
    click.option("--tau", type=Duration(several=True), metavar="LO,HI", help="Where flicker is matched.  [1,1000]"),
    click.option("--ripple", type=float, metavar="PERCENT", help="Wanted deviation from flicker.  [2]"),
    click.option("--order", type=int, metavar="N", help="Gauss-Markov processes for flicker, instead."),
    click.option("--turn-on", metavar="RATE", help="Standard deviation of the bias at switch-on, as '3 deg/h'."),
    click.option("--measurement", metavar="NAME", help="auto, mean (exact) or sample.  [auto]"),
    *RESULTS,
)
def statespace(file: str | None, **choices: Any) -> None:
    """Print the noise as states for a Kalman filter.

    Transition, covariances, measurement. The noise is that of --model or --sensor, or what a recording FILE shows.
    Flicker becomes a sum of Gauss-Markov processes that is right between two averaging times.
    """
    from allanite.study.modelling import StateSpaceSettings

    _run(StateSpaceSettings, file, choices)


def _run(settings: "type[Use]", file: str | None, choices: dict[str, Any]) -> "ModelJob":
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.modelled import run_model_job

    use = settings_of(settings, choices)
    return carry_out(lambda tell: run_model_job(file, use, recipe_of(choices), progress=tell), out)
