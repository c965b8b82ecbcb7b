"""Do stamps follow an even grid? What departs from it, by how much, and where."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.record import FloatArray
from allanite.units import unit_of

DEPARTURE = 0.75
"""Intervals by which a stamp may depart from the even grid: jitter, or one lost sample of very many, stays below."""

WANDER = 1e-4
"""Clock wander, relative, that no noise coefficient notices: a drifting oscillator, not a lost sample."""


def seconds_since(stamps: NDArray[Any], unit: str) -> FloatArray:
    """Seconds since the first stamp; integers are subtracted as such, since nanoseconds of an epoch exceed float64."""
    with np.errstate(all="ignore"):  # what is not finite is refused by `departure`
        return np.asarray((stamps - stamps[0]) * unit_of(unit).factor, dtype=np.float64)


def departure(elapsed: FloatArray, size: int, label: str) -> tuple[str, str]:
    """What forbids a rate from these stamps; and what is worth a note though it does not."""
    bad = ~np.isfinite(elapsed)
    if bad.any():
        return f"{label} has no stamp at sample {int(np.argmax(bad))} ({int(bad.sum())} of {size} are missing)", ""
    if elapsed[-1] < 1e-300:
        return f"the last stamp of {label} is not later than the first", ""
    interval = float(elapsed[-1]) / (size - 1)
    with np.errstate(over="ignore"):
        off = np.abs(elapsed / interval - np.arange(size))
        steps = np.diff(elapsed) / interval
    worst = int(np.argmax(off))
    most = float(off[worst])
    longest = int(np.argmax(steps))
    lost = f"the step of {label} before sample {longest + 1} is {steps[longest]:.3g} intervals: a sample may be lost"
    if most <= DEPARTURE:
        return "", lost if steps[longest] > 1 + DEPARTURE else ""
    if most <= WANDER * size and steps.min() > 0 and steps[longest] < 1 + DEPARTURE:
        share = f"{most / size * 1e6:.2g} ppm of the record"
        return "", f"{label} wanders by {most:.3g} intervals ({share}) from an even grid, without a gap"
    where = f"sample {worst} departs by {most:.4g} intervals ({most * interval:.4g} s) from the even grid"
    return f"the stamps of {label} are not evenly spaced: {where}, {_worst_step(steps, interval)}", ""


def _worst_step(steps: FloatArray, interval: float) -> str:
    backward, repeated = int((steps < 0).sum()), int((steps == 0).sum())
    if backward:
        return f"and {backward} stamps go back in time, the first at sample {int(np.argmax(steps < 0)) + 1}"
    longest = int(np.argmax(steps))
    again = f"{repeated} stamps repeat the one before, and " if repeated else ""
    return f"{again}the longest step is {steps[longest] * interval:.4g} s, before sample {longest + 1}"


def remedy(elapsed: FloatArray) -> str:
    """What to do about stamps that follow no even grid."""
    mean = (len(elapsed) - 1) / elapsed[-1] if np.isfinite(elapsed[-1]) and elapsed[-1] > 0 else 0.0
    over = f" (the mean over the file is {mean:.6g} Hz)" if mean else ""
    return (
        f"pass rate=... (--rate) to take the samples as evenly spaced{over}, with --from and --until around a gap, "
        "or time=... (--time) for another column"
    )
