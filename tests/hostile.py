"""What is handed over: damaged files, any record, changed results, manifests, recipes, streams and calls.

Case k of a kind is always the same: its generator is seeded by the name of the kind and k. The tests take the first
ones, benchmarks/fuzz.py thousands.

files     damaged files of every format
analysis  longer ones, and what can still be read goes through one of the jobs
records   any values, rate, gaps and length through each job
results   changed plain data of stored results; what is read of a noise is exported
inputs    changed manifests, recipes and streams; calls with arguments of any kind, half of them of the right type
"""

import contextlib
import copy
import functools
import io
import json
import os
import tempfile
import traceback
import warnings
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import allanite as al
from allanite.kernels.passing import followed
from allanite.reporting import to_csv
from tests.sound_files import ASKED, SEEDS, lengthen

MEMORY = next((folder for folder in ("/dev/shm",) if os.path.isdir(folder)), None)  # noqa: S108  a disk is slow

Take = Callable[[int], object]

SNIPPETS = [
    b"\n", b"\r", b",", b";", b'"', b"#", b"nan", b"-", b"\0", b"\xff", b"1e999", b"[", b"O", b"%", b"\t", b"  ",
]  # fmt: skip
EXTREMES = [0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 0x80000000, (1 << 63) - 1, (1 << 64) - 1]


def generator(name: str, k: int) -> np.random.Generator:
    """The generator of mutation `k` of a seed file."""
    return np.random.default_rng((zlib.crc32(name.encode()), k))


def mutated(rng: np.random.Generator, data: bytes) -> bytes:
    """`data` with one to five damages: bytes changed, zeroed, removed, inserted, repeated, extreme sizes, a cut."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        at, way, size = int(rng.integers(0, max(1, len(changed)))), int(rng.integers(0, 8)), int(rng.integers(1, 60))
        if way == 0 and changed:
            changed[at % len(changed)] = int(rng.integers(0, 256))
        elif way == 1 and changed:
            changed[at % len(changed)] ^= 1 << int(rng.integers(0, 8))
        elif way == 2:
            changed[at : at + size] = bytes(len(changed[at : at + size]))
        elif way == 3:
            del changed[at : at + size]
        elif way == 4:
            changed[at:at] = SNIPPETS[int(rng.integers(0, len(SNIPPETS)))]
        elif way == 5:
            changed[at:at] = changed[max(0, at - size) : at]
        elif way == 6:
            width, order = int(rng.choice([1, 2, 4, 8])), str(rng.choice(["little", "big"]))
            number = EXTREMES[int(rng.integers(0, len(EXTREMES)))] % (1 << 8 * width)
            changed[at : at + width] = number.to_bytes(width, order)
        elif rng.random() < 0.2:
            del changed[at:]
    return bytes(changed)


def options_of(rng: np.random.Generator, usual: dict) -> dict:
    """The options of the seed, or fewer, or more: each way leads through other code."""
    return (usual, usual, usual | ASKED, {k: v for k, v in usual.items() if k == "dtype"})[rng.integers(0, 4)]


def read(path: Path, options: dict) -> al.Recording:
    """A file that is read, or refused in words."""
    try:
        return al.read(path, **options)
    except al.AllaniteError as error:
        words = str(error).removeprefix(str(path))
        if "does not fit into memory" in words or len(words) <= 20:
            raise AssertionError(f"no way to refuse a file: {words}") from error
        raise


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
    parts: list[tuple[Any, Any]] = []
    waiting = [data]
    while waiting and len(parts) < most:
        part = waiting.pop(0)
        keys = list(part) if isinstance(part, dict) else sorted({0, 1, len(part) - 1} & set(range(len(part))))
        parts += [(part, key) for key in keys]
        waiting += [part[key] for key in keys if isinstance(part[key], (dict, list))]
    return parts


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
        other, place = listed[rng.integers(len(listed))]
        if place in other if isinstance(other, dict) else place < len(other):
            part[key] = copy.deepcopy(other[place])
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
    from allanite.core.declared import misfit
    from tests.conformance.test_door import ANYTHING, NAMED, SIZED, declared, functions, values

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
        fits = [value for value in OTHERS if not misfit(value, declared(function).get(parameter, Any))]
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


INPUTS: dict[str, tuple[int, Callable[[str], Take]]] = {
    **dict.fromkeys(("manifest.csv", "manifest.txt", "recipe.toml"), (1000, text_of)),
    "stream": (200, stream), "call": (10_000, calls),
}  # fmt: skip
"""Kinds of inputs: the usual number of cases, and what takes them."""
