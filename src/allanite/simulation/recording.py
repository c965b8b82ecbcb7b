"""A simulated recording as a value: its noise and faults."""

from dataclasses import dataclass

from allanite.core.errors import UsageError
from allanite.core.header import Header
from allanite.core.model import Model
from allanite.core.plain import Value
from allanite.core.record import Recording
from allanite.phrases.wording import spelled


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Value):
    """The truth of a simulated recording: the noise of every channel, the seed, rate (Hz) and number of samples.

    `channels` are what the channels hold; their histories say which faults were put in.
    """

    model: Model
    seed: int
    rate: float
    size: int
    channels: tuple[Header, ...]

    @classmethod
    def of(cls, model: Model, seed: int, recording: Recording) -> "Simulation":
        """The truth of this recording."""
        first = recording[0]
        return cls(model, seed, first.rate, first.size, tuple(record.header for record in recording))


def readings(rate: float, duration: float | None, samples: int | None) -> int:
    """Number of samples for a length given either in s or as a number.

    Examples
    --------
    >>> readings(100.0, 60.0, None)
    6000
    """
    if (duration is None) == (samples is None):
        raise UsageError("give the length either by " + spelled("--duration or by --samples", "duration or by samples"))
    if not 0 < rate < float("inf"):
        raise UsageError(f"the sampling rate must be a positive number of Hz, not {rate!r}")
    return samples if samples is not None else round((duration or 0.0) * rate)
