"""What a stored result holds about its record."""

from dataclasses import dataclass
from typing import Any, ClassVar

from .limits import demand_stored_rate
from .plain import Value
from .units import Signal


@dataclass(frozen=True, repr=False)
class Header(Value):
    """The properties of a record without its samples; the attributes are those of `Record`.

    Results that were stored and read again hold it instead of the record.
    """

    _checks: ClassVar = {"rate": demand_stored_rate}

    name: str
    rate: float
    size: int
    unit: str
    kind: str
    scale: float | None
    start: float | None
    history: tuple[str, ...]
    signal: Signal

    @property
    def duration(self) -> float:
        """Length, s."""
        return self.size / self.rate

    def _summary(self) -> str:
        return f"{self.name!r}: {self.kind} in {self.unit}, {self.size} intervals at {self.rate:g} Hz"


def header_from(data: dict[str, Any]) -> Header:
    """The header that `header_dict` has written, among other keys."""
    return Header.from_dict({**data, "type": "Header"})
