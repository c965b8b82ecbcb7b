"""The table of devices: micromechanical, optical, and those of two papers; its texts are in ``devices.toml``."""

import tomllib
from importlib.resources import files
from typing import Any

from allanite.core.names import row_of
from allanite.phrases.phrase import say

from .device import Cause, Device

_TEXTS: dict[str, Any] = tomllib.loads((files(__package__) / "devices.toml").read_text("utf-8"))


def _cause(name: str, sources: list[str], remedies: list[str], reference: str) -> Cause:
    return Cause(say(name), tuple(map(say, sources)), tuple(map(say, remedies)), say(reference))


def _device(name: str, title: str, signals: list[str], terms: dict[str, Any], note: str = "") -> Device:
    causes = {symbol: _cause(**row) for symbol, row in terms.items()}
    return Device(name, say(title), tuple(map(say, signals)), causes, say(note) if note else "")


DEVICES: dict[str, Device] = {name: _device(name, **row) for name, row in _TEXTS["devices"].items()}
"""By name."""

REFERENCES: dict[str, str] = {say(name): say(text) for name, text in map(dict.values, _TEXTS["references"])}
"""What the tables cite."""


def device(name: str) -> Device:
    """A device of the table."""
    return row_of("device", name, DEVICES)
