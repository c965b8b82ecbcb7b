"""The noise that intervals assume, given or identified on first use, and the law of a curve averaged over models."""

# Derivation: docs/derivations.md.

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.curve import Law
from allanite.core.estimate import Averaged, noise_choice
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import Model, ModelLike, model_of
from allanite.core.plain import Portable
from allanite.core.threads import one_thread
from allanite.core.validity import UNEXPLAINED
from allanite.phrases.phrase import say
from allanite.statistics.table import CurvePoints
from allanite.terms import TERMS

from .chisquares import table
from .limits import at_points, joined

REACH, DEVIATES = 4.2, 22  # normal deviates between which the laws are tabulated, and how many
MIXTURE_BISECTIONS = 30  # steps to a quantile

FLATTENED = 0.3
"""Power of the models' weights: those are known from the few coefficients of which V is made, and models under which V
is low by chance have little. As limits of random walk beside quantization need to contain the true value.
"""

TOGETHER = 0.5
"""Correlation of bias and scatter: as Theo1's limits at 0.1 to 0.5 of a record need to contain the true value."""


@dataclass(frozen=True, eq=False)
class AveragedLaw(Portable):
    """The average law of several models."""

    points: CurvePoints
    noise: Averaged
    # shape (models, points); factor of each model over the one that the variance was multiplied with
    bias: FloatArray

    @cached_property
    def weight(self) -> FloatArray:
        """Weights of the models, flattened, shape (models,)."""
        flat = self.noise.weight**FLATTENED
        return np.asarray(flat / flat.sum())

    @cached_property
    def found(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom, shape (points,); -ln X, rising, and its deviate, shape (deviates, models, points)."""
        k, p = self.noise.weight.size, self.points.m.size
        edf, laws = joined([at.laws(self.noise.scale) for at in at_points(self.points, [self.noise.terms])])
        x, deviate = (part.reshape(-1, p, k) for part in table(laws, np.linspace(-REACH, REACH, DEVIATES)))
        logs, deviates = (np.ascontiguousarray(part[::-1].swapaxes(1, 2)) for part in (-np.log(x), -deviate))
        return 1 / ((1 / edf.reshape(p, k)) @ self.weight), logs, deviates

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        return self.found[0], *self.quantiles(np.array([(1 - level) / 2, (1 + level) / 2]))

    def quantiles(self, p: FloatArray) -> FloatArray:
        """T / V at probabilities, shape (probabilities, points)."""
        biased = not (self.bias == 1).all()
        p = (np.append(p, 0.5) if biased else p)[:, None]
        # -ln X at probabilities, by bisection
        _, logs, deviates = self.found
        shape = (p.size, logs.shape[-1])
        low, high = (np.broadcast_to(x, shape) for x in (logs[0].min(axis=0), logs[-1].max(axis=0)))
        for _ in range(MIXTURE_BISECTIONS):
            middle = (low + high) / 2
            below = self.weight @ scipy.special.ndtr(_between(logs, deviates, middle)) < p
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        scatter = np.asarray((low + high) / 2)
        if not biased:
            return np.asarray(np.exp(scatter))
        # logarithm of F at probabilities, between the models by their weights
        order = np.argsort(self.bias, axis=0)
        logs, weight = np.log(np.take_along_axis(self.bias, order, 0)), self.weight[order]
        below = np.cumsum(weight, axis=0) - weight / 2
        bias = np.array([np.interp(p[:, 0], at, values) for at, values in zip(below.T, logs.T, strict=True)]).T
        a, b = (part[:-1] - part[-1] for part in (scatter, bias))
        apart = np.sign(p[:-1] - 0.5) * np.sqrt(a * a + b * b + 2 * TOGETHER * a * b)
        return np.asarray(np.exp(scatter[-1] + bias[-1] + apart))


def _between(logs: FloatArray, deviates: FloatArray, x: FloatArray) -> FloatArray:
    """Deviate of each law at x, shape (probabilities, models, points); straight beyond the ends."""
    x = x[:, None]
    at = np.clip((logs[:, None] < x).sum(axis=0), 1, len(logs) - 1)
    (a, b), (low, high) = ([np.take_along_axis(y, k, 0) for k in (at - 1, at)] for y in (logs, deviates))
    return np.asarray(low + (x - a) / np.maximum(b - a, 1e-300) * (high - low))


class SupposedNoise(NamedTuple):
    """Models with their weights, or "auto" for the power law at each averaging time."""

    # `words` describes the intervals in a short phrase.
    noise: Averaged | Literal["auto"]
    words: str


Limits = tuple[FloatArray, FloatArray, FloatArray]  # degrees of freedom, lower and upper limits over the variance

Supposing = ModelLike | Literal["auto"] | Callable[[], SupposedNoise]
"""Noise that intervals assume; a function is called when they are first needed."""


def supposed(noise: ModelLike | Literal["auto"]) -> SupposedNoise:
    """A choice of the noise, with its description."""
    choice = noise_choice(noise)
    if not isinstance(choice, Averaged):
        return SupposedNoise("auto", say("intervals for the power law identified at each averaging time"))
    fit = noise if isinstance(noise, Fit) else None
    if len(choice) == 1:
        under = say("intervals under the given model {model}", model=str(choice.terms))
        if fit:
            under = say("intervals under the identified model {model}", model=str(choice.terms))
    else:
        present = {term.symbol for term in choice.terms}
        symbols = ", ".join(symbol for symbol in TERMS if symbol in present)
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
    """The law `under` a noise that is identified on first use; pickled as the result."""

    # Limits are computed once for each level, also for curves that share them: the same curve in other units.
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
