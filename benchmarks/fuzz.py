"""Hostile input of every kind: whatever is handed over is taken, or refused in words, soon and in little memory.

    python benchmarks/fuzz.py TARGET [--share 1] [--only KIND,KIND] [--first 0] [--jobs 2] [--write PATH]

Case k of a kind is always the same: its generator is seeded by the name of the kind and k, and one that fails is
printed with both. Each kind runs in a watched process. A failure is an error of another type than AllaniteError,
a warning of a computation, a message of fewer than 20 or more than 1000 letters, a crash, a hang, more processor time
or more memory than the target allows, or an answer that the target says is none. Ends with exit code 1 if there is one.

files     damaged files of every format (benchmarks/damaged.py)
analysis  longer ones, and what can still be read goes through one of the jobs
records   any values, rate, gaps and length through each job
results   changed plain data of stored results; what is read of a noise is exported
inputs    changed manifests, recipes and streams; calls with arguments of any kind, half of them of the right type
page      requests to the page in the browser, and damaged files of its folder (benchmarks/hostile.py)
"""

from table import begin, markdown

import contextlib
import copy
import ctypes
import functools
import io
import json
import multiprocessing
import os
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.util import get_temp_dir
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import allanite as al
from allanite.kernels.passing import followed
from allanite.reporting import to_csv
from damaged import SEEDS, generator, lengthen, mutated, options_of, read

WATCH = 120.0
"""Seconds after which a process that stays at one case is stopped."""

WARM, WARMING = 40, -1
"""Cases that run before time and memory are watched, as they import and compile; what stands for their number."""

MEMORY = next((folder for folder in ("/dev/shm",) if os.path.isdir(folder)), None)  # noqa: S108  a disk is slow
OPEN = contextlib.ExitStack()  # what a target has opened, which its process closes at the end

Take = Callable[[int], object]


def judged(take: Callable[..., object], *given: Any) -> str:
    """What became of what is handed over: taken, refused, or why that is a failure."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            take(*given)
    except al.AllaniteError as error:
        return "refused" if 20 < len(str(error)) < 1000 else f"words\n{error}"
    except Exception:
        return "traceback\n" + traceback.format_exc(limit=-4)
    return "taken"


# --- files and records -----------------------------------------------------------------------------------------------


def analyzed(records: Any) -> None:
    """The numbers of an analysis, stored and written."""
    study = al.analyze(records)
    json.dumps(study.to_dict(), allow_nan=False)
    str(study), to_csv(study)


def reported(records: Any) -> None:
    """The page of an analysis."""
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        al.report(al.analyze(records), Path(folder, "a.html"))


JOBS: dict[str, Callable[[al.Record, np.random.Generator], object]] = {
    "analyze": lambda record, _: analyzed(record),
    "deviation": lambda record, rng: str(al.deviation(record, str(rng.choice(list(al.statistics.STATISTICS))))),
    "spectrum": lambda record, _: str(al.spectrum(record)),
    "dynamic": lambda record, _: str(al.dynamic(record)),
    "identify": lambda record, _: str(al.identify(record)),
    "compare": lambda record, _: str(al.compare(record, record)),
    "a page": lambda record, _: reported(record),
    "plan": lambda record, _: str(al.plan(al.identify(record), record.rate)),
}


def files(name: str, rows: int = 0) -> Take:
    """Damaged files of a seed; of more rows, what is read goes through a job."""
    if rows:
        lengthen(rows)
    data, options, path = SEEDS[name].make(), SEEDS[name].options, Path(name)
    path.write_bytes(data)
    read(path, options)
    followed(np.arange(4.0), np.arange(4), 16, 0.5)  # compiled, for time stamps that are damaged

    def take(k: int) -> None:
        rng = generator(name, k)
        path.write_bytes(mutated(rng, data))
        recording = read(path, options_of(rng, options))
        if rows:
            job = str(rng.choice(list(JOBS)))
            for record in recording:
                JOBS[job](record, rng)

    return take


KINDS = {"rad": "angle", "arcsec": "angle", "m/s": "angle"}
UNITS = ("rad/s", "deg/h", "deg/s", "m/s^2", "g", "mg", "rad", "arcsec", "m/s")
LENGTHS = (2, 3, 5, 10, 30, 100, 1000, 3000)
VALUES: dict[str, Callable[[np.random.Generator, np.ndarray], np.ndarray]] = {
    "white": lambda rng, w: w,
    "walk": lambda rng, w: np.cumsum(w),
    "integers": lambda rng, w: np.round(w),
    "few integers": lambda rng, w: np.round(0.3 * w),
    "constant": lambda rng, w: np.full(w.size, w[0]),
    "line": lambda rng, w: np.arange(w.size) * 1.0,
    "many sizes": lambda rng, w: w * np.exp(rng.uniform(0, 30) * rng.standard_normal(w.size)),
    "sine": lambda rng, w: np.sin(np.arange(w.size) * rng.uniform(0, 3.2)),
    "one spike": lambda rng, w: np.where(np.arange(w.size) == w.size // 2, 1e12, 0.0) + w * rng.choice([0, 1]),
    "spikes": lambda rng, w: np.where(rng.random(w.size) < 0.01, 1e9, w),
    "Cauchy": lambda rng, w: rng.standard_cauchy(w.size),
    "repeated": lambda rng, w: np.repeat(w, 10)[: w.size],
    "far from zero": lambda rng, w: w + 1e9,
    "half dead": lambda rng, w: np.where(np.arange(w.size) < w.size // 2, 0.0, w),
}
"""Values from a generator and white noise."""


def record_of(rng: np.random.Generator) -> al.Record:
    """A record of any values, rate, unit, gaps and length."""
    n = int(rng.choice(LENGTHS)) + int(rng.integers(0, 3))
    y = VALUES[str(rng.choice(list(VALUES)))](rng, rng.standard_normal(n))
    y = y * 10.0 ** rng.choice([0, 0, 0, rng.uniform(-29, 29)])
    rate, unit = float(10.0 ** rng.choice([0, 2, rng.uniform(-9, 15)])), str(rng.choice(UNITS))
    if rng.random() < 0.3:
        y = np.where(rng.random(n) < rng.choice([0.01, 0.3]), np.nan, y)
    if rng.random() < 0.2:
        y = np.clip(y, -1e37, 1e37).astype(np.float32)
    return al.Record(y, rate=rate, unit=unit, name="a", kind=KINDS.get(unit, "rate"))


def worked(k: int) -> None:
    """One of the jobs with record k."""
    rng = np.random.default_rng((77, k))
    job = JOBS[str(rng.choice(list(JOBS)))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", al.statistics.LongJobWarning)
        job(record_of(rng), rng)


# --- stored results --------------------------------------------------------------------------------------------------

DEEP: Any = functools.reduce(lambda inner, _: [inner], range(50_000), 0)

LEAVES = [
    None, True, False, 0, 1, -1, 2, 0.0, -0.5, 1e308, -1e308, 5e-324, float("nan"), float("inf"), 10**30, 10**400, "",
    "x", "nan", "inf", "1e5", "x" * 5000, "\\udcff", "a\\nb", [], {}, [1], [None], [[1.0], [1.0, 2.0]], ["x"], [[]],
    {"a": 1}, {"type": "Study"}, {"level": 2, "values": []}, {"real": [1], "imag": []}, DEEP,
]  # fmt: skip
"""What takes the place of a part."""

EXPORTED, OTHER = ("Study", "Fit", "Channel"), al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")
"""Kinds that are exported when they are read, and the noise of the other sensor."""


def places(data: Any, most: int = 4000) -> list[tuple[Any, Any]]:
    """Containers and keys of the parts of plain data; of a long list the first and last ones."""
    found: list[tuple[Any, Any]] = []
    waiting = [data]
    while waiting and len(found) < most:
        part = waiting.pop(0)
        keys = list(part) if isinstance(part, dict) else sorted({0, 1, len(part) - 1} & set(range(len(part))))
        found += [(part, key) for key in keys]
        waiting += [part[key] for key in keys if isinstance(part[key], (dict, list))]
    return found


def changed(data: dict[str, Any], rng: np.random.Generator) -> Any:
    """Plain data with one or two parts replaced, left out, added, repeated, wrapped, cut short or exchanged."""
    data = copy.deepcopy(data)
    ways = ["swap", "leaf", "leaf", "leaf", "drop", "add", "wrap", "cut", "scale"]
    for turn in range(rng.choice([1, 1, 1, 2])):
        listed = places(data)
        part, key = listed[rng.integers(len(listed))]
        way = str(rng.choice(ways[turn:]))  # what is deep is not copied
        _change(part, key, way, listed, rng)
    return data


def _change(part: Any, key: Any, way: str, listed: list[tuple[Any, Any]], rng: np.random.Generator) -> None:
    value = part[key]
    if way == "drop":
        del part[key]
    elif way == "add":
        part.append(0) if isinstance(part, list) else part.update({"unknown": 1})
    elif way == "wrap":
        part[key] = [value]
    elif way == "cut" and isinstance(value, (list, str)):
        part[key] = value[: len(value) // 2]
    elif way == "swap":
        other, there = listed[rng.integers(len(listed))]
        if there in other if isinstance(other, dict) else there < len(other):
            part[key] = copy.deepcopy(other[there])
    elif way == "scale" and isinstance(value, (int, float)) and not isinstance(value, bool):
        part[key] = value * float(rng.choice([-1.0, 0.0, 1e-300, 1e300]))
    else:
        part[key] = LEAVES[rng.integers(len(LEAVES))]


def mutants(kind: str, data: dict[str, Any], count: int) -> Iterator[tuple[int, Any]]:
    """The first mutants of a kind of result with their numbers."""
    for k in range(count):
        yield k, changed(data, generator(kind, k))


def taken_back(data: Any, k: int = 0) -> None:
    """A result from plain data, and its export to one of the targets."""
    result = al.from_dict(data)
    repr(result)
    if type(result).__name__ in EXPORTED:
        al.export(
            [result, OTHER], list(al.exporting.EXPORTS)[k % len(al.exporting.EXPORTS)], rate=100.0, unexplained=True
        )


def results(_: str) -> Take:
    """Mutants of every kind of result by turns."""
    from tests.conformance.test_round_trip import LEVEL, MAKERS

    levels = {"Fit": (0.95,), "Channel": (0.95,)}
    kinds = list(MAKERS)

    @functools.cache
    def plain(kind: str) -> Any:
        return json.loads(json.dumps(MAKERS[kind]().to_dict(*levels.get(kind.partition(" ")[0], (LEVEL,)))))

    def take(k: int) -> None:
        kind = kinds[k % len(kinds)]
        taken_back(changed(plain(kind), generator(kind, k // len(kinds))), k // len(kinds))

    return take


# --- inputs ----------------------------------------------------------------------------------------------------------

MANIFEST = (
    'file,unit_id,temperature,date,lab\na.csv,A1,20.5,2024-05-31,"north, 1"\nb.csv,A2,-40,2024-05-31T12:00+02:00,\n'
)
LIST = "# units\na.csv\nsub/b.csv\n"
RECIPE = 'rate = 100.0\nunit = "deg/h"\nchannels = ["gx", "2"]\nstart = 1.0\nterms = ["N", "B"]\nlevel = 0.95\n'
STREAM = 12  # seconds of a stream of 100 rows a second

TERM_UNITS = {"Q": "arcsec", "N": "deg/sqrt(h)", "W": "deg/sqrt(h)", "B": "deg/h", "F": "deg/h", "K": "deg/h/sqrt(h)"}
"""Units of the terms whose unit is not that of a rate."""

USUAL: dict[Any, Any] = {float: 1.0, int: 2, str: "deg/s"}
"""What parameters of a plain type are given that have no example."""

SLOW = ("run_batch", "selfcheck", "testing.check_reader")
"""Functions that do much with the right arguments: only arguments of another type are given to them."""

OTHERS = [*LEAVES, np.zeros(3), np.array(["x"]), np.zeros((2, 2)), np.array([np.nan, 1.0]), 1 + 2j, b"x", {1}, object()]


def text_of(name: str) -> Take:
    """Changed manifests and recipes, by the name of their file."""
    from allanite.batch.sources import manifest_of

    text = {"manifest.csv": MANIFEST, "manifest.txt": LIST, "recipe.toml": RECIPE}[name]
    reader = al.Recipe.load if name.endswith(".toml") else manifest_of

    def take(k: int) -> object:
        path = Path(name)
        path.write_bytes(mutated(generator(name, k), text.encode()))
        return reader(path)

    return take


def stream(name: str) -> Take:
    """What is told of a changed stream, and its analysis at the end."""
    import pytest
    from tests.unit.study.test_watching import Clock, watch_of

    def take(k: int) -> object:
        rng = generator(name, k)

        class Changed(Clock):
            def take(self, _: object) -> bytes:
                data: bytes = super().take(_)
                return mutated(rng, data) if data and rng.random() < 0.05 else data

        with pytest.MonkeyPatch.context() as patch:
            Changed(patch, STREAM, lambda times: times)
            with watch_of(al.Recipe(unit="deg/h", time="1"), duration=STREAM + 1, every=4.0) as watch:
                list(watch.events())
                return watch.study()

    return take


def calls(name: str) -> Take:
    """What a public function makes of one argument of any kind; the others are what it needs."""
    from tests.conformance.test_door import ANYTHING, NAMED, SIZED, declared, functions, values

    from allanite.core.declared import misfit

    record = values()["record"]
    examples = {"recording": al.Recording([record]), "fit": al.identify(record), "curve": al.deviation(record)}
    examples |= values() | {"spectrum": al.spectrum(record)}
    parameters = [(f, one.name) for f, each in NAMED.items() for one in each if (f, one.name) not in ANYTHING]

    def example(function: str, parameter: str) -> Any:
        if parameter == "unit" or (parameter == "value" and "unit" in declared(function)):
            return TERM_UNITS.get(function, "deg/s") if parameter == "unit" else 1.0
        return examples.get(parameter, USUAL.get(declared(function).get(parameter)))

    def take(k: int) -> object:
        rng = generator(name, k)
        function, parameter = parameters[rng.integers(len(parameters))]
        fits = [one for one in OTHERS if not misfit(one, declared(function).get(parameter, Any))]
        chosen = fits if fits and rng.random() < 0.5 else OTHERS
        value = chosen[rng.integers(len(chosen))]
        if expected := misfit(value, declared(function).get(parameter, Any)):
            try:
                functions()[function](**{parameter: value})
            except al.AllaniteError as error:
                if f": {parameter} must be {expected}" in str(error):
                    raise
            raise AssertionError(f"{function}({parameter}={value!r:.80}) is not refused as another type")
        needed = [one.name for one in NAMED[function] if one.default is one.empty or one.name in SIZED]
        given = {other: example(function, other) for other in needed} | {parameter: value}
        if function in SLOW or any(one is None for other, one in given.items() if other != parameter):
            return None
        return functions()[function](**given)

    return take


def page(name: str) -> Take:
    """Requests to the page, or damage of one of its files."""
    import hostile

    opened, runner = hostile.prepared(Path("page"))
    OPEN.callback(opened.jobs.workers.close)
    return hostile.requests(opened, runner) if name == "requests" else hostile.damage(opened, runner, name)


# --- targets and their runs ------------------------------------------------------------------------------------------


class Target(NamedTuple):
    """One target: its title, its kinds with the usual number of cases, what takes the cases of one, and its limits."""

    title: str
    kinds: dict[str, int]
    takes: Callable[[str], Take]
    seconds: float = 2.0
    megabytes: int = 100


INPUTS = dict.fromkeys(("manifest.csv", "manifest.txt", "recipe.toml"), (1000, text_of))
INPUTS |= {"stream": (200, stream), "call": (10_000, calls)}
KEPT = ("state.json", "meta.json", "value.json", "shown.json", "0.0.npy")
"""Files that the page keeps, by the end of their name."""

TARGETS = {
    "files": Target("Damaged files", {name: seed.count for name, seed in SEEDS.items()}, files),
    "analysis": Target(
        "Damaged files through a job", {name: max(20, seed.count // 50) for name, seed in SEEDS.items()},
        functools.partial(files, rows=400), 5.0, 200,
    ),
    "records": Target("Any record", {"record": 2000}, lambda _: worked, 5.0, 200),
    "results": Target("Changed results", {"stored result": 60_000}, results, 2.0, 200),
    "inputs": Target(
        "What is handed over", {name: count for name, (count, _) in INPUTS.items()},
        lambda name: INPUTS[name][1](name), 10.0, 200,
    ),
    "page": Target(
        "Requests and files of the page", {"requests": 5000} | dict.fromkeys(KEPT, 400), page, 5.0, 400,
    ),
}  # fmt: skip


def _peak() -> int:
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(kind).ru_maxrss for kind in kinds) // 1024


def _serve(target: str, name: str, span: tuple[int, int], place: Any, pipe: Any) -> None:
    """Take the cases of a span; `place` holds the one at work, `pipe` takes what is found."""
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
            said = judged(take, k)
            took, peak = sum(os.times()[:4]) - start, _peak() - base
            slowest = max(slowest, took)
            over = f"{took:.1f} s" if took > row.seconds else f"{peak} MB" if peak > row.megabytes else ""
            good = said in ("taken", "refused") and not over
            counts[said if good else "failure"] += 1
            if not good:
                pipe.send((k, over or said))
                base = _peak()
        pipe.send((counts, slowest, _peak() - base))
        OPEN.close()
        tempfile.tempdir = None


def run(target: str, name: str, first: int, count: int) -> tuple[Counter[str], float, int, list[str]]:
    """Counts, slowest case, memory and failures of the cases of a kind, in processes that are watched."""
    context, last = multiprocessing.get_context("spawn"), first + count
    place, counts, slowest, peak = context.Value(ctypes.c_long, first), Counter[str](), 0.0, 0
    failed: list[str] = []
    while first < last:
        pipe, end = context.Pipe(duplex=False)
        process = context.Process(target=_serve, args=(target, name, (first, last), place, end))
        process.start()
        end.close()
        told = _followed(process, pipe, place)
        failures = [item for item in told if len(item) == 2]
        first = last
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
    return counts, slowest, peak, failed


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


def main() -> None:
    this = begin(__doc__, target=tuple(TARGETS), share=1.0, only="", first=0, jobs=2)
    asked, target = this.asked, TARGETS[this.asked.target]
    kinds = {name: max(1, round(asked.share * count)) for name, count in target.kinds.items()}
    kinds = {name: count for name, count in kinds.items() if not asked.only or name in asked.only.split(",")}
    rows, failed = [], []
    with ThreadPoolExecutor(asked.jobs) as pool:
        done = pool.map(lambda name: run(asked.target, name, asked.first, kinds[name]), kinds)
        for (name, count), (counts, slowest, peak, failures) in zip(kinds.items(), done, strict=True):
            cells = (count, counts["taken"], counts["refused"], counts["failure"], round(1e3 * slowest), peak)
            rows.append((name, *map(str, cells)))
            failed += failures
            print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    notes = (
        f"case k of a kind has the seed (crc32 of its name, k), k from {asked.first}",
        f"failures: {len(failed)}; over {target.seconds:g} s of processor time or {target.megabytes} MB is one",
        *(f"failed: {one}" for one in failed[:20]),
    )
    headings = ("kind", "cases", "taken", "refused", "failures", "slowest ms", "memory MB")
    this.publish(target.title, notes, markdown(headings, rows))
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
