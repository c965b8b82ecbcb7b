"""How the time of long jobs grows with the record, and how it compares with allantools and with numpy per window.

    python benchmarks/growth.py [--write PATH]

One thread, processor time, the shortest of several rounds, all in one run. What a peer would need hours or days for is
extrapolated from a part of it that takes at least 5 s, by the number of its inner terms. Ends with exit code 1 if a
demand is missed; the figure growth.svg is put beside the table.
"""

from table import begin, markdown

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanite as al
from allanite.kernels.overlapped import overlapped
from allanite.kernels.theo import theo1
from allanite.statistics.grids import GRIDS
from incache import share, shortest

RATE = 100.0
MODEL = al.N(0.01, "deg/sqrt(h)") + al.B(0.1, "deg/h") + al.K(0.1, "deg/h/sqrt(h)")
ENOUGH = 5.0
"""Seconds that a part of a peer's job takes at least before it is extrapolated."""


class Job(NamedTuple):
    """A job of ours by the record's length, and the inner terms that the peer sums for it."""

    title: str
    run: Callable[[al.Record], object]
    sizes: Sequence[int]
    peer: str
    terms: Callable[[int], float]


class Peer(NamedTuple):
    """What a peer needs for an inner term, from a part of the job."""

    ns: float
    seconds: float
    part: str


def record_of(size: int) -> al.Record:
    return al.simulate(MODEL, size, RATE, rng=np.random.default_rng(1))


def log_factors(largest: int, points: int) -> list[int]:
    return np.unique(np.rint(np.geomspace(1, largest, points)).astype(int)).tolist()


def oadev_terms(n: int, m: Sequence[int]) -> float:
    return float(np.sum(n + 1 - 2 * np.asarray(m, dtype=np.float64)))


def theo1_terms(n: int, m: Sequence[int]) -> float:
    m = np.asarray(m, dtype=np.float64)
    return float(np.sum(m / 2 * (n + 1 - m)))


def mtot_terms(n: int, m: Sequence[int]) -> float:
    m = np.asarray(m, dtype=np.float64)
    return float(np.sum(6 * m * (n + 2 - 3 * m)))


def window_factors() -> list[int]:
    return log_factors(36_000 // 2, 52)


def curve(statistic: str, m: Callable[[int], Sequence[int]] | None = None, taus: str = "all") -> Callable[..., object]:
    if m is None:
        return lambda record: al.deviation(record, statistic, taus=taus, noise=None)
    return lambda record: al.deviation(record, statistic, m=m(record.size), noise=None)


def dynamic(record: al.Record) -> object:
    samples = record.size // 100
    m = [k for k in window_factors() if k <= samples // 2]
    return al.dynamic(record, window=samples / RATE, step=samples / 100 / RATE, m=m)


THREE = (3_600, 36_000, 360_000, 3_600_000)
JOBS = {
    "oadev log": Job(
        "oadev, 100 tau", curve("oadev", taus="log"), THREE, "oadev",
        lambda n: oadev_terms(n, GRIDS["log"](n // 2)),
    ),
    "oadev all": Job(
        "oadev, every tau", curve("oadev"), THREE, "oadev", lambda n: oadev_terms(n, np.arange(1, n // 2 + 1))
    ),
    "ohdev all": Job("ohdev, every tau", curve("ohdev"), THREE, "", lambda n: 0.0),
    "mdev all": Job("mdev, every tau", curve("mdev"), THREE, "", lambda n: 0.0),
    "theo1 log": Job(
        "theo1, 100 tau", curve("theo1", taus="log"), (720, 7_200, 72_000, 720_000), "theo1",
        lambda n: theo1_terms(n, 2 * GRIDS["log"](n // 2)),
    ),
    "theo1 all": Job(
        "theo1, every even m", curve("theo1"), (72, 720, 7_200, 72_000), "theo1",
        lambda n: theo1_terms(n, np.arange(2, n + 1, 2)),
    ),
    "theoh log": Job("theoh, 100 tau", curve("theoh", taus="log"), (720, 7_200, 72_000, 720_000), "", lambda n: 0.0),
    "mtotdev": Job(
        "mtotdev, 50 tau", curve("mtotdev", lambda n: log_factors(n // 3, 50)), (1_000, 10_000, 100_000, 1_000_000),
        "mtotdev", lambda n: mtot_terms(n, log_factors(n // 3, 50)),
    ),
    "dynamic": Job(
        "dynamic oadev, 9901 windows", dynamic, THREE, "window",
        lambda n: 9901 * oadev_terms(n // 100, [k for k in window_factors() if k <= n // 200]),
    ),
    "simulate": Job("simulation of N, B, K", lambda record: record_of(record.size), THREE, "", lambda n: 0.0),
    "identify": Job("identification", al.identify, THREE, "", lambda n: 0.0),
}  # fmt: skip


def part_of(job: Callable[[int], object], terms: Callable[[int], float], words: str) -> Peer:
    """Run a part, the k-th being k times as long, until it takes long enough."""
    k = 1
    while True:
        start = time.process_time()
        job(k)
        seconds = time.process_time() - start
        if seconds >= ENOUGH:
            return Peer(1e9 * seconds / terms(k), seconds, words.format(k=k))
        k = max(k + 1, int(np.ceil(1.3 * k * ENOUGH / max(seconds, 0.05))))


def peers() -> dict[str, Peer]:
    import allantools

    def asked(statistic: str, record: al.Record, m: Sequence[int]) -> object:
        taus = np.asarray(m) / RATE
        return getattr(allantools, statistic)(record.values, rate=RATE, data_type="freq", taus=taus)

    long, short, window = record_of(3_600_000), record_of(7_200), record_of(1_500)
    asked("oadev", short, [1, 2])
    evenly = lambda k: np.linspace(1, 1_800_000, k + 1).astype(int)[:-1] + 1  # noqa: E731
    few = lambda k: list(range(100, 100 + 20 * k, 20))  # noqa: E731
    steps = lambda k: list(range(10, 10 + 10 * k, 10))  # noqa: E731
    record = record_of(36_000)
    return {
        "oadev": part_of(
            lambda k: asked("oadev", long, evenly(k)), lambda k: oadev_terms(long.size, evenly(k)),
            "allantools, {k} m evenly from 1 to 1800000 of 3600000 samples",
        ),
        "theo1": part_of(
            lambda k: asked("theo1", short, few(k)), lambda k: theo1_terms(short.size, few(k)),
            "allantools, {k} m from 100 in steps of 20 of 7200 samples",
        ),
        "mtotdev": part_of(
            lambda k: asked("mtotdev", window, steps(k)), lambda k: mtot_terms(window.size, steps(k)),
            "allantools, {k} m from 10 in steps of 10 of 1500 samples",
        ),
        "window": part_of(
            lambda k: [per_window(record.values) for _ in range(k)],
            lambda k: k * oadev_terms(record.size, window_factors()), "numpy, {k} windows of 36000 samples",
        ),
    }  # fmt: skip


def per_window(values: np.ndarray) -> list[float]:
    """Overlapped Allan variance of a window, as one writes it in numpy."""
    x = np.concatenate(([0.0], np.cumsum(values - values[0])))
    found = []
    for m in window_factors():
        difference = x[2 * m :] - 2 * x[m:-m] + x[: -2 * m]
        found.append(float(difference @ difference) / (2.0 * m * m * difference.size))
    return found


NOISES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "white": lambda white: white,
    "flicker": lambda white: np.fft.irfft(np.fft.rfft(white) / np.sqrt(np.maximum(np.arange(white.size // 2 + 1), 1))),
    "random walk": np.cumsum,
    "ramp": lambda white: 1.0 * np.arange(white.size),
    "ramp and white": lambda white: 1e-3 * np.arange(white.size) + white,
}


def errors(size: int = 1_000_000) -> list[tuple[str, float, float]]:
    """Largest relative error of every tau and of Theo1 at many m against the definition, by noise."""
    rows = []
    for name, made in NOISES.items():
        y = made(np.random.default_rng(1).standard_normal(size))
        x = np.concatenate(([0.0], np.cumsum(y - y[0])))
        row, largest = al.STATISTICS["oadev"], size // 2
        m = np.unique(np.concatenate((np.geomspace(1, largest, 60), largest - np.geomspace(1, largest / 20, 30) + 1)))
        m = m.astype(np.int64)
        every = row.sums(x, np.arange(1, largest + 1))[m - 1]
        part = x[: min(size, 72_000) + 1]
        k = 2 * np.arange(1, part.size // 2 + 1)
        some = np.unique(np.geomspace(1, k.size, 30).astype(int)) - 1
        theo = al.STATISTICS["theo1"].sums(part, k)[some]
        rows.append(
            (
                name,
                float(np.abs(every / overlapped(x, m, 2) - 1).max()),
                float(np.abs(theo / theo1(part, k[some]) - 1).max()),
            )
        )
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


def draw(times: dict[str, list[float]], found: dict[str, Peer], path: Path) -> None:
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with rc_context({"svg.hashsalt": "allanite", "font.size": 8}):
        figure = Figure(figsize=(9, 9), layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.subplots(4, 3).ravel()
        for ax in axes[len(JOBS) :]:
            ax.set_axis_off()
        for ax, (name, job) in zip(axes, JOBS.items(), strict=False):
            ax.loglog(job.sizes, times[name], "o-", color="#2A5D9A", label="allanite")
            if job.peer:
                peer = [1e-9 * found[job.peer].ns * job.terms(n) for n in job.sizes]
                label = found[job.peer].part.split(",")[0]
                ax.loglog(job.sizes, peer, "s--", color="#C0392B", ms=3, label=f"{label}, by its terms")
            ax.loglog(job.sizes, [times[name][-1] * n / job.sizes[-1] for n in job.sizes], ":", color="#9AA3AD")
            ax.set_title(job.title, loc="left", fontsize=9)
            ax.grid(which="major", color="#D8DCE0", lw=0.6)
        for which in ("oadev log", "dynamic"):
            axes[list(JOBS).index(which)].legend(fontsize=7)
        figure.supxlabel("samples (dotted: in proportion to them)")
        figure.supylabel("processor time (s)")
        figure.savefig(path, metadata={"Date": None})


def main() -> int:
    run = begin(__doc__)
    load = os.getloadavg()[0]
    records = {size: record_of(size) for job in JOBS.values() for size in job.sizes}
    for job in JOBS.values():
        job.run(records[job.sizes[1]])
    times = {name: [shortest(lambda: job.run(records[n]), 3) for n in job.sizes] for name, job in JOBS.items()}  # noqa: B023
    found = peers()
    import allantools

    def hundred(size: int) -> float:
        taus = GRIDS["log"](size // 2) / RATE
        return shortest(lambda: allantools.oadev(records[size].values, rate=RATE, data_type="freq", taus=taus), 3)

    records[1_000_000] = record_of(1_000_000)
    every = shortest(lambda: JOBS["oadev all"].run(records[1_000_000]), 3)
    at_million, at_most = hundred(1_000_000), hundred(3_600_000)
    job = JOBS
    peer = {name: 1e-9 * found[j.peer].ns * j.terms(j.sizes[-1]) for name, j in job.items() if j.peer}
    theo_7200 = 1e-9 * found["theo1"].ns * job["theo1 all"].terms(7_200)
    mtot_1e5 = 1e-9 * found["mtotdev"].ns * job["mtotdev"].terms(100_000)
    wrong = errors()
    allan, theo = (max(row[i] for row in wrong) for i in (1, 2))
    part, u, allan_log = share(records[3_600_000], "oadev")
    # what, ours s, peer s, value, demand, sense
    rows = [
        ("oadev, every tau of 1e6, over allantools' 100", every, at_million, every / at_million, 6, "<="),
        ("oadev, every tau of 3.6e6: allantools over ours", times["oadev all"][-1], peer["oadev all"],
         peer["oadev all"] / times["oadev all"][-1], 1000, ">="),
        ("oadev, every tau: largest relative error", 0, 0, allan, 1e-9, "<="),
        ("theo1, every even m of 7200: allantools over ours", times["theo1 all"][2], theo_7200,
         theo_7200 / times["theo1 all"][2], 1e5, ">="),
        ("theo1, every even m of 72000: largest relative error", 0, 0, theo, 1e-9, "<="),
        ("theo1, 100 m of 720000, over allantools' 100 tau oadev of 3.6e6", times["theo1 log"][-1], at_most,
         times["theo1 log"][-1] / at_most, 8, "<="),
        ("theoh, 100 tau of 720000, over the same", times["theoh log"][-1], at_most,
         times["theoh log"][-1] / at_most, 25, "<="),
        ("mtotdev, 50 m of 1e5: allantools over ours", times["mtotdev"][2], mtot_1e5,
         mtot_1e5 / times["mtotdev"][2], 1e5, ">="),
        ("dynamic oadev, 9901 windows x 46 tau of 3.6e6: numpy per window over ours", times["dynamic"][-1],
         peer["dynamic"], peer["dynamic"] / times["dynamic"][-1], 100, ">="),
        ("memory of oadev at every tau of 3.6e6, over the record", 0, 0, memory("oadev", "all"), 10, "<="),
        ("memory of oadev at 100 tau of 3.6e6, over the record", 0, 0, memory("oadev", "log"), 10, "<="),
        ("oadev, every tau of 3.6e6 [s]", 0, 0, times["oadev all"][-1], 2, "<="),
        ("theo1, 100 m of 720000 [s]", 0, 0, times["theo1 log"][-1], 2, "<="),
        ("mtotdev, 50 m of 1e5 [s]", 0, 0, times["mtotdev"][2], 3, "<="),
        ("oadev, 100 tau of 3.6e6 with integration: share of the in-cache bound", allan_log, 0, part, 0.8, ">="),
    ]  # fmt: skip
    lines, good = table(rows)
    notes = [
        f"load {load:.1f} at the start and {os.getloadavg()[0]:.1f} at the end, one thread, processor time, best of 3; "
        "seed 1",
        f"in-cache second difference {1e9 * u:.3f} ns",
    ]
    run.publish("Growth of the time with the record", notes, [*lines, *sections(times, found, wrong)])
    if run.asked.write:
        draw(times, found, run.asked.write.with_suffix(".svg"))
    return 0 if good else 1


Row = tuple[str, float, float, float, float, str]


def table(rows: list[Row]) -> tuple[list[str], bool]:
    """Lines of the table, and whether every demand is met."""
    cells, good = [], True
    for what, ours, theirs, value, bound, sense in rows:
        met = value <= bound if sense == "<=" else value >= bound
        good &= met
        times = (f"{seconds:.3g}" if seconds else "" for seconds in (ours, theirs))
        cells.append((what, *times, f"{value:.3g}", f"{sense} {bound:g}", "met" if met else "MISSED"))
    return markdown(("what", "ours [s]", "peer [s]", "measured", "wanted", ""), cells), good


def sections(times: dict[str, list[float]], found: dict[str, Peer], wrong: list[tuple[str, float, float]]) -> list[str]:
    lines = ["## Peers, extrapolated", "", "by their inner terms: a difference, squared and summed", ""]
    lines += [f"- {name}: {one.ns:.3g} ns a term, from {one.part} ({one.seconds:.1f} s)" for name, one in found.items()]
    lines += ["", "## Relative errors", ""]
    lines += ["Every tau of 1e6 samples and Theo1 at every even m of 72000, the largest of 90 and of 30 of them.", ""]
    lines += [f"- {name}: oadev {allan:.1e}, theo1 {theo:.1e}" for name, allan, theo in wrong]
    lines += ["", "## Time by samples [s]", "", "![growth](growth.svg)", ""]
    for name, job in JOBS.items():
        cells = ", ".join(f"{n}: {seconds:.3g}" for n, seconds in zip(job.sizes, times[name], strict=True))
        lines.append(f"- {job.title}: {cells}")
    return [*lines, "", "## What was reached, and what holds it back", "", REACHED, ""]


REACHED = """\
- Every tau: six passes of real transforms over the record (blocks of 65536 with their zeros: beyond the cache a
  transform takes five times as long a point), 64 tau directly, and the edges' triangles, O(N log^2 N), which are 40 %
  of the time at 3.6e6. Where less than 1e-5 of the squares is left (a strong vibration at whole periods, the last few
  windows) the definition is summed: nine digits hold for any record.
- Theo1 at 100 m: its mirrored pairs, again triangles, are three quarters. At every even m the recursion takes 0.2 ns
  m^2, with arrays that the second-level cache does not hold: 100 s for every m of 720000, of which a warning tells;
  the bias ratio needs it up to 2/15 of the record.
- mtotdev and htotdev take O(N) a tau by running sums and are exact: a form that strides over windows would gain no time
  and lose digits, so that there is none. What is left is twenty passes over a frame.
- oadev at 100 tau: four differences of a row share their points, so that up to m of 32768 a difference takes what the
  bound says, from the second-level cache. Above, rows are too far apart for it: 30 of the 100 tau take twice the bound,
  the time of reading every sample again from the third-level cache, and a third of the whole.
- dynamic Allan: every difference once, two additions a window and tau; bound as oadev is."""


if __name__ == "__main__":
    sys.exit(main())
