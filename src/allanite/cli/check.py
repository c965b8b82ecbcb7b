"""``allanite check``: does a recording have the noise that is claimed of it."""

from typing import Any

import click

from allanite.core.errors import UsageError
from allanite.study.settings import ClaimChoices

from .deliver import carry_out, outputs, recipe_of, settings_of
from .front import EXCEEDED
from .options import IDENTIFYING, RECORDING, RESULTS, options


@click.command()
@options(
    "file",
    "claims",
    "claims_from",
    "at_most",
    "tolerance",
    *RECORDING,
    *IDENTIFYING,
    *RESULTS,
    settings=(ClaimChoices,),
)
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
        raise UsageError(
            "say what is claimed: --claims with a file, a data sheet or a model, e.g. --claims 'N 0.3 deg/sqrt(h)'",
            choice="claims",
        )
    claims, recipe, more = how.claims, recipe_of(choices), {"claims_from": how.claims_from, "at_most": how.at_most}
    found = carry_out(
        lambda tell: checked(file, claims, recipe, tolerance=how.tolerance, progress=tell, **more),  # type: ignore[arg-type]
        out,
    )
    if not found.agrees:
        raise click.exceptions.Exit(EXCEEDED)
