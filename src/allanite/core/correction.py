"""Correction: converts a Record to a corrected Record."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from allanite.phrases.phrase import say

from .arrays import FloatArray
from .plain import Value
from .record import Record, Recording


@dataclass(frozen=True, eq=False, repr=False)
class Correction(Value, ABC):
    """A known error of a sensor's samples, to be subtracted from them.

    A subclass is a frozen value that holds the estimates (amplitudes of harmonics, coefficients of a regression) and
    defines two things: `what` is subtracted, and the `error` of each sample. Subtraction, with an entry in the record's
    history, is common to all.

    Attributes
    ----------
    what : str

    Examples
    --------
    >>> @dataclass(frozen=True, eq=False, repr=False)
    ... class Offset(Correction):
    ...     size: float
    ...     what = "a constant offset"
    ...     def error(self, record, along=None):
    ...         return np.full(len(record.values), self.size)
    >>> record = Record([1.0, 2.0, 4.0], rate=1.0, unit="rad/s", name="z")
    >>> corrected = Offset(0.5).apply(record)
    >>> corrected.values.tolist(), corrected.history
    ([0.5, 1.5, 3.5], ('corrected: a constant offset',))
    """

    @property
    @abstractmethod
    def what(self) -> str:
        """What is subtracted, in a few words for the record's history."""

    @abstractmethod
    def error(self, record: Record, along: Recording | None = None) -> FloatArray:
        """Error of each sample of `record`, SI, with the shape of its values.

        Parameters
        ----------
        record : Record
        along : Recording, optional
            Channels on the same clock that the error depends on, for example a temperature.

        Raises
        ------
        UsageError
            The correction does not apply to this record, or a channel that it needs is missing in `along`.
        """

    def _summary(self) -> str:
        return self.what

    def apply(self, record: Record, along: Recording | None = None) -> Record:
        """The record without this error. Parameters and exceptions are those of `error`; NaN stays NaN.

        Counts become increments of the same size, since corrected counts are not integers.
        """
        values = record.values - self.error(record, along) / record.factor
        return record.with_values(values, say("corrected: {what}", what=self.what), start=record.start)
