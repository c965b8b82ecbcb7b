"""One channel after its inspection."""

from dataclasses import dataclass

from allanite.core.finding import Quality
from allanite.core.record import Record
from allanite.phrases.phrase import join, say


@dataclass(frozen=True, eq=False)
class Inspected:
    """One channel after its inspection, before it is processed.

    `records` are processed together: one, or a record of each recording that is compared.
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
        """The findings about the first record."""
        return self.qualities[0]

    @property
    def alerts(self) -> tuple[str, ...]:
        """The findings to report with the results, with the number of the record if there are several."""
        return tuple(join("", (which, str(finding))) for which, q in self.numbered for finding in q.warnings)

    @property
    def numbered(self) -> list[tuple[str, Quality]]:
        """The findings about each record, and their prefix: the number of the record if there are several."""
        many = len(self.records) > 1
        return [
            (say("record {number}: ", number=i) if many else "", quality) for i, quality in enumerate(self.qualities, 1)
        ]
