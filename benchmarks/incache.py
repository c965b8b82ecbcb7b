"""The in-cache bound: what differences at many averaging factors would take if every sample came from the first cache.

u is the time of one difference of order 2 or 3, squared and summed, over 1000 neighbouring samples of an array that the
first-level cache holds: three or four loads and four or five operations a sample and tau. The bound of a job is u times
its differences; its share is the bound over the job's whole time, with integration.
"""

import time
from collections.abc import Callable, Sequence

import numpy as np
from numba import njit

import allanite as al

INCORE = 1000

DIFFERENCES = {"oadev": 2, "mdev": 3, "ohdev": 3}
"""Order of the differences; mdev takes those of the angle's running sum."""


@njit(fastmath={"reassoc", "nsz", "contract"})
def one_difference(x, m, rounds):
    """Second differences, squared and summed, over an array that fits the first-level cache; nothing else."""
    total = 0.0
    for turn in range(rounds):
        first = x[turn % 8 : INCORE + turn % 8]
        middle = x[turn % 8 + m : INCORE + turn % 8 + m]
        last = x[turn % 8 + 2 * m : INCORE + turn % 8 + 2 * m]
        part = 0.0
        for i in range(INCORE):
            d = (last[i] - middle[i]) - (middle[i] - first[i])
            part += d * d
        total += part
    return total


@njit(fastmath={"reassoc", "nsz", "contract"})
def third_difference(x, m, rounds):
    """The same of third differences."""
    total = 0.0
    for turn in range(rounds):
        a, b = x[turn % 8 : INCORE + turn % 8], x[turn % 8 + m : INCORE + turn % 8 + m]
        c = x[turn % 8 + 2 * m : INCORE + turn % 8 + 2 * m]
        d = x[turn % 8 + 3 * m : INCORE + turn % 8 + 3 * m]
        part = 0.0
        for i in range(INCORE):
            e = (d[i] - a[i]) - 3.0 * (c[i] - b[i])
            part += e * e
        total += part
    return total


def shortest(job: Callable[[], object], rounds: int) -> float:
    """Least processor time of several, s."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        job()
        times.append(time.process_time() - start)
    return min(times)


def unit(order: int, rounds: int = 20_000) -> float:
    """U of differences of this order, s."""
    x = np.random.default_rng(1).standard_normal(5 * INCORE)
    kernel = {2: one_difference, 3: third_difference}[order]
    kernel(x, INCORE, 10)
    return shortest(lambda: kernel(x, INCORE, rounds), 3) / (rounds * INCORE)


def differences(size: int, m: Sequence[int], order: int) -> float:
    """Differences of all averaging factors of a record."""
    return float(np.sum(size + 1 - order * np.asarray(m, dtype=np.float64)))


def share(record: al.Record, statistic: str, turns: int = 7) -> tuple[float, float, float]:
    """Share of the in-cache bound at the tau of the log grid, u and the job's time, s.

    The bound and the job are measured by turns: both see the same machine.
    """
    order = DIFFERENCES[statistic]
    m = al.deviation(record, statistic, taus="log").m.tolist()
    times = [(unit(order), shortest(lambda: al.deviation(record, statistic, m=m), 2)) for _ in range(turns)]
    u, job = (min(each) for each in zip(*times, strict=True))
    return u * differences(record.size, m, order) / job, u, job
