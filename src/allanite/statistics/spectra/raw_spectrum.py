"""Output of every spectrum estimator: densities at evenly spaced frequencies."""

from typing import NamedTuple, Protocol, runtime_checkable

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError
from allanite.core.record import Record
from allanite.phrases.phrase import say


class Raw(NamedTuple):
    """Two-sided densities at the frequencies k df, Hz, k = first ... first + size - 1."""

    # `period` is the number of frequencies in the sampling rate, so that k and period - k are mirrored. `overlap` is
    # the covariance of two values over the square of their expectation, by the difference of their k, for a flat
    # spectrum; zero beyond its end. `resolution` is the equivalent noise bandwidth, Hz.
    first: int
    df: float
    period: int
    density: FloatArray
    overlap: FloatArray
    resolution: float


@runtime_checkable
class SpectralEstimator(Protocol):
    """A spectrum estimator."""

    @property
    def title(self) -> str:
        """Description with the settings."""

    def estimate(self, record: Record) -> Raw:
        """Densities at evenly spaced frequencies."""


def demand_frequencies(count: int, record: Record) -> None:
    """Refuse a record, or a segment of it, that is too short for any frequency."""
    if count < 1:
        raise DataError(say("{channel!r} has too few of its {size} samples without a gap for a spectrum; record "
                            "longer, or use longer segments", channel=record.name, size=record.size))  # fmt: skip
