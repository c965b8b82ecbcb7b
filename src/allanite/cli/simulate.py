"""``allanite simulate``: a recording with known noise, in any format that can be written."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from allanite.study.settings import LengthChoices, NoiseChoices

from .deliver import Extra, deliver, demand_recording, outputs, progress
from .faults import FAULTS, quantizer_unit, turning_rate
from .options import SHOWN, options

if TYPE_CHECKING:
    from allanite.core.model import Model
    from allanite.core.record import Recording
    from allanite.simulation.ring_laser import RingLaser

NAMES = {"gyro": "g", "accelerometer": "a", "dimensionless": "c"}
"""First letters of the channels' names."""


@click.command()
@options(
    click.argument("out", type=click.Path()),
    "model", "sensor", "datasheet", "simulated rate", "duration", "samples", "simulated channels", "seed",
    "simulated unit",
    click.option("--rounding", is_flag=True, help="Generate Q by rounding the angle to steps of Q sqrt(12)."),
    click.option("--constant", metavar="RATE", help="Bias or earth rate, e.g. '10 deg/h'."),
    click.option("--low-pass", metavar="HZ", help="Low-pass filter of first order; '20 Hz 4' has order 4."),
    click.option("--noise-step", metavar="FACTOR", help="Multiply the noise of the second half by this."),
    click.option("--noise-profile", metavar="PROFILE",
        help="Multiply the noise by a factor that changes with time: '0:1, 600:3, 1200:1' (s and factor, linear "
        "between), or a CSV file of two columns."),
    "simulated outliers",
    click.option("--clip", metavar="RATE", help="Full-scale range, e.g. '300 deg/s'."),
    click.option("--quantize", metavar="WHAT STEP",
        help="Quantizer: 'rate 0.01 deg/s', or 'angle 0.2 arcsec' for counts."),
    "simulated dither",
    click.option("--gaps", metavar="SHARE LENGTH", help="Missing stretches, e.g. '1% 5 s'."),
    "json", *SHOWN, settings=(NoiseChoices, LengthChoices),
)  # fmt: skip
def simulate(**choices: Any) -> None:
    """Simulate a recording of known noise.

    Writes it to OUT, whose suffix selects the format: .csv, .npz, .parquet, .h5 or .mat. Faults are applied in the
    order in which they are listed here. The same seed gives the same file.
    """
    path = choices["out"]
    out = outputs(choices, [], also=["out"])
    demand_recording(path)
    from allanite.core.errors import UsageError
    from allanite.simulation.recording import Simulation, readings
    from allanite.simulation.ring_laser import RING_LASERS
    from allanite.study.modelling import NoiseSettings, ways

    model = NoiseSettings(choices["model"], choices["sensor"], choices["datasheet"]).given()
    if model is None:
        raise UsageError(f"give the noise with {ways()}")
    n = readings(choices["rate"], choices["duration"], choices["samples"])
    laser = RING_LASERS.get((choices["sensor"] or "").lower())
    with progress(out) as tell:
        recording = _recording(model, n, choices, tell) if laser is None else _counts(laser, n, choices)
    truth = Simulation.of(model, choices["seed"], recording)
    deliver(truth, out, Extra(recordings={"out": lambda _: recording}))


def _recording(model: "Model", n: int, choices: dict[str, Any], tell: Callable[[str, float], None]) -> "Recording":
    import numpy as np

    from allanite.core.errors import UsageError
    from allanite.core.record import Recording
    from allanite.simulation.record import simulate as simulated

    count = choices["channels"]
    if not count >= 1:
        raise UsageError(f"--channels must be at least 1, not {count}")
    if choices["dither"] is not None and choices["quantize"] is None:
        raise UsageError("--dither needs a quantizer: give --quantize too")
    rng = np.random.default_rng(choices["seed"])
    unit = choices["unit"] or quantizer_unit(choices["quantize"]) or model.signal.sheet[0]
    records = []
    for i in range(count):
        name = NAMES.get(model.signal.name, f"{model.signal.name} ") + ("xyz"[i] if count <= 3 else str(i + 1))
        tell(f"simulating {name}", 0.8 * i / count)
        record = simulated(model, n, choices["rate"], rng=rng, name=name, unit=unit, rounding=choices["rounding"])
        for option, fault in FAULTS.items():
            if choices[option] is not None:
                record = fault(record, choices[option], rng, choices)
        records.append(record)
    return Recording(tuple(records))


COUNTING = ("model", "sensor", "rate", "duration", "samples", "channels", "seed", "constant", "out")
"""Options that apply to a ring laser gyro, which counts by itself."""


def _counts(laser: "RingLaser", n: int, choices: dict[str, Any]) -> "Recording":
    """The counts of a ring laser gyro that turns at a constant rate."""
    import numpy as np

    from allanite.core.errors import UsageError
    from allanite.core.record import Recording
    from allanite.simulation.ring_laser import simulate_ring_laser

    extra = [key for key, value in choices.items() if value and key not in COUNTING]
    if extra:
        name = extra[0].replace("_", "-")
        raise UsageError(f"--{name} does not apply to {choices['sensor']}, which delivers counts; omit it")
    turning = turning_rate(choices["constant"])
    rng = np.random.default_rng(choices["seed"])
    names = [f"gyro{i + 1}" if choices["channels"] > 1 else "gyro" for i in range(choices["channels"])]
    return Recording(
        tuple(simulate_ring_laser(laser, turning, n, choices["rate"], rng=rng, name=each) for each in names)
    )
