"""``allanite explain``: what the fields of a target mean, and what a statistic makes of noise."""

from typing import Any

import click

from allanite.core.errors import UsageError
from allanite.study.settings import LengthChoices

from .deliver import carry_out, outputs
from .options import SHOWN, options


@click.command()
@options(
    click.argument("name", required=False, default=""),
    "samples", "taus", "csv", "json", *SHOWN, settings=(LengthChoices,),
)  # fmt: skip
def explain(name: str, samples: int | None, taus: Any, **choices: Any) -> None:
    """Explain a target or a statistic.

    Of a target of export, prints the fields with their units, formulas and sources; of a statistic, its ratio to the
    Allan variance and its degrees of freedom for each noise, in a record of 7200 samples or of --samples, at averaging
    times in sampling intervals. Without NAME, lists the targets, the statistics and the noise terms.
    """
    from allanite.exporting.conversion import Explanation
    from allanite.planning.properties import SIZE, properties
    from allanite.statistics import STATISTICS

    out = outputs(choices, [])
    if name in STATISTICS:
        carry_out(lambda _: properties(name, samples or SIZE, taus=taus), out)
        return
    if samples is not None or taus is not None:
        raise UsageError("--samples and --taus apply to a statistic; omit them, or name one: " + ", ".join(STATISTICS))
    carry_out(lambda _: Explanation(name), out)
