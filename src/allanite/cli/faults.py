"""The options of ``allanite simulate`` that add faults to a record."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from allanite.core.record import Record

    Fault = Callable[[Record, str, np.random.Generator, dict[str, Any]], Record]


def _quantities(text: str, option: str, example: str, *, defaults: tuple[float, ...] = ()) -> list[tuple[float, str]]:
    """As many numbers with units as `example` has; trailing ones that are omitted take `defaults`."""
    from allanite.core.errors import UsageError
    from allanite.core.notation import split_quantities

    found = split_quantities(text.split())
    missing = len(split_quantities(example.split())) - len(found)
    if not 0 <= missing <= len(defaults):
        raise UsageError(f"--{option} has the form {example!r}, not {text!r}")
    found += [(value, "") for value in defaults[len(defaults) - missing :]]
    return [(value / 100, "") if unit == "%" else (value, unit) for value, unit in found]


def turning_rate(text: str | None) -> float:
    """The constant rate in deg/h; 0 if none is given."""
    from allanite.core.units import convert

    if text is None:
        return 0.0
    ((value, unit),) = _quantities(text, "constant", "10 deg/h")
    return convert(value, unit or "deg/h", "deg/h")


def _low_pass(record: "Record", cutoff: tuple[float, str], order: tuple[float, str]) -> "Record":
    from allanite.core.errors import UsageError
    from allanite.simulation import faults

    if not order[0].is_integer():
        raise UsageError(f"the order of a filter must be an integer, not {order[0]:g}")
    return faults.low_pass(record, cutoff[0], order=int(order[0]))


def _noise_profile(record: "Record", text: str, _: Any, __: Any) -> "Record":
    # times and factors, from 'TIME:FACTOR, ...' or a file of two columns with or without a heading
    from pathlib import Path

    from allanite.core.errors import DataError, UsageError
    from allanite.simulation import faults

    form = "'0:1, 600:3, 1200:1' (seconds and factors) or a file of two such columns"
    pairs = [part.split(":") for part in text.split(",")]
    path = Path(text)
    if path.is_file():
        lines = [line.replace(";", ",").split(",") for line in path.read_text("utf-8").splitlines() if line.strip()]
        pairs = lines if lines and _numeric(lines[0]) else lines[1:]
    if not pairs or not all(_numeric(pair) for pair in pairs):
        kind = DataError if path.is_file() else UsageError
        raise kind(f"--noise-profile takes {form}, not {text!r}")
    times, factors = zip(*(map(float, pair) for pair in pairs), strict=True)
    return faults.noise_profile(record, *(list(times), list(factors)))


def _numeric(pair: list[str]) -> bool:
    """Whether a pair is two numbers."""
    try:
        return len([float(word) for word in pair]) == 2
    except ValueError:
        return False


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


def _quantizer(text: str) -> tuple[str, float, str]:
    from allanite.core.errors import UsageError
    from allanite.core.notation import split_quantities

    what, *rest = text.split() or [""]
    found = split_quantities(rest) if what in ("rate", "angle") else []
    if len(found) != 1 or not found[0][1]:
        raise UsageError(f"--quantize has the form 'rate 0.01 deg/s' or 'angle 0.2 arcsec', not {text!r}")
    return what, *found[0]


def quantizer_unit(text: str | None) -> str | None:
    """Round in the unit of the step, so that the rates are exact multiples of it."""
    what, _, unit = ("", 0.0, "") if text is None else _quantizer(text)
    return unit if what == "rate" else None


def _gaps(record: "Record", rng: Any, share: tuple[float, str], length: tuple[float, str]) -> "Record":
    from allanite.core.units import convert
    from allanite.simulation import faults

    return faults.gaps(record, share[0], convert(length[0], length[1] or "s", "s"), rng=rng)


def _simple(name: str, example: str, defaults: tuple[float, ...], make: "Callable[..., Record]") -> "Fault":
    """A fault that is given by quantities as in the `example`, of which the last ones have `defaults`."""

    def fault(record: "Record", text: str, rng: "np.random.Generator", _: dict[str, Any]) -> "Record":
        from allanite.simulation import faults

        return make(faults, record, rng, *_quantities(text, name, example, defaults=defaults))

    return fault


FAULTS: "dict[str, Fault]" = {
    "constant": _simple("constant", "10 deg/h", (), lambda faults, record, _, value: faults.constant(record, *value)),
    "low_pass": _simple("low-pass", "20 Hz 4", (1.0,), lambda _, record, __, *values: _low_pass(record, *values)),
    "noise_step": _simple(
        "noise-step", "2", (), lambda faults, record, _, value: faults.noise_step(record, factor=value[0])),
    "noise_profile": _noise_profile,
    "outliers": _simple(
        "outliers", "0.01% 20", (),
        lambda faults, record, rng, share, size: faults.outliers(record, share[0], *size, rng=rng)),
    "clip": _simple("clip", "300 deg/s", (), lambda faults, record, _, value: faults.clip(record, *value)),
    "quantize": _quantize,
    "gaps": _simple("gaps", "1% 5 s", (), lambda _, record, rng, *values: _gaps(record, rng, *values)),
}  # fmt: skip
"""The function of each option, in the order in which the faults occur in a sensor and its logger."""
