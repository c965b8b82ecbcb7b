"""Compile the kernels that most tests need, once: otherwise each process of the tests compiles them."""

import numpy as np

import allanite as al


def main() -> None:
    """Run jobs that need them."""
    rng = np.random.default_rng(1)
    record = al.simulate(al.sensor("mems"), 3000, 100.0, rng=rng)
    values = np.where(rng.random(3000) < 0.03, np.nan, record.values)
    gaps = al.Record(values, record.rate, "rad/s")
    for name in al.STATISTICS:
        al.deviation(record, name, noise=None)
    for name in ("oadev", "theo1"):
        al.deviation(record, name, taus="all", noise=None)
    al.identify(al.deviation(record, "oadev"), method="gls")
    al.deviation(gaps, gaps="complete")
    for job in (al.analyze, al.dynamic, al.spectrum):
        job(record)
    al.analyze(gaps)


if __name__ == "__main__":
    main()
