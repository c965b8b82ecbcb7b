"""What is claimed of the settings of a sensor: the cut-off of its low-pass filter, and how often it is sampled."""

import math
import re
from dataclasses import dataclass

from allanite.core.errors import UsageError, given
from allanite.core.plain import Value
from allanite.core.units import Signal
from allanite.core.validity import SETTLED

CUTOFF, RATE = SETTINGS = "cutoff", "rate"
"""What may be claimed beside noise."""

ITEM = re.compile(
    r"(?:(?P<sensor>gyro|accel)\w*\s+)?"
    r"(?:(?P<cutoff>low-?\s?pass|bandwidth|dlpf|cut-?off)|(?:output |sampling )?rate|odr)"
    r"(?:\s+at|\s*[:=])?\s+(?P<value>[0-9.]+(?:e[+-]?\d+)?)\s*(?P<kilo>k?)hz",
    re.IGNORECASE,
)
"""A setting: ``lowpass 42 Hz``, ``gyro bandwidth 250 Hz``, ``output rate 1 kHz``."""


@dataclass(frozen=True, repr=False)
class ClaimedSetting(Value):
    """A setting that is claimed."""

    # the -3 dB frequency of a low-pass filter, or the samples of the sensor in a second. One of "cutoff", "rate".
    quantity: str
    value: float  # Hz
    sensor: str = ""  # beginning of the name of the kind of sensor; empty for all

    def holds_for(self, signal: Signal) -> bool:
        """Whether it is a setting of this kind of sensor."""
        return signal.sensor.startswith(self.sensor)

    @property
    def settled(self) -> float:
        """Averaging time, s, from which a filter does not lower the deviation any more."""
        return SETTLED / self.value if self.quantity == CUTOFF else 0.0

    def words(self) -> str:
        """As it is written: ``gyro lowpass 42 Hz``."""
        name = {CUTOFF: "lowpass", RATE: "rate"}[self.quantity]
        return f"{self.sensor} {name} {self.value:g} Hz".strip()

    def _summary(self) -> str:
        return self.words()


def settings_in(text: str) -> tuple[tuple[ClaimedSetting, ...], str]:
    """The settings among the parts of a text, which commas and semicolons separate, and the text without them.

    Examples
    --------
    >>> settings_in("N 0.3 deg/sqrt(h), lowpass 42 Hz; 100 ug/sqrt(Hz)")
    ((<ClaimedSetting lowpass 42 Hz>,), 'N 0.3 deg/sqrt(h); 100 ug/sqrt(Hz)')
    """
    settings, groups = list[ClaimedSetting](), []
    for group in text.split(";"):
        kept = []
        for part in group.split(","):
            item = ITEM.fullmatch(part.strip())
            if item is None:
                kept.append(part)
                continue
            value = _number(item["value"]) * (1000 if item["kilo"] else 1)
            settings.append(ClaimedSetting(CUTOFF if item["cutoff"] else RATE, value, (item["sensor"] or "").lower()))
        groups.append(",".join(kept))
    return tuple(settings), ";".join(group for group in groups if group.strip()).strip()


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < math.inf:
        raise UsageError(f"a frequency must be a positive number of Hz, not {given(text)}", choice="claims")
    return value
