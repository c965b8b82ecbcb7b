"""How fast: statistics and the whole analysis against the machine's own limit, peers, and start-up of numpy.

One thread, processor time, the shortest of several rounds of one run; only ratios are to be trusted. Growth: the time
by the record's length beside allantools and numpy, extrapolated by the number of their inner terms from a part that
takes at least 5 s; errors against the definitions, and memory. Ends with exit code 1 if a demand is missed.

u is the time of one difference of order 2 or 3, squared and summed, over 1000 neighbouring samples of an array that the
first-level cache holds. The in-cache bound of a job is u times its differences; its share is the bound over the job's
whole time, with integration.
"""

from table import Run, begin, least, markdown, section

import os
import resource
import subprocess
import sys
import tempfile
import tracemalloc
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit

import allanite as al
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search.identify import searched
from allanite.kernels.squared import overlapped
from allanite.kernels.theo import theo1
from allanite.statistics.grids import GRIDS

RATE = 100.0
MODEL = al.N(0.01, "deg/sqrt(h)") + al.B(0.1, "deg/h") + al.K(0.1, "deg/h/sqrt(h)")
INCORE = 1000
ENOUGH = 5.0  # seconds that a part of a peer's job takes at least before it is extrapolated

DIFFERENCES = {"oadev": 2, "mdev": 3, "ohdev": 3}
"""Order of the differences; mdev takes those of the angle's running sum."""


@njit(fastmath={"reassoc", "nsz", "contract"})
def second_differences(x, m, rounds):
    total = 0.0
    for turn in range(rounds):
        first, middle = x[turn % 8 : INCORE + turn % 8], x[turn % 8 + m : INCORE + turn % 8 + m]
        last = x[turn % 8 + 2 * m : INCORE + turn % 8 + 2 * m]
        part = 0.0
        for i in range(INCORE):
            d = (last[i] - middle[i]) - (middle[i] - first[i])
            part += d * d
        total += part
    return total


@njit(fastmath={"reassoc", "nsz", "contract"})
def third_differences(x, m, rounds):
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


def unit(order: int, rounds: int = 20_000) -> float:
    """U of differences of this order, s."""
    x = np.random.default_rng(1).standard_normal(5 * INCORE)
    kernel = {2: second_differences, 3: third_differences}[order]
    kernel(x, INCORE, 10)
    return least(lambda: kernel(x, INCORE, rounds), 3) / (rounds * INCORE)


def differences(size: int, m: Sequence[int], order: int = 2) -> float:
    """Differences of all averaging factors of a record."""
    return float(np.sum(size + 1 - order * np.asarray(m, dtype=np.float64)))


def share(record: al.Record, statistic: str, turns: int = 7) -> tuple[float, float, float]:
    """Share of the in-cache bound at the tau of the log grid, u and the job's time, s; measured by turns.

    Here and below `replace` makes a record of which no curve is known.
    """
    order = DIFFERENCES[statistic]
    m = al.deviation(record, statistic, taus="log").m.tolist()
    times = [(unit(order), least(lambda: al.deviation(replace(record), statistic, m=m), 2)) for _ in range(turns)]
    u, job = (min(each) for each in zip(*times, strict=True))
    return u * differences(record.size, m, order) / job, u, job


class Demand(NamedTuple):
    """What was measured, and what was wanted of it."""

    what: str
    value: float
    bound: float
    sense: str = "<="
    ours: float = 0.0
    peer: float = 0.0

    @property
    def met(self) -> bool:
        """Whether it is as wanted."""
        return self.value <= self.bound if self.sense == "<=" else self.value >= self.bound


def table(demands: Iterable[Demand]) -> list[str]:
    """Lines of the table of demands."""
    rows = []
    for d in demands:
        times = (f"{seconds:.3g}" if seconds else "" for seconds in (d.ours, d.peer))
        rows.append((d.what, *times, f"{d.value:.3g}", f"{d.sense} {d.bound:g}", "met" if d.met else "MISSED"))
    return markdown(("what", "ours [s]", "peer [s]", "measured", "wanted", ""), rows)


def record_of(size: int) -> al.Record:
    return al.simulate(MODEL, size, RATE, rng=np.random.default_rng(1))


def allantools_of(statistic: str, record: al.Record, m: Sequence[int]) -> object:
    """The statistic of the peer at averaging factors."""
    import allantools

    taus = np.asarray(m) / record.rate
    return getattr(allantools, statistic)(record.values, rate=record.rate, data_type="freq", taus=taus)


# --- ratios ----------------------------------------------------------------------------------------------------------


def startups(commands: list[list[str]], rounds: int = 11) -> list[float]:
    """Least processor time of each command, by turns, s."""
    return np.min([[_processor(command) for command in commands] for _ in range(rounds)], axis=0).tolist()


def _processor(command: list[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def allocated(job: Callable[[], object]) -> int:
    """Largest memory allocated at a time, bytes."""
    tracemalloc.start()
    job()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def read_csv(rows: int = 1_000_000) -> tuple[float, float]:
    """Times of reading stamps and three channels from text: with everything that is checked, and by pyarrow alone."""
    import pyarrow as pa
    from pyarrow import csv

    pa.set_cpu_count(1)
    values = np.random.default_rng(1).standard_normal((3, rows)).round(6)
    names = ("time [s]", "gx [deg/s]", "gy [deg/s]", "gz [deg/s]")
    text = pa.table(dict(zip(names, (np.arange(rows) * 0.01, *values), strict=True)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "gyro.csv")
        csv.write_csv(text, path)
        times = [(least(lambda: al.read(path), 1), least(lambda: csv.read_csv(path), 1)) for _ in range(7)]
    ours, theirs = zip(*times, strict=True)
    return min(ours), min(theirs)


def selection(record: al.Record) -> object:
    """The search in a record for what explains it, without its sinusoids."""
    return searched(spectrum(replace(record), detrend=True), "QNBKR", "auto", rival=True)


def ratios(run: Run) -> bool:
    """The table of what one record takes."""
    record = record_of(run.asked.samples)
    curve = al.deviation(record, "oadev", taus="log")
    al.analyze(record)
    bounds = {name: share(record, name) for name in DIFFERENCES}
    select = partial(selection, record)
    select()
    jobs = [
        lambda: al.deviation(replace(record), "oadev", m=curve.m.tolist()), select,
        lambda: al.identify(replace(record)), lambda: al.analyze(replace(record)),
    ]  # fmt: skip
    rounds = [[least(job, 1) for job in jobs] for _ in range(7)]
    allan, selected, identified, analysis = np.min(rounds, axis=0).tolist()
    peer = least(lambda: allantools_of("oadev", record, curve.m), 3)
    program = str(Path(sys.executable).with_name("allanite"))
    commands = [[sys.executable, "-c", f"import {name}"] for name in ("numpy", "allanite")]
    numpy_alone, importing, helping = startups([*commands, [program, "--help"]])
    memory = allocated(lambda: al.analyze(replace(record))) / record.values.nbytes
    reading, parsing = read_csv()
    bound = "{} at {} tau, with integration: share of the in-cache bound"
    demands = [
        *(Demand(bound.format(name, curve.m.size), bounds[name][0], 0.8, ">=") for name in DIFFERENCES),
        Demand("allantools' oadev over ours, same 100 tau", peer / allan, 8.0, ">=", allan, peer),
        Demand("identification: transform, every subset of terms, selection, over oadev", selected / allan, 1.0),
        Demand("the same with outliers, search for sinusoids, limits, over oadev", identified / allan, 3.0),
        Demand("whole analysis of one channel over oadev", analysis / allan, 6.0, ours=analysis),
        Demand("reading a CSV of 1000000 rows with stamps over pyarrow's own", reading / parsing, 2.0),
        Demand("`import allanite` over `import numpy`", importing / numpy_alone, 1.3),
        Demand("`allanite --help` over `import numpy`", helping / numpy_alone, 2.2),
        Demand("memory of the analysis over the record", memory, 6.0),
    ]
    notes = [
        "seed 1; one thread, processor time",
        *(f"{name}: u = {1e9 * u:.3f} ns; the job {1e3 * job:.0f} ms" for name, (_, u, job) in bounds.items()),
        f"identification {1e3 * selected:.0f} ms, overlapped Allan beside it {1e3 * allan:.0f} ms",
        f"analysis {1e3 * analysis:.0f} ms; import numpy {1e3 * numpy_alone:.0f} ms",
        f"load {os.getloadavg()[0]:.1f}",
    ]
    run.publish("Speed, as ratios", notes, table(demands))
    return all(demand.met for demand in demands)


# --- growth ----------------------------------------------------------------------------------------------------------


class Job(NamedTuple):
    """A job of ours by the record's length, and the inner terms that a peer sums for it."""

    title: str
    run: Callable[[al.Record], object]
    sizes: Sequence[int]
    peer: str = ""
    terms: Callable[[int], float] = lambda _: 0.0


def log_factors(largest: int, points: int) -> list[int]:
    return np.unique(np.rint(np.geomspace(1, largest, points)).astype(int)).tolist()


def theo1_terms(n: int, m: Sequence[int]) -> float:
    m = np.asarray(m, dtype=np.float64)
    return float(np.sum(m / 2 * (n + 1 - m)))


def mtot_terms(n: int, m: Sequence[int]) -> float:
    m = np.asarray(m, dtype=np.float64)
    return float(np.sum(6 * m * (n + 2 - 3 * m)))


WINDOW = log_factors(36_000 // 2, 52)  # averaging factors of a window of 36000 samples


def curve(statistic: str, taus: str = "all", m: Callable[[int], Sequence[int]] | None = None) -> Callable[..., object]:
    how = (lambda n: {"m": m(n)}) if m else (lambda _: {"taus": taus})
    return lambda record: al.deviation(replace(record), statistic, noise=None, **how(record.size))


def dynamic(record: al.Record) -> object:
    samples = record.size // 100
    m = [k for k in WINDOW if k <= samples // 2]
    return al.dynamic(record, window=samples / RATE, step=samples / 100 / RATE, m=m)


HOURS, SHORT, LEAST = (3_600, 36_000, 360_000, 3_600_000), (720, 7_200, 72_000, 720_000), (72, 720, 7_200, 72_000)
THOUSANDS = (1_000, 10_000, 100_000, 1_000_000)
JOBS = {
    "oadev log": Job("oadev, 100 tau", curve("oadev", "log"), HOURS),
    "oadev all": Job(
        "oadev, every tau", curve("oadev"), HOURS, "oadev", lambda n: differences(n, np.arange(1, n // 2 + 1))
    ),
    "ohdev all": Job("ohdev, every tau", curve("ohdev"), HOURS),
    "mdev all": Job("mdev, every tau", curve("mdev"), HOURS),
    "theo1 log": Job("theo1, 100 tau", curve("theo1", "log"), SHORT),
    "theo1 all": Job(
        "theo1, every even m", curve("theo1"), LEAST, "theo1", lambda n: theo1_terms(n, np.arange(2, n + 1, 2))
    ),
    "theoh log": Job("theoh, 100 tau", curve("theoh", "log"), SHORT),
    "mtotdev": Job(
        "mtotdev, 50 tau", curve("mtotdev", m=lambda n: log_factors(n // 3, 50)), THOUSANDS, "mtotdev",
        lambda n: mtot_terms(n, log_factors(n // 3, 50)),
    ),
    "dynamic": Job(
        "dynamic oadev, 9901 windows", dynamic, HOURS, "window",
        lambda n: 9901 * differences(n // 100, [k for k in WINDOW if k <= n // 200]),
    ),
    "simulate": Job("simulation of N, B, K", lambda record: record_of(record.size), HOURS),
    "identify": Job("identification", lambda record: al.identify(replace(record)), HOURS),
}  # fmt: skip


class Peer(NamedTuple):
    """What a peer needs for an inner term, ns, from a part of the job."""

    ns: float
    part: str

    def seconds(self, name: str, which: int = -1) -> float:
        """What it needs for the whole of a job at one of its sizes, s."""
        return 1e-9 * self.ns * JOBS[name].terms(JOBS[name].sizes[which])


def part_of(job: Callable[[int], object], terms: Callable[[int], float], words: str) -> Peer:
    """Run a part, the k-th being k times as long, until it takes long enough."""
    k = 1
    while (seconds := least(partial(job, k), 1)) < ENOUGH:
        k = max(k + 1, int(np.ceil(1.3 * k * ENOUGH / max(seconds, 0.05))))
    return Peer(1e9 * seconds / terms(k), words.format(k=k))


def peers() -> dict[str, Peer]:
    long, short, window = record_of(3_600_000), record_of(7_200), record_of(1_500)
    allantools_of("oadev", short, [1, 2])
    evenly = lambda k: np.linspace(1, 1_800_000, k + 1).astype(int)[:-1] + 1  # noqa: E731
    few = lambda k: list(range(100, 100 + 20 * k, 20))  # noqa: E731
    steps = lambda k: list(range(10, 10 + 10 * k, 10))  # noqa: E731
    values = record_of(36_000).values
    return {
        "oadev": part_of(
            lambda k: allantools_of("oadev", long, evenly(k)), lambda k: differences(long.size, evenly(k)),
            "allantools, {k} m evenly from 1 to 1800000 of 3600000 samples",
        ),
        "theo1": part_of(
            lambda k: allantools_of("theo1", short, few(k)), lambda k: theo1_terms(short.size, few(k)),
            "allantools, {k} m from 100 in steps of 20 of 7200 samples",
        ),
        "mtotdev": part_of(
            lambda k: allantools_of("mtotdev", window, steps(k)), lambda k: mtot_terms(window.size, steps(k)),
            "allantools, {k} m from 10 in steps of 10 of 1500 samples",
        ),
        "window": part_of(
            lambda k: [per_window(values) for _ in range(k)], lambda k: k * differences(values.size, WINDOW),
            "numpy, {k} windows of 36000 samples",
        ),
    }  # fmt: skip


def per_window(values: np.ndarray) -> list[float]:
    """Overlapped Allan variance of a window, as it is usually written in numpy."""
    x = np.concatenate(([0.0], np.cumsum(values - values[0])))
    second = ((x[2 * m :] - 2 * x[m:-m] + x[: -2 * m], m) for m in WINDOW)
    return [float(d @ d) / (2.0 * m * m * d.size) for d, m in second]


NOISES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "white": lambda white: white,
    "flicker": lambda white: np.fft.irfft(np.fft.rfft(white) / np.sqrt(np.maximum(np.arange(white.size // 2 + 1), 1))),
    "random walk": np.cumsum,
    "ramp": lambda white: 1.0 * np.arange(white.size),
    "ramp and white": lambda white: 1e-3 * np.arange(white.size) + white,
}


def errors(size: int = 1_000_000) -> list[tuple[str, float, float]]:
    """Largest relative error of every tau and of Theo1 at many m against the definition, by noise."""
    rows, largest = [], size // 2
    m = np.unique(np.concatenate((np.geomspace(1, largest, 60), largest - np.geomspace(1, largest / 20, 30) + 1)))
    m, even = m.astype(np.int64), 2 * np.arange(1, min(size, 72_000) // 2 + 1)
    some = np.unique(np.geomspace(1, even.size, 30).astype(int)) - 1
    for name, made in NOISES.items():
        y = made(np.random.default_rng(1).standard_normal(size))
        x = np.concatenate(([0.0], np.cumsum(y - y[0])))
        part = x[: 2 * even.size + 1]
        every = al.statistics.STATISTICS["oadev"].sums(x, np.arange(1, largest + 1))[m - 1]
        theo = al.statistics.STATISTICS["theo1"].sums(part, even)[some]
        pairs = ((every, overlapped(x, m, 2)), (theo, theo1(part, even[some])))
        rows.append((name, *(float(np.abs(fast / plain - 1).max()) for fast, plain in pairs)))
    return rows


MEMORY = """
import re
import numpy as np
import allanite as al
def status(key):
    return 1024 * int(re.search(key + r":\\s+(\\d+) kB", open("/proc/self/status").read())[1])
al.deviation(al.Record(np.random.default_rng(1).standard_normal(3000), rate=100.0, unit="1"), {name!r}, taus={taus!r})
before = status("VmRSS")
record = al.Record(np.random.default_rng(1).standard_normal({size}), rate=100.0, unit="deg/h")
al.deviation(record, {name!r}, taus={taus!r})
print((status("VmHWM") - before) / record.values.nbytes)
"""


def memory(name: str, taus: str, size: int = 3_600_000) -> float:
    """Largest memory beyond the imports, the record itself included, over the record's.

    In a process of its own, by the kernel's high-water mark: ru_maxrss would begin with that of this one.
    """
    command = [sys.executable, "-c", MEMORY.format(name=name, taus=taus, size=size)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def growth(run: Run) -> bool:
    """The table of how the time grows."""
    records = {size: record_of(size) for job in JOBS.values() for size in job.sizes}
    for job in JOBS.values():
        job.run(records[job.sizes[1]])
    times = {name: [least(lambda: job.run(records[n]), 3) for n in job.sizes] for name, job in JOBS.items()}  # noqa: B023
    peer, wrong = peers(), errors()
    hundred = [
        least(lambda: allantools_of("oadev", records[n], GRIDS["log"](n // 2)), 3)  # noqa: B023
        for n in (1_000_000, 3_600_000)
    ]
    every = least(lambda: JOBS["oadev all"].run(records[1_000_000]), 3)

    def over(what: str, name: str, bound: float, which: int = -1) -> Demand:
        ours, theirs = times[name][which], peer[JOBS[name].peer].seconds(name, which)
        return Demand(what, theirs / ours, bound, ">=", ours, theirs)

    def beside(what: str, seconds: float, theirs: float, bound: float) -> Demand:
        return Demand(what, seconds / theirs, bound, "<=", seconds, theirs)

    demands = [
        beside("oadev, every tau of 1e6, over allantools' 100", every, hundred[0], 6),
        over("oadev, every tau of 3.6e6: allantools over ours", "oadev all", 1000),
        Demand("oadev, every tau: largest relative error", max(row[1] for row in wrong), 1e-9),
        over("theo1, every even m of 7200: allantools over ours", "theo1 all", 1e5, 2),
        Demand("theo1, every even m of 72000: largest relative error", max(row[2] for row in wrong), 1e-9),
        beside(
            "theo1, 100 m of 720000, over allantools' 100 tau oadev of 3.6e6", times["theo1 log"][-1], hundred[1], 8
        ),
        beside("theoh, 100 tau of 720000, over the same", times["theoh log"][-1], hundred[1], 25),
        over("mtotdev, 50 m of 1e5: allantools over ours", "mtotdev", 1e5, 2),
        over("dynamic oadev, 9901 windows x 46 tau of 3.6e6: numpy per window over ours", "dynamic", 100),
        Demand("memory of oadev at every tau of 3.6e6, over the record", memory("oadev", "all"), 10),
        Demand("memory of oadev at 100 tau of 3.6e6, over the record", memory("oadev", "log"), 10),
        Demand("oadev, every tau of 3.6e6 [s]", times["oadev all"][-1], 2),
        Demand("theo1, 100 m of 720000 [s]", times["theo1 log"][-1], 2),
        Demand("mtotdev, 50 m of 1e5 [s]", times["mtotdev"][2], 3),
    ]
    notes = (f"load {os.getloadavg()[0]:.1f} at the end, one thread, processor time, best of 3; seed 1",)
    parts = [(name, f"{one.ns:.3g}", one.part) for name, one in peer.items()]
    run.publish("Growth of the time with the record", notes, [
        *table(demands),
        *section("Peers, extrapolated by their inner terms: a difference, squared and summed",
                 ("job", "ns a term", "from"), parts),
        *section("Relative errors of every tau of 1e6 samples and of Theo1 at every even m of 72000",
                 ("noise", "oadev", "theo1"), [(name, f"{a:.1e}", f"{b:.1e}") for name, a, b in wrong]),
        "## Time by samples [s]", "",
        *(f"- {job.title}: {_by_size(job, times[name])}" for name, job in JOBS.items()),
    ])  # fmt: skip
    return all(demand.met for demand in demands)


def _by_size(job: Job, times: list[float]) -> str:
    return ", ".join(f"{n}: {seconds:.3g}" for n, seconds in zip(job.sizes, times, strict=True))


def main() -> int:
    run = begin(__doc__, what=("ratios", "growth"), samples=3_600_000)
    return 0 if {"ratios": ratios, "growth": growth}[run.asked.what](run) else 1


if __name__ == "__main__":
    sys.exit(main())
