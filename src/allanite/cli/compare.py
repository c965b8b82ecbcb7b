"""What is held against a requirement or a claim: ``allanite compare``, ``check``, ``drift``, ``plan`` and the like."""

from typing import TYPE_CHECKING, Any

import click

from allanite.core.errors import UsageError

from allanite.study.settings import (  # isort: skip
    CheckChoices, ClaimChoices, ComparisonChoices, DriftChoices, NoiseChoices, PlanChoices, StateSpaceChoices
)  # fmt: skip

from .deliver import carry_out, outputs, recipe_of, settings_of
from .front import EXCEEDED
from .helping import command
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .streams import complain
from .tasks import COMPARE, perform

if TYPE_CHECKING:
    from allanite.study.modelled import Use


@command()
@options("files", *RECORDING, "against", "part", "datasheet", "pool", "statistic", "taus", *IDENTIFYING, *RESULTS,
         settings=(ComparisonChoices,))  # fmt: skip
def compare(files: tuple[str, ...], **choices: Any) -> None:
    """Compare the noise of recordings.

    Two files: before and after. One file: its channels with each other, with --part its beginning with the rest, or
    with --datasheet what was measured with what a data sheet says. Three or more files (or channels of one file): their
    common noise, and which of them differs; with --pool that of two files, too.
    """
    perform(COMPARE, files, choices)


@command()
@options("file", "claims", "claims_from", "at_most", "tolerance", *RECORDING, *IDENTIFYING, *RESULTS,
         settings=(ClaimChoices,))  # fmt: skip
def check(file: str, **choices: Any) -> None:
    """Check whether FILE has the claimed noise.

    --claims names a file of a filter or simulator (kalibr, gazebo, px4 ...), a limits file, a data sheet, or a model.
    Files and models claim exact values, data sheets and limits upper bounds. Each number is compared with the record:
    the factor with its interval, and the convention that explains it (sqrt(2), sqrt(rate), 57.3 ...). Settings of the
    sensor may be claimed, too: 'lowpass 42 Hz, rate 100 Hz'.

    Exit codes: 0 if the record agrees, 4 if it contradicts the claim, 3 if it cannot be read.
    """
    from allanite.claims.checking import check as checked

    out = outputs(choices, [file, choices["recipe"], choices["claims"]])
    how = settings_of(ClaimChoices, choices)
    if how.claims is None:
        raise UsageError("say what is claimed: --claims with a file, a data sheet or a model, e.g. --claims 'N 0.3 "
                         "deg/sqrt(h)'", choice="claims")  # fmt: skip
    claims, recipe = how.claims, recipe_of(choices)
    result = carry_out(lambda tell: checked(file, claims, recipe, claims_from=how.claims_from, at_most=how.at_most,
                                            tolerance=how.tolerance, progress=tell), out)  # fmt: skip
    if not result.agrees:
        raise click.exceptions.Exit(EXCEEDED)


@command()
@options("some files", "models", "sensor", "datasheet", "claimed", "times", "calibration", "turn_on", "scale_factor",
         "maneuver", "platform", "schuler", "require", "unexplained", "from_curve", *RECORDING, *IDENTIFYING, *RESULTS,
         settings=(NoiseChoices, DriftChoices))  # fmt: skip
def drift(files: tuple[str, ...], models: tuple[str, ...], claims: tuple[str, ...], **choices: Any) -> None:
    """Predict navigation errors (not bias drift).

    FILES are recordings of gyros, accelerometers or both, or results that analyze has written with --json; --model,
    --sensor, --datasheet and --claims give the noise without a recording. Prints the standard deviation of each
    quantity with time without aid, and which noise causes it. With --require, the coefficients that are allowed; if a
    drift is larger, the exit code is 4.
    """
    from allanite.claims.claim import claim_of
    from allanite.claims.drift_settings import DriftSettings
    from allanite.claims.drifting import drift_of
    from allanite.exporting.imported import load
    from allanite.planning.datasheets import sensor as typical

    sensor, datasheet = choices.pop("sensor"), choices.pop("datasheet")
    models = (*models, datasheet) if datasheet else models
    out = outputs(choices, [*files, choices["recipe"]])
    settings = settings_of(DriftSettings, choices)
    recipe = recipe_of(choices)
    given = [model for claim in claims for model in claim_of(claim, rate=recipe.rate).models]
    given += [] if sensor is None else [typical(sensor)]
    result = carry_out(lambda tell: drift_of([*load(files, recipe, models, tell), *given], settings), out)
    demand_kept(result)


NOISE = ("optional file", "model", "sensor", "datasheet", "unexplained", *RECORDING, *IDENTIFYING)
"""A recording, or a model of its noise."""


@command()
@options(*NOISE, "durations", "accuracy", "ramp", *RESULTS, settings=(NoiseChoices, PlanChoices))
def plan(file: str | None, **choices: Any) -> None:
    """Predict accuracy against record length.

    Uses the Cramer-Rao bound; nothing is simulated. The noise is that of --model, --sensor or --datasheet, or is
    identified from a recording FILE. With --verify, the identification is tested by simulation (selfcheck).
    """
    from allanite.study.modelled import PlanSettings

    _run(PlanSettings, file, choices)


@command()
@options(*NOISE, "duration", "samples", "records", "seed", "max_bias", "min_coverage", "max_false", "max_missed",
         *(option for option in RESULTS if option != "plot"), settings=(NoiseChoices, CheckChoices))  # fmt: skip
def selfcheck(file: str | None, **choices: Any) -> None:
    """Test the identification by simulation.

    Prints bias, spread, coverage and errors beside the Cramer-Rao bound. The noise is that of --model, --sensor or
    --datasheet, or is identified from a recording FILE, whose length is then used. If a given limit is exceeded by more
    than two Monte Carlo standard errors, the exit code is 4.
    """
    from allanite.study.modelled import SelfCheckSettings

    demand_kept(_run(SelfCheckSettings, file, choices))


def demand_kept(result: Any) -> None:
    """End with exit code 4, and say why, if a limit is exceeded."""
    for sentence in result.exceeded:
        complain(f"limit exceeded: {sentence}")
    if result.exceeded:
        raise click.exceptions.Exit(EXCEEDED)


@command()
@options(*NOISE, "tau", "ripple", "order", "turn_on", "measurement", *RESULTS,
         settings=(NoiseChoices, StateSpaceChoices))  # fmt: skip
def statespace(file: str | None, **choices: Any) -> None:
    """Export the noise as a state-space model.

    Prints the transition, covariance and measurement matrices of a Kalman filter. The noise is that of --model,
    --sensor or --datasheet, or is identified from a recording FILE. Flicker is approximated by a sum of Gauss-Markov
    processes between two averaging times.
    """
    from allanite.study.modelled import StateSpaceSettings

    _run(StateSpaceSettings, file, choices)


def _run(settings: "type[Use]", file: str | None, choices: dict[str, Any]) -> Any:
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.modelled import run_model_job

    use = settings_of(settings, choices)
    return carry_out(lambda tell: run_model_job(file, use, recipe_of(choices), progress=tell), out)
