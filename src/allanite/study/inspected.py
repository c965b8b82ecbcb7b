"""One channel after its inspection."""

from dataclasses import dataclass

from allanite.core.finding import Quality
from allanite.core.header import Header
from allanite.core.record import Record
from allanite.phrases.phrase import join, say

from .keeper import Keeper


@dataclass(frozen=True, eq=False)
class Inspected:
    """One channel after its inspection, before it is processed.

    `headed` are processed together: one record, or one of each recording that is compared. Of a record that was read
    in parts there is the header, and the keeper of its sums.
    """

    name: str
    headed: tuple[Record | Header, ...]
    qualities: tuple[Quality, ...]
    keeper: Keeper | None = None

    @property
    def records(self) -> tuple[Record, ...]:
        """The records, which are in memory."""
        return tuple(each for each in self.headed if isinstance(each, Record))

    @property
    def record(self) -> Record:
        """The first record."""
        return self.records[0]

    @property
    def first(self) -> Record | Header:
        """The first record, or its header."""
        return self.headed[0]

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
        many = len(self.headed) > 1
        return [
            (say("record {number}: ", number=i) if many else "", quality) for i, quality in enumerate(self.qualities, 1)
        ]
