"""Errors of the angle of a filter that is aided and then left alone: what it predicts, and what they are.

A filter of a model of a gyro takes a measurement of the angle every second, during AIDED seconds; after it, the angle
is the integral of the gyro less the bias that was estimated. Its errors are linear in the noise of the gyro, with
weights that do not depend on data: of many filters at once they are found by one recursion, and applied to noise of the
independent simulator or to its exact covariance.
"""

from table import coefficients

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

import allanite as al
from allanite.statespace.build import MarkovSum, Matrices, averaged, blocks_of, equivalent, flicker_sum, states_of
from allanite.terms.row import Block
from judge import sensor

OUTAGES = (1, 10, 60, 300, 600, 1000)  # times without aid, s
AIDED = 1000  # seconds of aid before

BEFORE = 60
"""Seconds before the aid, whose mean rate is removed from drifts without a variance, as by a calibration at rest."""

TURN_ON = 1e-2
"""Standard deviation of the bias at the start in each filter, rad/s: large, since noise does not determine it."""

Array = np.ndarray


@cache
def flicker() -> MarkovSum:
    """Flicker with B = 1 as Gauss-Markov processes."""
    return flicker_sum((1.0, float(OUTAGES[-1])))


def states(model: al.Model) -> tuple[list[Block], Array]:
    """The model as states at steps of 1 s, flicker as Gauss-Markov processes, and its white noise."""
    blocks = blocks_of(equivalent(model, flicker()), 1.0)
    return blocks, np.array([[sum(block.white for block in blocks)]])


def best(model: al.Model) -> Matrices:
    """The state space of a model; with a constant bias of unknown size if a term of it has no variance."""
    blocks, white = states(model)
    return averaged(states_of(blocks, 0.0 if all(map(stationary, model)) else TURN_ON, 1.0), white)


def target(model: al.Model) -> Matrices:
    """The states of a target's filter: its bias is unknown at the start; none if the target has no state for it."""
    alone = all(t.symbol == "N" for t in model)
    blocks, white = states(model + al.Term("K", 0.0, model.signal) if alone else model)
    found = averaged(states_of(blocks, 0.0, 1.0), white)
    if not alone:
        found.P0[0, 0] += TURN_ON**2
    return found


@dataclass(frozen=True, eq=False)
class Filters:
    """Filters: predicted standard deviation of the angle at each outage, and the weights of its error.

    `sigma` (filters, outages), rad; `past` (filters, outages, AIDED) on the mean rates while aided, oldest first, and
    `aid` (the same) on the errors of the measurements; the weight of each rate of the outage is 1.
    """

    sigma: Array
    past: Array
    aid: Array


def filters(spaces: Sequence[Matrices], accuracy: float) -> Filters:
    """Kalman filters of state spaces, with angles of an accuracy in rad."""
    n, k = len(spaces), len(OUTAGES)
    found = Filters(np.empty((n, k)), np.empty((n, k, AIDED)), np.empty((n, k, AIDED)))
    for size in {len(space.Phi) for space in spaces}:
        at = [i for i, space in enumerate(spaces) if len(space.Phi) == size]
        part = _alike([spaces[i] for i in at], accuracy)
        found.sigma[at], found.past[at], found.aid[at] = part.sigma, part.past, part.aid
    return found


def _alike(spaces: Sequence[Matrices], accuracy: float) -> Filters:
    """Filters of spaces of the same size."""
    r, s = len(spaces), 1 + len(spaces[0].Phi)
    F, Q, P = (np.zeros((r, s, s)) for _ in range(3))
    for i, one in enumerate(spaces):
        h = one.H[0]
        F[i, 0] = np.append(1.0, h @ one.Phi)
        F[i, 1:, 1:] = one.Phi
        Q[i, 1:, 1:] = one.Qd
        Q[i, 0, 1:] = Q[i, 1:, 0] = one.Qd @ h
        Q[i, 0, 0] = h @ one.Qd @ h + one.R[0, 0]
        P[i, 1:, 1:] = one.P0
    T = F.transpose(0, 2, 1)
    gains = np.empty((AIDED, r, s))
    for k in range(AIDED):
        P = F @ P @ T + Q
        gains[k] = gain = P[:, :, 0] / (P[:, 0, 0] + accuracy**2)[:, None]
        P = P - gain[:, :, None] * P[:, None, 0]
        P = (P + P.transpose(0, 2, 1)) / 2
    sigma, u, power = np.empty((r, len(OUTAGES))), np.empty((r, len(OUTAGES), s)), np.broadcast_to(np.eye(s), F.shape)
    for t in range(1, OUTAGES[-1] + 1):
        P, power = F @ P @ T + Q, F @ power
        if t in OUTAGES:
            i = OUTAGES.index(t)
            sigma[:, i], u[:, i] = np.sqrt(P[:, 0, 0]), power[:, 0]
    aid = np.empty((r, len(OUTAGES), AIDED))
    for k in range(AIDED - 1, -1, -1):
        aid[:, :, k] = np.einsum("rus,rs->ru", u, gains[k])
        u = u.copy()
        u[:, :, 0] -= aid[:, :, k]
        u = u @ F
    return Filters(sigma, 1 - np.cumsum(aid[:, :, ::-1], axis=2)[:, :, ::-1], -aid)


def covariance(model: al.Model) -> Array:
    """Covariance of the mean rates over seconds, from the structure function of each term: AIDED, then the outage."""
    n = BEFORE + AIDED + OUTAGES[-1]
    lag = np.arange(float(n))
    index = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    C = np.zeros((n, n))
    for t in model:
        D = t.sampled(1.0).structure
        part = (t.power(1.0) * (D(lag + 1) - 2 * D(lag) + D(np.abs(lag - 1))) / 2)[index]
        if not stationary(t):
            mean = part[:BEFORE].mean(axis=0)
            part += mean[:BEFORE].mean() - mean - mean[:, None]
        C += part
    return C[BEFORE:, BEFORE:]


def stationary(term: al.Term) -> bool:
    """Whether the mean rate over a second has a variance."""
    return term.symbol not in ("B", "K")


@dataclass(frozen=True, eq=False)
class Truth:
    """Noise: covariances of the mean rates while aided with each other and with their sum over each outage."""

    past: Array
    cross: Array
    ahead: Array

    def errors(self, found: Filters, accuracy: float) -> Array:
        """Standard deviations of the errors of filters, shape (filters, outages), rad."""
        past = np.einsum("rok,kl,rol->ro", found.past, self.past, found.past, optimize=True)
        cross = 2 * np.einsum("rok,ok->ro", found.past, self.cross)
        return np.sqrt(past + cross + self.ahead + accuracy**2 * (found.aid**2).sum(axis=2))


def truth(model: al.Model) -> Truth:
    """The exact moments of a model."""
    C = covariance(model)
    ends = [AIDED + t for t in OUTAGES]
    cross = np.array([C[:AIDED, AIDED:end].sum(axis=1) for end in ends])
    return Truth(C[:AIDED, :AIDED], cross, np.array([C[AIDED:end, AIDED:end].sum() for end in ends]))


def noise(model: al.Model, runs: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Simulated mean rates while aided, shape (runs, AIDED), and angles at the end of each outage, (runs, outages)."""
    n = BEFORE + AIDED + OUTAGES[-1]
    still, moving = (coefficients(t for t in model if stationary(t) == kind) for kind in (True, False))
    y = np.empty((runs, n))
    for i in range(runs):
        drift = sensor(n, 1.0, rng, **moving)
        y[i] = sensor(n, 1.0, rng, **still) + drift - drift[:BEFORE].mean()
    return y[:, BEFORE : BEFORE + AIDED], np.cumsum(y[:, BEFORE + AIDED :], axis=1)[:, np.array(OUTAGES) - 1]
