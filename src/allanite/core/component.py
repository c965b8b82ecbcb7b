"""Component: a part of the model of a record beside its terms, and how sure it is."""

from dataclasses import dataclass

from .plain import Value

SURE, EVEN = 0.73, 0.5
"""Weight of the models that hold a component from which it is claimed, and from which it is almost: odds of e and of 1
to 1 (`identification.search.components.CLAIMED`)."""


@dataclass(frozen=True, repr=False)
class Component(Value):
    """A part of the model of a record beside its terms."""

    # a fixed keyword for programs: "filter", "resonance", "step", "warm-up", "exponent", "noise" for Gauss-Markov
    # noise, "floor" for white noise behind a filter, "factor" for power that nothing describes
    name: str
    weight: float  # of the models that hold it, of all that are consistent with the record
    words: str = ""  # what it is, with numbers
    # low, high: frequencies, Hz, between which it changes the spectrum; equal where it does so nowhere in particular
    low: float = 0.0
    high: float = 0.0

    @property
    def claimed(self) -> bool:
        """Whether the models that hold it outweigh the others."""
        return self.weight >= SURE

    @property
    def almost(self) -> bool:
        """Whether it is not claimed, but as likely as not."""
        return EVEN <= self.weight < SURE

    def _summary(self) -> str:
        return f"{self.words or self.name}, weight {self.weight:.2f}"
