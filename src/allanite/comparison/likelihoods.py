"""Likelihoods of independent records: tied together, reduced to some terms, drawn anew."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.identification.likelihood.likelihood import Likelihood

RANK = 1e-9
"""Share of a bin's largest direction below which another is none."""


def reduced(part: Likelihood, columns: BoolArray) -> Likelihood:
    """The likelihood of some of the terms; a direction to which none of them adds is dropped."""
    W = part.W[:, columns]
    kept = part.flat | W.any(axis=1)
    return replace(
        part,
        S=part.S[:, columns],
        UU=part.UU[:, kept][:, :, kept],
        Uc=part.Uc[:, kept],
        W=W[kept],
        flat=part.flat[kept],
    )


def tied(parts: Sequence[Likelihood], maps: Sequence[FloatArray] | None = None) -> Likelihood:
    """One likelihood of all parts, theta of part j being maps[j] @ theta; without maps one theta for all."""
    maps = maps or [np.eye(part.S.shape[1]) for part in parts]
    sizes = np.cumsum([0, *(part.flat.size for part in parts)])
    bins = np.cumsum([0, *(part.count.size for part in parts)])
    UU, Uc = np.zeros((bins[-1], sizes[-1], sizes[-1])), np.zeros((bins[-1], sizes[-1]))
    for part, i, j in zip(parts, bins, sizes, strict=False):
        here, own = slice(i, i + part.count.size), slice(j, j + part.flat.size)
        UU[here, own, own], Uc[here, own] = part.UU, part.Uc
    return Likelihood(
        S=np.concatenate([part.S @ H for part, H in zip(parts, maps, strict=True)]),
        power=np.concatenate([part.power for part in parts]),
        count=np.concatenate([part.count for part in parts]),
        UU=UU,
        Uc=Uc,
        W=np.concatenate([part.W @ H for part, H in zip(parts, maps, strict=True)]),
        flat=np.concatenate([part.flat for part in parts]),
    )


def least(parts: Sequence[Likelihood], start: FloatArray | None = None) -> tuple[list[FloatArray], float]:
    """Theta of each part by itself, and the sum of the minima of L."""
    free = np.ones(parts[0].S.shape[1], dtype=bool)
    found = [part.minimise(free, start) for part in parts]
    return [theta for theta, _ in found], sum(value for _, value in found)


def drawn(part: Likelihood, theta: FloatArray, rng: "np.random.Generator") -> Likelihood:
    """The same likelihood for powers drawn at random under a model.

    In each bin the coefficients have as many components along the directions as these span (F F' = UU), and the rest of
    the count beside them.
    """
    m = part.expectation(theta)
    value, vector = np.linalg.eigh(part.UU)
    there = value > RANK * np.maximum(value.max(axis=1, initial=0.0), 1e-300)[:, None]
    F = vector * np.sqrt(np.where(there, value, 0.0))[:, None, :]
    z = rng.standard_normal(there.shape) * np.sqrt(m)[:, None] * there
    rest = np.maximum(part.count - there.sum(axis=1), 0.0)
    squares = (z**2).sum(axis=1) + m * 2 * rng.standard_gamma(rest / 2)
    eta = np.where(part.flat, 0.0, np.sqrt(part.W @ theta)) * rng.standard_normal(part.flat.size)
    Uc = np.einsum("bij,bj->bi", F, z)
    squares += (part.UU @ eta) @ eta + 2 * Uc @ eta
    return replace(part, power=squares / part.count, Uc=Uc + part.UU @ eta)
