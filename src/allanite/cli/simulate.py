"""``allanite simulate``: a recording whose truth is known, in any format that is written."""

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from allanite.reporting.outputs import STDOUT, demand_outputs

from .faults import FAULTS, quantizer_unit
from .models import LENGTH, MODEL, model_of, options, size_of
from .output import put

if TYPE_CHECKING:
    from allanite.core.model import Model
    from allanite.core.record import Recording

NAMES = {"gyro": "g", "accelerometer": "a", "dimensionless": "c"}
"""First letters of the channels' names."""


@click.command()
@click.argument("out", type=click.Path())
@options(MODEL)
@click.option("--rate", type=float, required=True, metavar="HZ", help="Sampling rate.")
@options(LENGTH)
@click.option("--channels", type=int, default=1, metavar="N", help="Independent channels of this model.  [1]")
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    metavar="N",
    default=1,
    help="Of the random numbers; the same seed gives the same file.  [1]",
)
@click.option("--unit", help="Of the readings.  [deg/h, ug]")
@click.option("--constant", metavar="RATE", help="A bias or the earth's rate, as '10 deg/h'.")
@click.option("--low-pass", metavar="HZ", help="A first-order filter; '20 Hz 4' has order 4.")
@click.option("--noise-step", metavar="FACTOR", help="The second half has this times the noise.")
@click.option("--outliers", metavar="SHARE SIZE", help="Spikes: '0.01% 20' standard deviations, or '0.01% 50 deg/h'.")
@click.option("--clip", metavar="RATE", help="The range, as '300 deg/s'.")
@click.option("--quantize", metavar="WHAT STEP", help="'rate 0.01 deg/s' or 'angle 0.2 arcsec', which gives counts.")
@click.option("--dither", metavar="HOW", help="Before rounding, stripped after it: 'random', or '400 Hz 20' (steps).")
@click.option("--gaps", metavar="SHARE LENGTH", help="Lost stretches, as '1% 5 s'.")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write the truth as JSON; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
def simulate(out: str, *, json: str | None, force: bool, quiet: bool, **choices: Any) -> None:
    """Simulate a recording of known noise and write it to OUT.

    The suffix says the format: .csv, .npz, .parquet, .h5 or .mat. The faults are put in in the order in which they are
    listed here.
    """
    paths = {"OUT": out} | ({} if json is None else {"json": json})
    demand_outputs(paths, inputs=[], force=force)
    from allanite.core.errors import UsageError
    from allanite.readers import write
    from allanite.readers.formats.table import writer_for
    from allanite.reporting.plain import to_json
    from allanite.reporting.progress import bar

    writer_for(os.path.splitext(out)[1].lower())
    model = model_of(choices["model"], choices["sensor"])
    if model is None:
        raise UsageError("give the noise by --model or --sensor")
    size = size_of(choices["rate"], choices["duration"], choices["samples"])
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        recording = _recording(model, size, choices, progress)
        progress(f"writing {out}", 0.8)
        write(recording, out, force=force)
    if json is not None:
        put(json, to_json(_Truth(model, recording, choices["seed"])).encode(), force=force)
    if not quiet:
        _print(recording, out, silent=json == STDOUT)


def _recording(
    model: "Model", size: int, choices: dict[str, Any], progress: Callable[[str, float], None]
) -> "Recording":
    import numpy as np

    from allanite.core.errors import UsageError
    from allanite.core.record import Recording
    from allanite.simulation.record import simulate as simulated

    count = choices["channels"]
    if not count >= 1:
        raise UsageError(f"there is at least one channel, not {count}")
    if choices["dither"] is not None and choices["quantize"] is None:
        raise UsageError("a dither is for a quantizer: give --quantize too")
    rng = np.random.default_rng(choices["seed"])
    unit = choices["unit"] or quantizer_unit(choices["quantize"]) or model.signal.sheet[0]
    records = []
    for i in range(count):
        name = NAMES[model.signal.name] + ("xyz"[i] if count <= 3 else str(i + 1))
        progress(f"simulating {name}", 0.8 * i / count)
        record = simulated(model, size, choices["rate"], rng=rng, name=name, unit=unit)
        for option, fault in FAULTS.items():
            if choices[option] is not None:
                record = fault(record, choices[option], rng, choices)
        records.append(record)
    return Recording(tuple(records))


class _Truth:
    """What was put into a recording."""

    def __init__(self, model: "Model", recording: "Recording", seed: int) -> None:
        self.model, self.recording, self.seed = model, recording, seed

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        first = self.recording[0]
        return {
            "allanite": 1,
            "type": "Simulation",
            "model": self.model.to_dict(),
            "seed": self.seed,
            "rate": first.rate,
            "size": first.size,
            "channels": [{"name": r.name, "unit": r.unit, "history": list(r.history)} for r in self.recording],
        }


def _print(recording: "Recording", out: str, *, silent: bool) -> None:
    from allanite.reporting import words

    for record in recording:
        click.echo(f"{record.name}  {words.about(record)}", err=silent)
        for step in record.history:
            click.echo(f"  {step}", err=silent)
    click.echo(f"written: {out}", err=silent)
