"""Changed results: whatever is changed in the plain data of a result of any kind, it is read or refused in words, soon.

    python benchmarks/fuzz_results.py [--count 200] [--only Study,Curve] [--jobs 2] [--write PATH]

Mutant k of a kind has the seed (crc32 of its name, k). A failure is an error of another type than AllaniteError, a
message of fewer than 20 or more than 1000 characters, a mutant that is read and whose `repr` fails, or more than 2 s of
processor time. What is read of an analysis or a fit is exported to one of the targets, or refused in words.
Ends with exit code 1 if there is a failure.
"""

from table import Row, begin, markdown

import copy
import functools
import json
import sys
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
from tests.conformance.test_round_trip import LEVEL, MAKERS

import allanite as al

SLOW = 2.0
"""Seconds of processor time that a mutant may take."""

WARM = 5
"""Mutants of a kind that are not timed: what they need is imported and compiled."""

DEEP: Any = functools.reduce(lambda inner, _: [inner], range(50_000), 0)

LEAVES = [
    None, True, False, 0, 1, -1, 2, 0.0, -0.5, 1e308, -1e308, 5e-324, float("nan"), float("inf"), 10**30, 10**400, "",
    "x", "nan", "inf", "1e5", "x" * 5000, "\\udcff", "a\\nb", [], {}, [1], [None], [[1.0], [1.0, 2.0]], ["x"], [[]],
    {"a": 1}, {"type": "Study"}, {"level": 2, "values": []}, {"real": [1], "imag": []}, DEEP,
]  # fmt: skip
"""What takes the place of a part."""

EXPORTED = ("Study", "Fit", "Channel")
"""Kinds that are exported when they are read."""

LEVELS: dict[str, tuple[float, ...]] = {"Fit": (0.95,), "Channel": (0.95,)}
"""The level of what is exported without a recipe."""


def places(data: Any, most: int = 4000) -> list[tuple[Any, Any]]:
    """Containers and keys of the parts of plain data; of a long list the first and last ones."""
    found: list[tuple[Any, Any]] = []
    left = [data]
    while left and len(found) < most:
        part = left.pop(0)
        keys = list(part) if isinstance(part, dict) else sorted({0, 1, len(part) - 1} & set(range(len(part))))
        found += [(part, key) for key in keys]
        left += [part[key] for key in keys if isinstance(part[key], (dict, list))]
    return found


def mutant(data: dict[str, Any], rng: np.random.Generator) -> Any:
    """Plain data with one or two parts replaced, left out, added, repeated, wrapped, cut short or exchanged."""
    data = copy.deepcopy(data)
    ways = ["swap", "leaf", "leaf", "leaf", "drop", "add", "wrap", "cut", "scale"]
    for changed in range(rng.choice([1, 1, 1, 2])):
        listed = places(data)
        part, key = listed[rng.integers(len(listed))]
        way = str(rng.choice(ways[changed:]))  # what is deep is not copied
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
    """The first mutants of a kind with their numbers."""
    for k in range(count):
        yield k, mutant(data, np.random.default_rng((zlib.crc32(kind.encode()), k)))


def outcome(data: Any, k: int = 0) -> str:
    """What became of plain data: read, exported, refused, or a traceback."""
    try:
        found = al.from_dict(data)
    except al.AllaniteError as error:
        return "refused" if 20 < len(str(error)) < 1000 else f"words\n{error}"
    except Exception:
        return "traceback\n" + traceback.format_exc(limit=-4)
    try:
        repr(found)
        if type(found).__name__ in EXPORTED:
            al.export([found, *OTHERS], TARGETS[k % len(TARGETS)], rate=100.0, unexplained=True)
            return "exported"
    except al.AllaniteError as error:
        return "refused" if 20 < len(str(error)) < 1000 else f"words\n{error}"
    except Exception:
        return "traceback\n" + traceback.format_exc(limit=-4)
    return "read"


OTHERS = [al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")]
TARGETS = list(al.EXPORTS)


def _row(kind: str, count: int) -> tuple[Row, list[str]]:
    data = json.loads(json.dumps(MAKERS[kind]().to_dict(*LEVELS.get(kind.partition(" ")[0], (LEVEL,)))))
    counts, slowest, wrong = Counter[str](), 0.0, []
    for k, changed in mutants(kind, data, count):
        start = time.process_time()
        said = outcome(changed, k)
        took = time.process_time() - start if k >= WARM else 0.0
        slowest = max(slowest, took)
        counts[said.partition("\n")[0]] += 1
        if said not in {"read", "exported", "refused"} or took > SLOW:
            wrong.append(f"{kind}, mutant {k}: {took:.1f} s, {said}")
    read = counts["read"] + counts["exported"]
    cells = (kind, count, read, counts["exported"], counts["refused"], len(wrong), f"{1000 * slowest:.0f}")
    return tuple(map(str, cells)), wrong


def main() -> None:
    run = begin(__doc__, count=200, only="", jobs=2)
    kinds = [kind for kind in MAKERS if not run.asked.only or kind in run.asked.only.split(",")]
    with ProcessPoolExecutor(run.asked.jobs) as pool:
        rows, wrong = [], []
        for row, failures in pool.map(_row, kinds, [run.asked.count] * len(kinds)):
            rows.append(row)
            wrong += failures
            print(*row, *failures, sep="\n  " if failures else " ", flush=True)
    notes = (
        "mutant k of a kind has the seed (crc32 of its name, k), k from 0",
        f"mutants: {sum(int(row[1]) for row in rows)}, failures: {len(wrong)}",
        "exported: the noise of an analysis or a fit that was read, to one target after the other",
    )
    headings = ("kind", "mutants", "read", "exported", "refused", "failures", "slowest ms")
    run.publish("Changed results", notes, markdown(headings, rows))
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
