"""``allanite explain``: what the fields of a target mean, what a statistic makes of noise, what a data sheet says."""

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
    """Explain a target, statistic or data sheet.

    Of a target of export, prints the fields with their units, formulas and sources; of a statistic, its ratio to the
    Allan variance and its degrees of freedom for each noise, in a record of 7200 samples or of --samples, at averaging
    times in sampling intervals; of the data sheet of a gyro, an accelerometer or an IMU, what it says of noise, and
    where. Without NAME, lists them, and the noise terms.
    """
    from allanite.core.names import row_alike
    from allanite.exporting.conversion import Explanation
    from allanite.exporting.exports import EXPORTS, TEMPERATURE
    from allanite.planning.datasheets import DATASHEETS, DataSheet
    from allanite.planning.properties import SIZE, properties
    from allanite.statistics import STATISTICS
    from allanite.statistics.row import Statistic

    out = outputs(choices, [])
    thermal = {row.name: row for row in TEMPERATURE.values()}
    row: Any = row_alike("name", name, {**STATISTICS, **EXPORTS, **thermal, **DATASHEETS}) if name else None
    if isinstance(row, Statistic):
        carry_out(lambda _: properties(row.name, samples or SIZE, taus=taus), out)
        return
    if samples is not None or taus is not None:
        raise UsageError("--samples and --taus apply to a statistic; omit them, or name one: " + ", ".join(STATISTICS))
    carry_out(lambda _: row if isinstance(row, DataSheet) else Explanation(row.name if row else ""), out)
