"""How fast: beside the machine's own limit, peers and numpy; by the record's length; from a file; the first run.

One thread and processor time, the least of several rounds of one run, unless said otherwise; only ratios are to be
trusted. The time of a peer is that of a part of its job, by the number of their inner terms. Ends with exit code 1 if a
demand is missed.

u is the time of one difference of order 2 or 3, squared and summed, over 1000 neighbouring samples of an array that the
first-level cache holds. The in-cache bound of a job is u times its differences; its share is the bound over the job's
whole time, with integration.

Jobs and the first run are commands, each a new process with nothing set; their times are of the wall.
"""

from table import ROOT, Row, begin, least, section

import os
import resource
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median

import allantools
import numpy as np
import pyarrow as pa
from numba import njit
from pyarrow import csv

import allanite as al
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search.identify import searched
from allanite.statistics.grids import GRIDS

RATE = 100.0
MODEL = al.N(0.01, "deg/sqrt(h)") + al.B(0.1, "deg/h") + al.K(0.1, "deg/h/sqrt(h)")
INCORE = 1000
ORDERS = {"oadev": 2, "mdev": 3, "ohdev": 3}
"""Order of the differences; mdev takes those of the angle's running sum."""


@njit(fastmath={"reassoc", "nsz", "contract"})
def in_cache(x, m, order, rounds):
    total = 0.0
    for turn in range(rounds):
        a, b = x[turn % 8 : INCORE + turn % 8], x[turn % 8 + m : INCORE + turn % 8 + m]
        c = x[turn % 8 + 2 * m : INCORE + turn % 8 + 2 * m]
        d = x[turn % 8 + 3 * m : INCORE + turn % 8 + 3 * m]
        part = 0.0
        if order == 2:
            for i in range(INCORE):
                e = (c[i] - b[i]) - (b[i] - a[i])
                part += e * e
        else:
            for i in range(INCORE):
                e = (d[i] - a[i]) - 3.0 * (c[i] - b[i])
                part += e * e
        total += part
    return total


def unit(order: int, rounds: int = 20_000) -> float:
    """U of differences of this order, s."""
    x = np.random.default_rng(1).standard_normal(5 * INCORE)
    in_cache(x, INCORE, order, 10)
    return least(lambda: in_cache(x, INCORE, order, rounds), 3) / (rounds * INCORE)


def terms(statistic: str, n: int, m: Iterable[int]) -> float:
    """Differences that are squared and summed at all averaging factors of a record."""
    m = np.asarray(m, dtype=np.float64)
    if statistic in ORDERS:
        return float(np.sum(n + 1 - ORDERS[statistic] * m))
    return float(np.sum(m / 2 * (n + 1 - m) if statistic == "theo1" else 6 * m * (n + 2 - 3 * m)))


WANTED = ("what", "ours [s]", "peer [s]", "measured", "wanted", "")


def wanted(what: str, value: float, bound: float, sense: str = "<=", times: Iterable[float] = ()) -> Row:
    """The row of what was measured, and of what was wanted of it."""
    met = value <= bound if sense == "<=" else value >= bound
    shown = [f"{seconds:.3g}" for seconds in times] or ["", ""]
    return what, *shown, f"{value:.3g}", f"{sense} {bound:g}", "met" if met else "MISSED"


def below(what: str, ours: float, peer: float, bound: float) -> Row:
    """The row of a time that may be a multiple of a peer's."""
    return wanted(what, ours / peer, bound, "<=", (ours, peer))


def above(what: str, ours: float, peer: float, bound: float) -> Row:
    """The row of a time of which that of a peer has to be a multiple."""
    return wanted(what, peer / ours, bound, ">=", (ours, peer))


def by_turns(rounds: int, *jobs: Callable[[], object]) -> list[float]:
    """Least time of each of several jobs, s."""
    return np.min([[least(job, 1) for job in jobs] for _ in range(rounds)], axis=0).tolist()


def record_of(size: int) -> al.Record:
    return al.simulate(MODEL, size, RATE, rng=np.random.default_rng(1))


def by_allantools(statistic: str, record: al.Record, m: Sequence[int]) -> object:
    """The statistic of the peer at averaging factors."""
    taus = np.asarray(m) / record.rate
    return getattr(allantools, statistic)(record.values, rate=record.rate, data_type="freq", taus=taus)


def bounded(record: al.Record, statistic: str) -> tuple[float, float, float]:
    """The job's time at the tau of the log grid, its in-cache bound and u, s; measured by turns.

    Here and below `replace` makes a record of which no curve is known.
    """
    order, m = ORDERS[statistic], al.deviation(record, statistic, taus="log").m.tolist()
    times = [(least(lambda: al.deviation(replace(record), statistic, m=m), 2), unit(order)) for _ in range(7)]
    job, u = np.min(times, axis=0).tolist()
    return job, u * terms(statistic, record.size, m), u


def spent(*words: object, **more: str) -> tuple[float, float]:
    """Time of a command with nothing set but a few variables, and that of the processors in it, s."""
    unset = {"PYTHONDONTWRITEBYTECODE", *(name for name in os.environ if name.endswith("_NUM_THREADS"))}
    kept = {name: value for name, value in os.environ.items() if name not in unset}
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(word) for word in words], env=kept | more, capture_output=True, check=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def allocated(job: Callable[[], object]) -> int:
    """Largest memory allocated at a time, bytes."""
    tracemalloc.start()
    job()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def ratios(samples: int) -> list[str]:
    """What one record takes."""
    record = record_of(samples)
    m = al.deviation(record, "oadev", taus="log").m.tolist()
    al.analyze(record)
    bounds = {name: bounded(record, name) for name in ORDERS}
    jobs = (
        lambda: al.deviation(replace(record), "oadev", m=m),
        lambda: searched(spectrum(replace(record), detrend=True), "QNBKR", "auto", rival=True),
        lambda: al.identify(replace(record)), lambda: al.analyze(replace(record)),
    )  # fmt: skip
    allan, selected, identified, analysis = by_turns(8, *jobs)
    peer = least(lambda: by_allantools("oadev", record, m), 3)
    single = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    commands = [(sys.executable, "-c", f"import {name}") for name in ("numpy", "allanite")]
    commands.append((Path(sys.executable).with_name("allanite"), "--help"))
    begins = [[spent(*each, **single)[1] for each in commands] for _ in range(11)]
    numpy_alone, importing, helping = np.min(begins, axis=0).tolist()
    memory = allocated(lambda: al.analyze(replace(record))) / record.values.nbytes
    bound = "{} at {} tau, with integration: share of the in-cache bound"
    return section("Ratios", WANTED, [
        *(above(bound.format(name, len(m)), *bounds[name][:2], 0.8) for name in ORDERS),
        above("allantools' oadev over ours, same 100 tau", allan, peer, 8),
        below("identification: transform, every subset of terms, selection, over oadev", selected, allan, 1),
        below("the same with outliers, search for sinusoids, limits, over oadev", identified, allan, 3),
        below("whole analysis of one channel over oadev", analysis, allan, 6),
        below("`import allanite` over `import numpy`", importing, numpy_alone, 1.3),
        below("`allanite --help` over `import numpy`", helping, numpy_alone, 2.2),
        wanted("memory of the analysis over the record", memory, 6),
    ], "; ".join(f"{name}: u = {1e9 * u:.3f} ns; the job {1e3 * job:.0f} ms" for name, (job, _, u) in bounds.items()),
        f"identification {1e3 * selected:.0f} ms, overlapped Allan beside it {1e3 * allan:.0f} ms; analysis "
        f"{1e3 * analysis:.0f} ms; import numpy {1e3 * numpy_alone:.0f} ms",
    )  # fmt: skip


def log_factors(largest: int, points: int) -> list[int]:
    return np.unique(np.rint(np.geomspace(1, largest, points)).astype(int)).tolist()


WINDOW = log_factors(36_000 // 2, 52)  # averaging factors of a window of 36000 samples


def curve(statistic: str, taus: str = "all", m: Callable[[int], Sequence[int]] | None = None) -> Callable[..., object]:
    how = (lambda n: {"m": m(n)}) if m else (lambda _: {"taus": taus})
    return lambda record: al.deviation(replace(record), statistic, noise=None, **how(record.size))


def dynamic(record: al.Record) -> object:
    samples = record.size // 100
    m = [k for k in WINDOW if k <= samples // 2]
    return al.dynamic(record, window=samples / RATE, step=samples / 100 / RATE, m=m)


LONG, MIDDLE, SHORT = 3_600_000, 720_000, 72_000
JOBS: dict[str, tuple[Callable[..., object], int]] = {
    "oadev, 100 tau": (curve("oadev", "log"), LONG),
    "oadev, every tau": (curve("oadev"), LONG),
    "ohdev, every tau": (curve("ohdev"), LONG),
    "mdev, every tau": (curve("mdev"), LONG),
    "theo1, 100 tau": (curve("theo1", "log"), MIDDLE),
    "theo1, every even m": (curve("theo1"), SHORT),
    "theoh, 100 tau": (curve("theoh", "log"), MIDDLE),
    "mtotdev, 50 tau": (curve("mtotdev", m=lambda n: log_factors(n // 3, 50)), 1_000_000),
    "dynamic oadev, 9901 windows": (dynamic, LONG),
    "simulation of N, B, K": (lambda record: record_of(record.size), LONG),
    "identification": (lambda record: al.identify(replace(record)), LONG),
}
"""Jobs, and the largest of the four lengths of a record, of which each is ten times the one before."""


def per_window(values: np.ndarray) -> list[float]:
    """Overlapped Allan variance of a window, as it is usually written in numpy."""
    x = np.concatenate(([0.0], np.cumsum(values - values[0])))
    second = ((x[2 * m :] - 2 * x[m:-m] + x[: -2 * m], m) for m in WINDOW)
    return [float(d @ d) / (2.0 * m * m * d.size) for d, m in second]


def peers() -> dict[str, float]:
    """The time of each job of a peer by that of a part of it, s."""
    jobs = {
        "oadev": (LONG, np.linspace(1, LONG // 2, 400).astype(int), LONG, range(1, LONG // 2 + 1)),
        "theo1": (7_200, range(100, 300, 20), 7_200, range(2, 7_201, 2)),
        "mtotdev": (1_500, range(10, 160, 10), 100_000, log_factors(100_000 // 3, 50)),
    }
    times = {"dynamic": 9901 * least(partial(per_window, record_of(36_000).values), 100)}
    for name, (n, part, size, m) in jobs.items():
        seconds = least(partial(by_allantools, name, record_of(n), part), 1)
        times[name] = seconds * terms(name, size, m) / terms(name, n, part)
    return times


def demanded(times: dict[str, list[float]], peer: dict[str, float]) -> list[Row]:
    """What is wanted of the times of jobs."""
    long, million = record_of(LONG), record_of(1_000_000)
    every = least(partial(JOBS["oadev, every tau"][0], million), 3)
    few, hundred = (
        least(partial(by_allantools, "oadev", each, GRIDS["log"](each.size // 2)), 3) for each in (million, long)
    )

    def spare(name: str) -> float:
        return allocated(partial(JOBS[name][0], long)) / long.values.nbytes

    whole, theo, total = times["oadev, every tau"][-1], times["theo1, 100 tau"][-1], times["mtotdev, 50 tau"][2]
    windows = "dynamic oadev, 9901 windows"
    return [
        below("oadev, every tau of 1e6, over allantools' 100", every, few, 6),
        above("oadev, every tau of 3.6e6: allantools over ours", whole, peer["oadev"], 1000),
        above("theo1, every even m of 7200: allantools over ours", times["theo1, every even m"][2], peer["theo1"], 1e5),
        below("theo1, 100 m of 720000, over allantools' 100 tau oadev of 3.6e6", theo, hundred, 8),
        below("theoh, 100 tau of 720000, over the same", times["theoh, 100 tau"][-1], hundred, 25),
        above("mtotdev, 50 m of 1e5: allantools over ours", total, peer["mtotdev"], 1e5),
        above(f"{windows} x 46 tau of 3.6e6: numpy per window over ours", times[windows][-1], peer["dynamic"], 100),
        *(wanted(f"memory of {name} of 3.6e6, over the record", spare(name), 10)
          for name in ("oadev, every tau", "oadev, 100 tau")),
        wanted("oadev, every tau of 3.6e6 [s]", whole, 2),
        wanted("theo1, 100 m of 720000 [s]", theo, 2),
        wanted("mtotdev, 50 m of 1e5 [s]", total, 3),
    ]  # fmt: skip


def growth(_: int) -> list[str]:
    """How the time grows with the record."""
    sizes = {name: [largest // 10**k for k in (3, 2, 1, 0)] for name, (_, largest) in JOBS.items()}
    records = {n: record_of(n) for each in sizes.values() for n in each}
    for name, (job, _) in JOBS.items():
        job(records[sizes[name][1]])
    times = {name: [least(partial(job, records[n]), 3) for n in sizes[name]] for name, (job, _) in JOBS.items()}
    rows = [(name, str(sizes[name][-1]), *(f"{seconds:.3g}" for seconds in times[name])) for name in JOBS]
    return [
        *section("Growth with the record", WANTED, demanded(times, peers())),
        *section("Time by samples, s", ("job", "n", "n/1000", "n/100", "n/10", "all"), rows),
    ]  # fmt: skip


# --- commands --------------------------------------------------------------------------------------------------------

SENSORS = {
    "gyro": ("deg/s", "N 0.5 deg/sqrt(h), B 5 deg/h, K 20 deg/h/sqrt(h)"),
    "accel": ("m/s^2", "N 100 ug/sqrt(Hz), B 20 ug"),
}


def six(path: Path, samples: int) -> None:
    """Write stamps, three gyroscopes and three accelerometers."""
    columns = {"time [s]": np.arange(samples) / RATE}
    for name, (unit, model) in SENSORS.items():
        for i, axis in enumerate("xyz"):
            rng = np.random.default_rng([1, i + 3 * (name == "accel")])
            values = al.simulate(al.Model(model), samples, RATE, rng=rng).values
            columns[f"{name}_{axis} [{unit}]"] = np.round(np.degrees(values) if name == "gyro" else values, 9)
    csv.write_csv(pa.table(columns), path, csv.WriteOptions(quoting_style="none"))


def jobs(samples: int) -> list[str]:
    """From a file to a page."""
    pa.set_cpu_count(1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "six.csv")
        six(path, min(samples, 1_000_000))
        ours, theirs = by_turns(4, partial(al.read, path), partial(csv.read_csv, path))
        read = least(partial(csv.read_csv, path), 4, time.perf_counter)
        words = (sys.executable, "-m", "allanite.cli", "analyze", path, "--force")
        targets = (("--report", path.with_suffix(".html")), ("--json", path.with_suffix(".json")))
        page, plain = (min(spent(*words, *target)[0] for _ in range(3)) for target in targets)
    return section("From a file to a page", WANTED, [
        below("reading, of the processor, over pyarrow's own", ours, theirs, 2),
        below("analyze --report, over the read by pyarrow", page, read, 10),
        below("analyze --json, over the read by pyarrow", plain, read, 6),
    ], f"{min(samples, 1_000_000)} samples of six channels with stamps; pyarrow has one thread.")  # fmt: skip


def first(_: int, rounds: int = 5) -> list[str]:
    """The first run of the README, and the second."""
    words, runs = (sys.executable, "-m", "allanite.cli", "analyze", ROOT / "examples" / "tactical_gyro.csv"), []
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as cache:
            runs.append([spent(*words, NUMBA_CACHE_DIR=cache) for _ in range(2)])
    rows = []
    for name, number in (("first", 0), ("second", 1)):
        walls, used = zip(*(run[number] for run in runs), strict=True)
        rows.append((name, *(f"{seconds:.1f}" for seconds in (min(walls), median(walls), median(used)))))
    shortest = min(run[0][0] for run in runs)
    return [
        *section("First run", ("run", "shortest", "median", "median, of the processors"), rows,
                 f"The sample, {rounds} times with an empty cache of kernels and with the one that this run left, s."),
        *section("Demand of the first run", WANTED, [wanted("shortest, on two idle processors [s]", shortest, 8)]),
    ]  # fmt: skip


PARTS: dict[str, Callable[[int], list[str]]] = {"ratios": ratios, "growth": growth, "jobs": jobs, "first": first}


def main() -> int:
    run = begin(__doc__, parts=list(PARTS), samples=3_600_000)
    body = [line for part in run.asked.parts for line in PARTS[part](run.asked.samples)]
    missed = sum("MISSED" in line for line in body)
    run.publish("Speed", ("seed 1", f"load {os.getloadavg()[0]:.1f}", f"demands that are missed: {missed}"), body)
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
