"""Uses of a noise model, given explicitly, of a typical sensor or of a recording: plans, self-checks, state spaces."""

from typing import TYPE_CHECKING, Any

import click

from allanite.study.settings import CheckChoices, NoiseChoices, PlanChoices, StateSpaceChoices

from .deliver import carry_out, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .streams import complain

if TYPE_CHECKING:
    from allanite.study.modelling import Use

EXCEEDED = 4
"""Exit code if a limit is exceeded."""

NOISE = ("optional file", "model", "sensor", "datasheet", "unexplained", *RECORDING, *IDENTIFYING)
"""A recording, or a model of its noise."""


@click.command()
@options(*NOISE, "durations", "accuracy", "ramp", *RESULTS, settings=(NoiseChoices, PlanChoices))
def plan(file: str | None, **choices: Any) -> None:
    """Predict accuracy against record length.

    Uses the Cramer-Rao bound; nothing is simulated. The noise is that of --model, --sensor or --datasheet, or is
    identified from a recording FILE.
    """
    from allanite.study.modelling import PlanSettings

    _run(PlanSettings, file, choices)


@click.command()
@options(
    *NOISE, "duration", "samples", "records", "seed", "max_bias", "min_coverage", "max_false", "max_missed",
    *(option for option in RESULTS if option != "plot"), settings=(NoiseChoices, CheckChoices),
)  # fmt: skip
def selfcheck(file: str | None, **choices: Any) -> None:
    """Test the identification by simulation.

    Prints bias, spread, coverage and errors beside the Cramer-Rao bound. The noise is that of --model, --sensor or
    --datasheet, or is identified from a recording FILE, whose length is then used. If a given limit is exceeded by more
    than two Monte Carlo standard errors, the exit code is 4.
    """
    from allanite.study.modelling import SelfCheckSettings

    demand_kept(_run(SelfCheckSettings, file, choices))


def demand_kept(found: Any) -> None:
    """End with exit code 4, and say why, if a limit is exceeded."""
    for sentence in found.exceeded:
        complain(f"limit exceeded: {sentence}")
    if found.exceeded:
        raise click.exceptions.Exit(EXCEEDED)


@click.command()
@options(
    *NOISE, "tau", "ripple", "order", "turn_on", "measurement", *RESULTS, settings=(NoiseChoices, StateSpaceChoices),
)  # fmt: skip
def statespace(file: str | None, **choices: Any) -> None:
    """Export the noise as a state-space model.

    Prints the transition, covariance and measurement matrices of a Kalman filter. The noise is that of --model,
    --sensor or --datasheet, or is identified from a recording FILE. Flicker is approximated by a sum of Gauss-Markov
    processes between two averaging times.
    """
    from allanite.study.modelling import StateSpaceSettings

    _run(StateSpaceSettings, file, choices)


def _run(settings: "type[Use]", file: str | None, choices: dict[str, Any]) -> Any:
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.modelled import run_model_job

    use = settings_of(settings, choices)
    return carry_out(lambda tell: run_model_job(file, use, recipe_of(choices), progress=tell), out)
