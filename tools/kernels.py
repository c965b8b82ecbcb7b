"""Compile the kernels that most tests need, once, by two processes: otherwise those of the tests compile them.

Both processes take about as long; what one has compiled, the other loads.
"""

import multiprocessing
import sys

import numpy as np

import allanite as al

RATE = 100.0


def record(missing: float = 0.0) -> al.Record:
    """Samples of a MEMS gyroscope, of which a share is missing."""
    rng = np.random.default_rng(1)
    values = al.simulate(al.sensor("mems"), 3000, RATE, rng=rng).values
    return al.Record(np.where(rng.random(values.size) < missing, np.nan, values), RATE, "rad/s")


def analyses() -> None:
    """What the analyses need, of files and of streams."""
    al.analyze(record())
    al.analyze(record(missing=0.03))
    al.deviation(record(missing=0.03), gaps="complete")
    al.identify(al.deviation(record(), "oadev"), method="gls")
    al.spectrum(record())
    for statistic in ("oadev", "mdev"):
        first, second = (al.Accumulator(RATE, "rad/s", statistic=statistic, start=start) for start in (0, 3000))
        for part in (first, second):
            part.push(record().values)
        first.merge(second)


def statistics() -> None:
    """What the statistics need, those first that take long."""
    for name in ("mtotdev", "theoh", *al.statistics.STATISTICS):
        al.deviation(record(), name, noise=None)
    al.dynamic(record())
    for name in ("oadev", "theo1"):
        al.deviation(record(), name, taus="all", noise=None)


def main() -> int:
    """Run jobs that need them; the exit code is that of the process that failed."""
    other = multiprocessing.get_context("spawn").Process(target=statistics)
    other.start()
    analyses()
    other.join()
    return other.exitcode or 0


if __name__ == "__main__":
    sys.exit(main())
