"""The noise that intervals assume, and its description: given, or identified on first use."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple

from allanite.core.averaged import Averaged, noise_choice
from allanite.core.curve import Law
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import Model, ModelLike, model_of
from allanite.core.threads import one_thread
from allanite.core.validity import UNEXPLAINED
from allanite.phrases.phrase import say
from allanite.statistics.row import FloatArray
from allanite.terms import TERMS


class SupposedNoise(NamedTuple):
    """Models with their weights, or "auto" for the power law at each averaging time.

    `words` describes the intervals in a short phrase.
    """

    noise: Averaged | Literal["auto"]
    words: str


Limits = tuple[FloatArray, FloatArray, FloatArray]
"""Degrees of freedom, lower and upper limits over the variance."""

Supposing = ModelLike | Literal["auto"] | Callable[[], SupposedNoise]
"""Noise that intervals assume; a function is called when they are first needed."""


def supposed(noise: ModelLike | Literal["auto"]) -> SupposedNoise:
    """A choice of the noise, with its description.

    Examples
    --------
    >>> from allanite import N
    >>> supposed(N(0.1, "deg/sqrt(h)")).words
    'intervals under the given model N = 0.1 deg/sqrt(h)'
    """
    choice = noise_choice(noise)
    if not isinstance(choice, Averaged):
        return SupposedNoise("auto", say("intervals for the power law identified at each averaging time"))
    fit = noise if isinstance(noise, Fit) else None
    if len(choice) == 1:
        under = say("intervals under the given model {model}", model=str(choice.terms))
        if fit:
            under = say("intervals under the identified model {model}", model=str(choice.terms))
    else:
        there = {term.symbol for term in choice.terms}
        symbols = ", ".join(symbol for symbol in TERMS if symbol in there)
        under = say("intervals averaged over {count} models of {symbols}", count=len(choice), symbols=symbols)
        if fit:
            under = say("intervals averaged over {count} models of {symbols} identified from the record",
                        count=len(choice), symbols=symbols)  # fmt: skip
    if fit and fit.validity == UNEXPLAINED:
        under = say("{intervals}, which does not explain the record", intervals=under)
    return SupposedNoise(choice, under)


@dataclass(frozen=True, eq=False)
class Assumption:
    """What intervals assume of the noise: models, "auto", a function that is called when it is needed, or nothing."""

    choice: Supposing | None

    @property
    def late(self) -> bool:
        """Whether a function tells the noise, once it is needed."""
        return callable(self.choice)

    @cached_property
    def suppose(self) -> Callable[[], SupposedNoise]:
        """The noise and its description, found once."""
        return Remembered(self.choice if callable(self.choice) else partial(supposed, self.choice))  # type: ignore[arg-type]  # asked where there is one

    @property
    def noise(self) -> Averaged | Literal["auto"] | None:
        """The noise; None if there is none."""
        return None if self.choice is None else self.suppose().noise

    @cached_property
    def given(self) -> Averaged | None:
        """The models that were given; None for any other choice."""
        noise = None if self.late else self.noise
        return noise if isinstance(noise, Averaged) else None

    @property
    def model(self) -> Model | None:
        """The model that represents those given."""
        return None if self.given is None else model_of(self.choice)  # type: ignore[arg-type]  # it was given


@dataclass(frozen=True, eq=False)
class LaterLaw:
    """The law `under` a noise that is identified on first use; pickled as the result.

    Limits are computed once for each level, also for curves that share them: the same curve in other units.
    """

    suppose: Callable[[], SupposedNoise]
    under: Callable[[Averaged | Literal["auto"]], Law]
    known: dict[float, Limits] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def found(self) -> tuple[Law, str]:
        """The law, and what it supposes; `under`, which holds the angle of the record, is given up then."""
        noise, words = self.suppose()
        return vars(self).pop("under")(noise), words

    def __call__(self, level: float) -> Limits:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        if level not in self.known:
            with one_thread():
                self.known[level] = self.found[0](level)
        return self.known[level]

    def words(self) -> str:
        """The assumptions of the intervals."""
        return self.found[1]

    def __getstate__(self) -> dict[str, Any]:
        return {"found": self.found, "known": self.known}
