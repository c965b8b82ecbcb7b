"""One channel before a job begins with it."""

from dataclasses import dataclass

from allanite.core.finding import Quality
from allanite.core.record import Record


@dataclass(frozen=True, eq=False)
class Inspected:
    """One channel before a job begins with it.

    `records` are those that the job takes together: one, or a record of each recording that is compared.
    """

    name: str
    records: tuple[Record, ...]
    qualities: tuple[Quality, ...]

    @property
    def record(self) -> Record:
        """The first record."""
        return self.records[0]

    @property
    def quality(self) -> Quality:
        """What was found in the first record."""
        return self.qualities[0]

    @property
    def alerts(self) -> tuple[str, ...]:
        """What must stand beside the numbers, with the number of the record where there are several."""
        return tuple(f"{which}{finding}" for which, q in self.numbered for finding in q.warnings)

    @property
    def numbered(self) -> list[tuple[str, Quality]]:
        """What was found in each record, and the words before it: the number of the record where there are several."""
        many = len(self.records) > 1
        return [(f"record {i}: " if many else "", quality) for i, quality in enumerate(self.qualities, 1)]
