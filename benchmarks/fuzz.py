"""Hostile input of every kind: whatever is handed over is taken, or refused in words, soon and in little memory.

The targets and their cases are those of tests/hostile.py, and of tests/web/hostile.py for the page in the browser. A
case that fails is printed with its kind and number: --only and --first make it again. Each kind runs in a watched
process. A failure is an error of another type than AllaniteError, a warning of a computation, a message of fewer than
20 or more than 1000 letters, a crash, a hang, more processor time or more memory than the target allows, or an answer
that the target says is none. Ends with exit code 1 if there is one.
"""

from table import begin, section

import contextlib
import ctypes
import functools
import multiprocessing
import os
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.util import get_temp_dir
from pathlib import Path
from typing import Any, NamedTuple

from tests.hostile import INPUTS, MEMORY, Take, files, judged, results, worked
from tests.sound_files import SEEDS

WATCH = 120.0
"""Seconds after which a process that stays at one case is stopped."""

WARM, WARMING = 40, -1
"""Cases that run before time and memory are watched, as they import and compile; what stands for their number."""

OPEN = contextlib.ExitStack()  # what a target has opened, which its process closes at the end


def page(name: str) -> Take:
    """Requests to the page, or damage of one of its files."""
    from tests.web import hostile

    opened, runner = hostile.prepared(Path("page"))
    OPEN.callback(opened.jobs.workers.close)
    return hostile.requests(opened, runner) if name == "requests" else hostile.damage(opened, runner, name)


class Target(NamedTuple):
    """One target: its title, its kinds with the usual number of cases, what takes the cases of one, and its limits."""

    title: str
    kinds: dict[str, int]
    takes: Callable[[str], Take]
    seconds: float = 2.0
    megabytes: int = 100


KEPT = ("state.json", "meta.json", "value.json", "shown.json", "0.0.npy")  # ends of names of files of the page

TARGETS = {
    "files": Target("Damaged files", {name: seed.count for name, seed in SEEDS.items()}, files),
    "analysis": Target(
        "Damaged files through a job", {name: max(20, seed.count // 50) for name, seed in SEEDS.items()},
        functools.partial(files, rows=400), 5.0, 200,
    ),
    "records": Target("Any record", {"record": 2000}, lambda _: worked, 5.0, 200),
    "results": Target("Changed results", {"stored result": 60_000}, results, 2.0, 200),
    "inputs": Target(
        "Manifests, recipes, streams and arguments", {name: count for name, (count, _) in INPUTS.items()},
        lambda name: INPUTS[name][1](name), 10.0, 200,
    ),
    "page": Target("Requests and files of the page", {"requests": 5000} | dict.fromkeys(KEPT, 400), page, 5.0, 400),
}  # fmt: skip


def _peak() -> int:
    return sum(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) // 1024


def _serve(target: str, name: str, span: tuple[int, int], place: Any, pipe: Any) -> None:
    """Take the cases of a span; `place` holds the one at work, `pipe` takes what is wrong."""
    warnings.simplefilter("error", RuntimeWarning)  # a division by zero is a defect
    row = TARGETS[target]
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder, contextlib.chdir(folder):
        get_temp_dir()  # of this process, which empties it when all is over
        tempfile.tempdir = folder  # what a case keeps goes with it
        place.value = WARMING
        take = row.takes(name)
        for k in range(WARM):
            judged(take, 10**6 + k)
        base, counts, slowest = _peak(), Counter[str](), 0.0
        for k in range(*span):
            place.value, start = k, sum(os.times()[:4])  # of processes that have ended too
            outcome = judged(take, k)
            took, peak = sum(os.times()[:4]) - start, _peak() - base
            slowest = max(slowest, took)
            over = f"{took:.1f} s" if took > row.seconds else f"{peak} MB" if peak > row.megabytes else ""
            good = outcome in ("taken", "refused") and not over
            counts[outcome if good else "failure"] += 1
            if not good:
                pipe.send((k, over or outcome))
                base = _peak()
        pipe.send((counts, slowest, _peak() - base))
        OPEN.close()
        tempfile.tempdir = None


def run(target: str, name: str, first: int, count: int) -> tuple[tuple[str, ...], list[str]]:
    """The row of a kind, whose cases are taken in processes that are watched, and its failures."""
    context, last = multiprocessing.get_context("spawn"), first + count
    place, counts, slowest, peak = context.Value(ctypes.c_long, first), Counter[str](), 0.0, 0
    failed = []
    while first < last:
        pipe, end = context.Pipe(duplex=False)
        process = context.Process(target=_serve, args=(target, name, (first, last), place, end))
        process.start()
        end.close()
        told, first = _followed(process, pipe, place), last
        failures = [item for item in told if len(item) == 2]
        if len(failures) == len(told):
            failures.append((place.value, f"crash or hang, exit code {process.exitcode}"))
            if place.value == WARMING:
                raise RuntimeError(f"{name} cannot be prepared")
            first, counts = place.value + 1, counts + Counter(failure=len(failures))
        else:
            more, slow, high = told[-1]
            counts, slowest, peak = counts + more, max(slowest, slow), max(peak, high)
        for k, why in failures:
            print(f"{target} {name}, case {k}: {why}", file=sys.stderr, flush=True)
            failed.append(f"{name}, case {k}: {why.strip().splitlines()[-1]}")
    ends = (counts[end] for end in ("taken", "refused", "failure"))
    row = (name, *map(str, (count, *ends, round(1e3 * slowest), peak)))
    print(target, *row, sep=" | ", file=sys.stderr, flush=True)
    return row, failed


def _followed(process: Any, pipe: Any, place: Any) -> list[Any]:
    """What a process sends until it ends; one that stays at one case is stopped."""
    told, at, since = [], place.value, time.monotonic()
    while True:
        if pipe.poll(0.2):
            try:
                told.append(pipe.recv())
            except EOFError:
                break
        if place.value != at:
            at, since = place.value, time.monotonic()
        if place.value != WARMING and time.monotonic() - since > WATCH:
            process.kill()
    process.join()
    return told


def tried(target: str, asked: Any) -> tuple[list[str], list[str]]:
    """The lines of a target's section, and its failures."""
    row = TARGETS[target]
    kinds = {name: max(1, round(asked.share * count)) for name, count in row.kinds.items() if asked.only in ("", name)}
    with ThreadPoolExecutor(2) as pool:
        done = list(pool.map(lambda name: run(target, name, asked.first, kinds[name]), kinds))
    headings = ("kind", "cases", "taken", "refused", "failures", "slowest ms", "memory MB")
    limits = f"Over {row.seconds:g} s of processor time or {row.megabytes} MB is a failure."
    lines = section(row.title, headings, [cells for cells, _ in done], limits)
    return lines, [failure for _, failures in done for failure in failures]


def main() -> int:
    this = begin(__doc__, targets=list(TARGETS), share=1.0, only="", first=0)
    parts = [tried(target, this.asked) for target in this.asked.targets]
    failed = [failure for _, failures in parts for failure in failures]
    notes = (
        f"case k of a kind has the seed (crc32 of its name, k), k from {this.asked.first}; failures: {len(failed)}",
        *(f"failed: {failure}" for failure in failed[:20]),
    )
    this.publish("Hostile input", notes, [line for lines, _ in parts for line in lines])
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
