"""Finding: a property of a record that affects the results. Quality: all findings of one channel."""

from dataclasses import dataclass

from allanite.phrases.phrase import join

from .plain import Value

MOTION = ("moving", "body moved")
"""Names of the findings of motion."""


@dataclass(frozen=True, repr=False)
class Finding(Value):
    """A property of a record that affects the results.

    Attributes
    ----------
    name : str
        A fixed keyword for programs: "gaps", "stuck", "lines" ...
    what : str
        What was found, with numbers.
    consequence, remedy : str
        Its effect on the results, and what the user can do.
    place : (start, end) or None
        Seconds after the recording's first sample; None for the whole record.
    fatal : bool
        Whether the record cannot support the job.
    """

    name: str
    what: str
    consequence: str = ""
    remedy: str = ""
    place: tuple[float, float] | None = None
    fatal: bool = False

    def __str__(self) -> str:
        return join("; ", filter(None, (self.what, self.consequence, self.remedy)))


@dataclass(frozen=True, repr=False)
class Quality(Value):
    """The findings about a record before anything is computed."""

    findings: tuple[Finding, ...] = ()

    @property
    def refusal(self) -> str:
        """Why the record cannot support the job; empty if it can."""
        return join(". ", (str(f) for f in self.findings if f.fatal))

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """The findings to report together with the results."""
        return tuple(f for f in self.findings if not f.fatal)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the findings."""
        return tuple(f.name for f in self.findings)

    @property
    def moved(self) -> bool:
        """Whether the sensor was not at rest."""
        return not set(MOTION).isdisjoint(self.names)

    def _summary(self) -> str:
        return ", ".join(self.names) or "no findings"
