"""Kinds of records, and names and meanings of noise terms by the type of sensor."""

from allanite.phrases.phrase import join, say, spelled
from allanite.terms import TERMS

from .errors import SCALE
from .units import Signal, signal_with, unit_of

# kind: power of time in the unit relative to the signal, points beyond the number of intervals, meaning
KINDS: dict[str, tuple[int, int, str]] = {
    "rate": (0, 0, say("the mean rate over each sample interval (deg/s, rad/s, g, m/s^2)")),
    "increment": (1, 0, say(
        "the angle increment over each sample interval (delta-theta: arcsec, rad; m/s for an accelerometer)")),
    "angle": (1, 1, say(
        "the integrated angle at each instant, whose rate is analyzed; one point more than there are intervals")),
    "count": (1, 0, say("integer pulses per sample interval, each with the size `scale` (for example 0.1 arcsec)")),
    "value": (0, 0, say("the quantity itself, whose own noise is wanted (an angle error, a voltage, a temperature)")),
}  # fmt: skip

KIND_WORDS = {"rate": say("rate"), "increment": say("increment"), "angle": say("angle"), "count": say("count"),
              "value": say("value")}  # fmt: skip
"""What each kind of record is called."""


def explain_kinds() -> str:
    """One sentence for each kind of record, for error messages."""
    return join("; ", (say("{kind!r} is {meaning}", kind=kind, meaning=row[2]) for kind, row in KINDS.items()))


def signal_of_kind(unit: str, kind: str) -> Signal | None:
    """The signal whose samples of this kind have this unit; None if there is none."""
    return signal_with(unit_of(unit).dimension, KINDS[kind][0], values=kind == "value")


def kinds_of(unit: str) -> tuple[str, ...]:
    """The kinds that samples in this unit may have."""
    return tuple(kind for kind in KINDS if signal_of_kind(unit, kind))


def offered(unit: str, *, integers: bool = True) -> str:
    """The meanings that samples in this unit may have, each with the choice that states it; none is advised."""
    # Counts are offered for `integers` only.
    kinds = [kind for kind in kinds_of(unit) if integers or kind != "count"]
    scale = {"count": spelled(f" --scale {SCALE}", ", scale=...")}
    named = ((spelled(f"--kind {kind}", f"kind={kind!r}") + scale.get(kind, ""), KINDS[kind][2]) for kind in kinds)
    choices = [say("{option}: {meaning}", option=option, meaning=meaning) for option, meaning in named]
    if kinds and "rate" not in kinds and signal_of_kind(f"({unit})/s", "rate"):
        option = spelled(f"--unit {unit}/s", f"unit={f'{unit}/s'!r}")
        choices.append(say("{option}: the mean rate, if the unit was written without its time", option=option))
    return join("; ", choices)


def title_of(symbol: str, signal: Signal) -> str:
    """The name of a term for its sensor: an accelerometer has a velocity random walk."""
    row = TERMS[symbol]
    if signal.inertial or signal.name in row.titles or not row.quantity_title:
        return row.titles.get(signal.name, row.title)
    return say(row.quantity_title, quantity=signal.quantity)


def meaning_of(symbol: str, signal: Signal) -> str:
    """What a term of this sensor is, in one line."""
    row = TERMS[symbol]
    return row.meaning if signal.inertial else row.quantity_meaning or row.meaning
