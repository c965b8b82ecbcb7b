"""``allanite budget``: the current of a torquer as a rate, and the noise that quantization adds to it."""

from typing import Any

import click

from .deliver import Extra, carry_out, demand_recording, outputs, recipe_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .types import NUMBERS


@click.command()
@options(
    "file",
    *RECORDING,
    click.option(
        "--stage", "stages", multiple=True, metavar="'NAME BITS SCALE'",
        help="A quantizer in the signal path, e.g. 'ADC 12 5V', 'ADC 12 5V gain=10' or "
        "'output 16 100deg/s'; repeatable.",
    ),
    click.option(
        "--torquer", metavar="A=X,...",
        help="Constants of the torquer in SI: turns, field (T), span (m), radius (m), inertia (kg m^2), spin (rad/s), "
        "sides.",
    ),
    click.option("--scale-factor", type=float, metavar="K", help="Or the scale factor of the torquer, rad/s per A."),
    click.option("--sense", type=float, metavar="V/A", help="Gain of the current sensor, for voltages."),
    click.option("--coupling", type=NUMBERS, metavar="XX,XY,YX,YY",
        help="Two channels are the currents of the x and y torquers: rates about x and y over the scale factor, "
        "e.g. 0,-1,1,0 with cross-coupling in XX and YY."),
    *IDENTIFYING,
    click.option("--rates", metavar="PATH", type=click.Path(), help="Write the rates as a recording: .csv, .npz, ..."),
    *RESULTS,
)  # fmt: skip
def budget(file: str, **choices: Any) -> None:
    """Estimate the noise added by quantization.

    Compares each stage of the signal path of FILE with the recorded noise. A current (--unit A), a voltage or codes
    (--unit 1) are converted to rates with the constants of the torquer.
    """
    out = outputs(choices, [file, choices["recipe"]], also=("rates",))
    demand_recording(out.paths.get("rates"))
    from allanite.applications.signals import Stage, TorqueScale
    from allanite.applications.signals.budgeting import PathSettings, budget_file
    from allanite.core.errors import UsageError

    torquer, factor = choices["torquer"], choices["scale_factor"]
    if torquer is not None and factor is not None:
        raise UsageError("the scale factor is given twice: use either --torquer or --scale-factor")
    scale = factor if torquer is None else TorqueScale.parse(torquer)
    settings = PathSettings(tuple(Stage.parse(text) for text in choices["stages"]), scale, choices["sense"],
                            choices["coupling"])  # fmt: skip
    extra = Extra(recordings={"rates": lambda study: study.rates})
    carry_out(lambda tell: budget_file(file, recipe_of(choices), settings, progress=tell), out, extra)
