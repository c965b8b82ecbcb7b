"""Averaged: the models that are consistent with a record, with their weights."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .arrays import FloatArray
from .errors import UsageError, given
from .model import Model, ModelLike, Term, model_of
from .plain import Value


@dataclass(frozen=True, eq=False, repr=False)
class Averaged(Value):
    """Models that are consistent with a record, each with its weight.

    Examples
    --------
    >>> from allanite import K, N
    >>> quiet, drifting = N(0.1, "deg/sqrt(h)"), N(0.1, "deg/sqrt(h)") + K(1, "deg/h/sqrt(h)")
    >>> both = averaged([quiet, drifting], [0.75, 0.25])
    >>> print(both.model)
    N = 0.1 deg/sqrt(h), K = 0.5 deg/h/sqrt(h)
    """

    terms: Model  # every term that occurs in at least one of the models
    # shape (k, t); power of each term in each model over its power in `terms`; 0 where the model lacks it
    scale: FloatArray
    weight: FloatArray  # shape (k,); weight of each model; the weights sum to 1

    @property
    def model(self) -> Model:
        """The model with the mean powers: what it predicts is the weighted mean of the predictions of the models."""
        return _scaled(self.terms, self.weight @ self.scale)

    def __iter__(self) -> Iterator[tuple[Model, float]]:
        for scale, weight in zip(self.scale, self.weight.tolist(), strict=True):
            yield _scaled(self.terms, scale), weight

    def __len__(self) -> int:
        return self.weight.size

    def _summary(self) -> str:
        return f"{len(self)} models of {', '.join(term.symbol for term in self.terms)}"


def _scaled(terms: Model, scale: FloatArray) -> Model:
    kept = zip(terms, scale.tolist(), strict=True)
    return Model(tuple(Term(t.symbol, t.value * s**0.5, t.signal, t.shape) for t, s in kept if s > 0))


def averaged(models: Sequence[ModelLike], weights: Sequence[float] | FloatArray) -> Averaged:
    """Models with their weights."""
    weight = np.asarray(weights, dtype=np.float64)
    if not models or weight.shape != (len(models),) or not (weight > 0).all():
        raise UsageError(f"{len(models)} models need as many positive weights, not {weights!r}")
    each = [model_of(model) for model in models]
    sizes: dict[Any, Term] = {}
    for term in (term for model in each for term in model):
        key = term.symbol, term.shape
        if key not in sizes or abs(term.value) > abs(sizes[key].value):
            sizes[key] = term
    scale = np.zeros((len(each), len(sizes)))
    where = {key: i for i, key in enumerate(sizes)}
    for row, model in zip(scale, each, strict=True):
        for term in model:
            key = term.symbol, term.shape
            row[where[key]] = (term.value / sizes[key].value) ** 2
    return Averaged(Model(tuple(sizes.values())), scale, weight / weight.sum())


def noise_choice(value: ModelLike | Literal["auto"] | None) -> Averaged | Literal["auto"] | None:
    """The noise assumed for confidence intervals: models, "auto" for the noise of the record, None for no intervals.

    A model or a term is used as given; a fit represents all models that are consistent with its record.
    """
    if value is None or (isinstance(value, str) and value == "auto"):
        return value
    if isinstance(value, str):
        raise UsageError(
            "noise must be a Model, a Term such as N(0.01, 'deg/sqrt(h)'), a Fit, 'identified', 'auto' or None, not "
            f"{given(value)}; allanite.Model(text) makes one of a text"
        )
    found = value if isinstance(value, Averaged) else getattr(value, "averaged", None)
    return found if isinstance(found, Averaged) else averaged([value], [1.0])
