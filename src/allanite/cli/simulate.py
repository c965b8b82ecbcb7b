"""``allanite simulate`` and ``example``: recordings with known noise, and papers by commands that anybody can type."""

import contextlib
import os
import re
import shlex
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from allanite.core.aliases import size_and_rate
from allanite.core.errors import DataError, UsageError
from allanite.core.syntax import split_quantities
from allanite.core.units import convert, seconds_of
from allanite.study.settings import LengthChoices, NoiseChoices

from .deliver import Extra, deliver, demand_recording, outputs, progress
from .front import DATA
from .helping import command
from .options import SHOWN, options
from .streams import show

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from allanite.core.record import Record

    Fault = Callable[[Record, str, np.random.Generator, dict[str, Any]], Record]
    from allanite.core.model import Model
    from allanite.core.record import Recording
    from allanite.simulation.record import RingLaser


def _quantities(text: str, option: str, example: str, *, defaults: tuple[float, ...] = ()) -> list[tuple[float, str]]:
    """As many numbers with units as `example` has; trailing ones that are omitted take `defaults`."""
    quantities = split_quantities(text.split())
    missing = len(split_quantities(example.split())) - len(quantities)
    if not 0 <= missing <= len(defaults):
        raise UsageError(f"--{option} has the form {example!r}, not {text!r}")
    quantities += [(value, "") for value in defaults[len(defaults) - missing :]]
    return [(value / 100, "") if unit == "%" else (value, unit) for value, unit in quantities]


def _noise_profile(record: "Record", text: str, _: Any, __: Any) -> "Record":
    # times and factors, from 'TIME:FACTOR, ...' or a file of two columns with or without a heading
    from allanite.simulation import faults

    path = Path(text)
    rows = path.read_text("utf-8").split("\n") if path.is_file() else text.split(",")
    headed = path.is_file() and not re.match(r"\s*[-+.\d]", rows[0])
    try:
        pairs = [[float(word) for word in re.split("[:;,]", row)] for row in rows[headed:] if row.strip()]
        times, factors = zip(*pairs, strict=True)
    except ValueError:
        form = "'0:1, 600:3, 1200:1' (seconds and factors) or a file of two such columns"
        raise (DataError if path.is_file() else UsageError)(f"--noise-profile takes {form}, not {text!r}") from None
    return faults.noise_profile(record, times, factors)


def _quantize(record: "Record", text: str, rng: "np.random.Generator", choices: dict[str, Any]) -> "Record":
    from allanite.simulation import faults

    what, step, unit = _quantizer(text)
    how = {"rate": faults.quantize_rate, "angle": faults.quantize_angle}[what]
    dither, words = None, choices["dither"]
    if words is not None and words.strip() == "random":
        dither = faults.Dither()
    elif words is not None:
        (frequency, _), (amplitude, _) = _quantities(words, "dither", "400 Hz 20")
        dither = faults.Dither(amplitude=amplitude, frequency=frequency)
    return how(record, step, unit, dither=dither, rng=rng)


def _named(text: str, option: str, *forms: str) -> tuple[str, list[tuple[float, str]]]:
    """A word, one of those of several forms, and as many numbers with units as in them."""
    (word, *rest), known = text.split() or [""], [form.split() for form in forms]
    quantities = split_quantities(rest) if len(forms) == 1 or any(word == form[0] for form in known) else []
    if len(quantities) != len(split_quantities(known[0][1:])) or not all(unit for _, unit in quantities):
        raise UsageError(f"--{option} has the form {' or '.join(map(repr, forms))}, not {text!r}")
    return word, quantities


def _quantizer(text: str) -> tuple[str, float, str]:
    what, ((step, unit),) = _named(text, "quantize", "rate 0.01 deg/s", "angle 0.2 arcsec")
    return what, step, unit


def _effect(record: "Record", text: str) -> "tuple[Record, NDArray[Any]]":
    """A quantity that swings, with the rate and length of a record, and its effect in the unit of the record."""
    import numpy as np

    from allanite.core.record import Record

    name, ((swing, unit), time, (size, of)) = _named(text, "effect", "temp 2 degC 1100 s 40 deg/h")
    wave = np.sin(2 * np.pi * np.arange(record.size) / (record.rate * seconds_of(f"{time[0]} {time[1]}")))
    return Record(swing * wave, record.rate, unit, name=name), convert(size, of, record.unit) * wave


def _simple(name: str, example: str, defaults: tuple[float, ...], make: "Callable[..., Record]") -> "Fault":
    """A fault that is given by quantities as in the `example`, of which the last ones have `defaults`."""

    def fault(record: "Record", text: str, rng: "np.random.Generator", _: dict[str, Any]) -> "Record":
        from allanite.simulation import faults

        return make(faults, record, rng, *_quantities(text, name, example, defaults=defaults))

    return fault


FAULTS: "dict[str, Fault]" = {
    "constant": _simple("constant", "10 deg/h", (), lambda faults, record, _, value: faults.constant(record, *value)),
    "low_pass": _simple(
        "low-pass", "20 Hz 4", (1.0,), lambda faults, record, _, cutoff, order: faults.low_pass(
            record, cutoff[0], order=int(order[0]) if order[0].is_integer() else order[0])),
    "noise_profile": _noise_profile,
    "outliers": _simple(
        "outliers", "0.01% 20", (),
        lambda faults, record, rng, share, size: faults.outliers(record, share[0], *size, rng=rng)),
    "clip": _simple("clip", "300 deg/s", (), lambda faults, record, _, value: faults.clip(record, *value)),
    "quantize": _quantize,
    "gaps": _simple(
        "gaps", "1% 5 s", (), lambda faults, record, rng, share, length: faults.gaps(
            record, share[0], seconds_of(f"{length[0]} {length[1] or 's'}"), rng=rng)),
}  # fmt: skip
"""The function of each option, in the order in which the faults occur in a sensor and its logger."""

CHANNEL_NAMES = {"gyro": "g", "accelerometer": "a", "dimensionless": "c"}  # first letters of the channels' names


@command()
@options(
    click.argument("out", type=click.Path()),
    "model", "sensor", "datasheet", "simulated rate", "duration", "samples", "simulated channels", "seed",
    "simulated unit",
    click.option("--rounding", is_flag=True, help="Generate Q by rounding the angle to steps of Q sqrt(12)."),
    click.option("--constant", metavar="RATE", help="Bias or earth rate, e.g. '10 deg/h'."),
    click.option("--effect", multiple=True, metavar="'NAME SWING PERIOD SIZE'",
        help="Add a column that swings, as a temperature, and its effect on the channels: 'temp 2 degC 1100 s "
        "40 deg/h'; repeatable."),
    click.option("--low-pass", metavar="HZ", help="Low-pass filter of first order; '20 Hz 4' has order 4."),
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
    from allanite.simulation.record import RING_LASERS, Simulation
    from allanite.study.modelled import NoiseSettings, ways

    model = NoiseSettings(choices["model"], choices["sensor"], choices["datasheet"]).given()
    if model is None:
        raise UsageError(f"give the noise with {ways()}")
    n, _ = size_and_rate(choices["samples"], choices["rate"], choices["duration"])
    laser = RING_LASERS.get((choices["sensor"] or "").lower())
    with progress(out) as tell:
        recording = _recording(model, n, choices, tell) if laser is None else _counts(laser, n, choices)
    truth = Simulation.of(model, choices["seed"], recording)
    deliver(truth, out, Extra(recordings={"out": lambda _: recording}))


def channel_names(wanted: Sequence[str], named: Callable[[int, int], str]) -> list[str]:
    """The names of the channels that are wanted, or of their number those by place and number."""
    if len(wanted) > 1 or not re.fullmatch(r"-?\d+", wanted[0]):
        return list(wanted)
    if (count := int(wanted[0])) < 1:
        raise UsageError(f"--channels must be at least 1, not {count}")
    return [named(i, count) for i in range(count)]


def _recording(model: "Model", n: int, choices: dict[str, Any], tell: Callable[[str, float], None]) -> "Recording":
    import numpy as np

    from allanite.core.record import Recording
    from allanite.simulation.record import simulate as simulated

    if choices["dither"] is not None and choices["quantize"] is None:
        raise UsageError("--dither needs a quantizer: give --quantize too")
    rng = np.random.default_rng(choices["seed"])
    what, _, step = ("", 0.0, "") if choices["quantize"] is None else _quantizer(choices["quantize"])
    # rates are rounded in the unit of the step, so that they are exact multiples of it
    unit = choices["unit"] or (step if what == "rate" else model.signal.sheet[0])
    records = []
    letter = CHANNEL_NAMES.get(model.signal.name, f"{model.signal.name} ")
    names = channel_names(choices["channels"], lambda i, count: letter + ("xyz"[i] if count <= 3 else str(i + 1)))
    for i, name in enumerate(names):
        tell(f"simulating {name}", 0.8 * i / len(names))
        record = simulated(model, n, choices["rate"], rng=rng, name=name, unit=unit, rounding=choices["rounding"])
        causes = [_effect(record, text) for text in choices["effect"]]
        for cause, effect in causes:
            record = record.with_values(record.values + effect, f"effect of {cause.name} added")
        for option, fault in FAULTS.items():
            if choices[option] is not None:
                record = fault(record, choices[option], rng, choices)
        records.append(record)
    return Recording((*records, *(cause for cause, _ in causes)))


COUNTING = ("model", "sensor", "rate", "duration", "samples", "channels", "seed", "constant", "out")
"""Options that apply to a ring laser gyro, which counts by itself."""


def _counts(laser: "RingLaser", n: int, choices: dict[str, Any]) -> "Recording":
    """The counts of a ring laser gyro that turns at a constant rate."""
    import numpy as np

    from allanite.core.record import Recording
    from allanite.simulation.record import simulate_ring_laser

    extra = [key for key, value in choices.items() if value and key not in COUNTING]
    if extra:
        name = extra[0].replace("_", "-")
        raise UsageError(f"--{name} does not apply to {choices['sensor']}, which delivers counts; omit it")
    given = "0" if choices["constant"] is None else choices["constant"]
    ((value, unit),) = _quantities(given, "constant", "10 deg/h")
    turning = convert(value, unit or "deg/h", "deg/h")
    rng = np.random.default_rng(choices["seed"])
    names = channel_names(choices["channels"], lambda i, count: f"gyro{i + 1}" if count > 1 else "gyro")
    records = (simulate_ring_laser(laser, turning, n, choices["rate"], rng=rng, name=each) for each in names)
    return Recording(tuple(records))


WRITTEN = {"report": "page.html", "json": "paper.json"}  # files of the comparison: option -> name


@command()
@options(click.argument("paper", required=False),
         click.argument("folder", required=False, type=click.Path(file_okay=False)),
         click.option("--commands", is_flag=True, help="Print the commands only."), *SHOWN)  # fmt: skip
def example(paper: str | None, folder: str | None, commands: bool, **shared: Any) -> None:
    """Reproduce the tables and figures of a paper.

    PAPER is a number or a short name: 003 or laser. Writes simulated input, tables, figures and a page into FOLDER, by
    default one of the short name, by commands that are printed and that can be repeated one by one, and prints what the
    paper says beside what was found. Without PAPER, lists the papers.
    """
    from allanite.papers.paper import PAPERS, compare, paper as paper_of

    if paper is None:
        for row in map(paper_of, PAPERS):
            source = textwrap.wrap(row.source, 95, initial_indent="     ", subsequent_indent="     ")
            show(f"{row.name}  {row.short}: {row.title}", *source)
        return
    row = paper_of(paper)
    lines = [shlex.split(command) for command in row.commands]
    shown = [shlex.join(["allanite", *line]) for line in lines]
    if commands:
        show(*shown)
        return
    folder = folder or row.short
    os.makedirs(folder, exist_ok=True)
    own = {name: os.path.join(folder, path) for name, path in WRITTEN.items()}
    out = outputs(shared | own, [])
    with contextlib.chdir(folder):
        for line, text in zip(lines, shown, strict=True):
            if not shared["quiet"]:
                show(f"$ {text}")
            _run(line, shared | {"quiet": not shared["details"]})
    deliver(compare(row.within(out.lang), Path(folder)), out)


def _run(line: list[str], shared: dict[str, Any]) -> None:
    from . import VERBS, main

    defaults = shared | dict.fromkeys(ANGLE, shared)
    with main.make_context("allanite", line, default_map=dict.fromkeys(VERBS, defaults)) as context:
        try:
            main.invoke(context)
        except click.exceptions.Exit as done:
            if done.exit_code != DATA:  # a part of a record need not be fit for analysis
                raise


ANGLE = ("calibrate", "estimate", "plan", "simulate", "watch")  # verbs of the group angle
