"""The table of devices: micromechanical, optical, and those of two papers; its texts are in ``devices.toml``."""

import math
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from itertools import pairwise
from typing import Any

from allanite.core.names import row_of
from allanite.phrases.phrase import say

# none by angle random walk: the bounds of overviews contradict the data sheets of tactical sensors
GRADES: dict[str, float] = {say("Navigation grade"): 0.01, say("Tactical grade"): 5.0, say("Industrial grade"): 360.0,
                            say("Consumer grade"): math.inf}  # fmt: skip
"""Grades of gyroscopes, the best first, each with the in-run bias stability, deg/h, that it is below."""

GRADES_SOURCE = ("navigation and consumer: N. El-Sheimy, A. Youssef, Inertial sensors technologies for navigation "
                 "applications, Satellite Navigation 1 (2020) 2, doi:10.1186/s43020-019-0001-5, table 1 (gyroscope "
                 "drift below 0.01 deg/h; 0.1 deg/s); tactical against industrial: N. Miller, D. Robbins, J. Bessette, "
                 "Benefits of a tactical grade IMU in low-cost GNSS/INS systems, RoboticsTomorrow, July 2021 (in-run "
                 "bias stability of 5 deg/h)")  # fmt: skip


def grade_of(stability: float) -> str:
    """The grade of an in-run bias stability in deg/h."""
    return next(grade for grade, below in GRADES.items() if stability < below)


def bounds_of(grade: str) -> str:
    """The bounds of a grade: ``0.01 to 5 deg/h``."""
    low, high = dict(zip(GRADES, pairwise((0.0, *GRADES.values())), strict=True))[grade]
    if not low:
        return say("below {limit:g} {unit}", limit=high, unit="deg/h")
    if math.isinf(high):
        return say("from {limit} {unit} on", limit=f"{low:g}", unit="deg/h")
    return say("{low} to {high:g} {unit}", low=f"{low:g}", high=high, unit="deg/h")


@dataclass(frozen=True)
class Cause:
    """A noise term in a device."""

    name: str  # what the term is called there
    # sources, remedies: where it is likely to come from, and what to try
    sources: tuple[str, ...]
    remedies: tuple[str, ...]
    reference: str  # who says so, with page or section; keys of `REFERENCES`


@dataclass(frozen=True)
class Device:
    """A kind of device."""

    name: str
    title: str
    signals: tuple[str, ...]  # names of the signals that its table is about
    terms: dict[str, Cause]  # by symbol
    note: str = ""  # how it has to be measured, or what else must be known to read the table
    hadamard: bool = False  # whether its remedies look at the Hadamard deviation


_TEXTS: dict[str, Any] = tomllib.loads((files(__package__) / "devices.toml").read_text("utf-8"))


def _cause(name: str, sources: list[str], remedies: list[str], reference: str) -> Cause:
    return Cause(say(name), tuple(map(say, sources)), tuple(map(say, remedies)), say(reference))


def _device(name: str, title: str, signals: list[str], terms: dict[str, Any], **more: Any) -> Device:
    causes = {symbol: _cause(**row) for symbol, row in terms.items()}
    note = more.pop("note", "")
    return Device(name, say(title), tuple(map(say, signals)), causes, say(note) if note else "", **more)


DEVICES: dict[str, Device] = {name: _device(name, **row) for name, row in _TEXTS["devices"].items()}  # by name

REFERENCES: dict[str, str] = {say(name): say(text) for name, text in map(dict.values, _TEXTS["references"])}
"""What the tables cite."""


def device(name: str) -> Device:
    """A device of the table."""
    return row_of("device", name, DEVICES)
