"""Formulas of the papers by their literal referees, on the samples of a file at 1 Hz."""

import math
from functools import partial

import numpy as np
from tests import reference

import allanite as al


def values(name):
    return al.read(name).records[0].values


def angle(name):
    return np.concatenate(([0.0], np.cumsum(values(name))))


def by_referee(statistic, name, m):
    return math.sqrt(reference.REFEREES[statistic](angle(name), m, 1.0))


allan = partial(by_referee, "adev")  # eq. 2 of 000 and eq. 3 of 001
overlapping = partial(by_referee, "oadev")  # eq. 8 of 000, with the sequence that starts at zero
hadamard = partial(by_referee, "ohdev")  # eq. 12 of 000, with the averages that it means
theo1 = partial(by_referee, "theo1")  # eq. 6 of 001 as the double sum that it is


def kf(name):
    """Eq. 9 of 001: the mean ratio of Allan to Theo1 at the same times, as a factor of the deviation."""
    return math.sqrt(reference.theo.kf(angle(name), 1.0))


def stability(name, m):
    return np.std(values(name).reshape(-1, m).mean(axis=1), ddof=1)
