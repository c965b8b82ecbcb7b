"""How fast: overlapped Allan and the whole analysis against the machine's own limit, and start-up against numpy's.

    python benchmarks/speed.py [--samples 3600000] [--write PATH]

One thread everywhere; every figure is the best of several rounds of one run, and only ratios are to be trusted.
Ends with exit code 1 if a bound is missed.
"""

from table import begin, markdown

import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba import njit

import allanite as al
from allanite.identification.likelihood.families import look

INCORE = 1000


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


def best(job: Callable[[], object], rounds: int = 7) -> float:
    """Shortest time of several, s."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        job()
        times.append(time.perf_counter() - start)
    return min(times)


def startup(command: list[str], rounds: int = 11) -> float:
    return best(lambda: subprocess.run(command, capture_output=True, check=True), rounds)


def allocated(job: Callable[[], object]) -> int:
    """Largest memory allocated at a time, bytes."""
    tracemalloc.start()
    job()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def main() -> int:
    run = begin(__doc__, samples=3_600_000)
    samples = run.asked.samples
    model = al.N(0.01, "deg/sqrt(h)") + al.B(0.1, "deg/h") + al.K(0.1, "deg/h/sqrt(h)")
    record = al.simulate(model, samples, 100.0, rng=np.random.default_rng(1))
    curve = al.deviation(record, "oadev", taus="log")
    terms = samples * curve.m.size
    x, rounds = np.random.default_rng(1).standard_normal(4 * INCORE), 100_000
    one_difference(x, 1000, 10)
    al.analyze(record)

    u = min(best(lambda: one_difference(x, 1000, rounds), 3) for _ in range(3)) / (rounds * INCORE)
    allan = best(lambda: al.deviation(record, "oadev", m=curve.m.tolist()))
    u = min(u, best(lambda: one_difference(x, 1000, rounds), 3) / (rounds * INCORE))
    analysis = best(lambda: al.analyze(record), 5)
    selected = best(lambda: look(record, "QNBKR", None, rival=True))
    identified = best(lambda: al.identify(record))
    peer = best(lambda: peer_oadev(record, curve.m), 3)
    numpy_alone = startup([sys.executable, "-c", "import numpy"])
    importing = startup([sys.executable, "-c", "import allanite"])
    helping = startup([str(Path(sys.executable).with_name("allanite")), "--help"])
    numpy_alone = min(numpy_alone, startup([sys.executable, "-c", "import numpy"]))
    memory = allocated(lambda: al.analyze(record)) / record.values.nbytes
    reading, parsing = read_csv()
    rows = [
        ("overlapped Allan with integration, per sample and tau, over u", allan / terms / u, 2.2, "<="),
        ("allantools' oadev over ours, same 100 tau", peer / allan, 8.0, ">="),
        (
            "identification: transform, every subset of terms, selection, over the overlapped Allan",
            selected / allan,
            1.5,
            "<=",
        ),
        (
            "the same with outliers, search for sinusoids, limits, over the overlapped Allan",
            identified / allan,
            3.0,
            "<=",
        ),
        ("whole analysis of one channel over the overlapped Allan", analysis / allan, 6.0, "<="),
        ("reading a CSV of 1000000 rows with stamps over pyarrow's own", reading / parsing, 2.0, "<="),
        ("`import allanite` over `import numpy`", importing / numpy_alone, 1.8, "<="),
        ("`allanite --help` over `import numpy`", helping / numpy_alone, 2.2, "<="),
        ("memory of the analysis over the record", memory, 6.0, "<="),
    ]
    notes = [
        "seed 1; one thread",
        f"u = {1e9 * u:.3f} ns; overlapped Allan at {curve.m.size} tau of {samples} samples "
        f"{1e3 * allan:.0f} ms ({1e9 * allan / terms:.3f} ns per sample and tau)",
        f"analysis {1e3 * analysis:.0f} ms; import numpy {1e3 * numpy_alone:.0f} ms",
        f"load {os.getloadavg()[0]:.1f}",
    ]
    met = [value <= bound if sense == "<=" else value >= bound for _, value, bound, sense in rows]
    cells = [
        (what, f"{value:.2f}", f"{sense} {bound:g}", "met" if good else "MISSED")
        for (what, value, bound, sense), good in zip(rows, met, strict=True)
    ]
    run.publish("Speed, as ratios", notes, markdown(("what", "measured", "wanted", ""), cells))
    return 0 if all(met) else 1


def read_csv(rows: int = 1_000_000) -> tuple[float, float]:
    """Times of reading stamps and three channels from text: with everything that is checked, and by pyarrow alone."""
    import pyarrow as pa
    from pyarrow import csv

    pa.set_cpu_count(1)
    values = np.random.default_rng(1).standard_normal((3, rows)).round(6)
    names = ("time [s]", "gx [deg/s]", "gy [deg/s]", "gz [deg/s]")
    table = pa.table(dict(zip(names, (np.arange(rows) * 0.01, *values), strict=True)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "gyro.csv")
        csv.write_csv(table, path)
        times = [(best(lambda: al.read(path), 1), best(lambda: csv.read_csv(path), 1)) for _ in range(7)]
    ours, theirs = zip(*times, strict=True)
    return min(ours), min(theirs)


def peer_oadev(record: al.Record, m: np.ndarray) -> object:
    import allantools

    return allantools.oadev(record.values, rate=record.rate, data_type="freq", taus=m / record.rate)


if __name__ == "__main__":
    sys.exit(main())
