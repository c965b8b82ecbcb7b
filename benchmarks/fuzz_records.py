"""Records of any values, rate, gaps and length: each job has a result, or refuses in words, soon.

    python benchmarks/fuzz_records.py [--count 2000] [--first 0] [--write PATH]

Record k has the seed (77, k). A failure is an error of another type than AllaniteError, a warning of a computation, or
more than 5 s of processor time. Ends with exit code 1 if there is one.
"""

from table import begin, markdown

import json
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

import allanite as al
from allanite.reporting import to_csv

SLOW = 5.0
"""Seconds of processor time that a job may take."""

KINDS = {"rad": "angle", "arcsec": "angle", "m/s": "angle"}
UNITS = ("rad/s", "deg/h", "deg/s", "m/s^2", "g", "mg", "rad", "arcsec", "m/s")
LENGTHS = (2, 3, 5, 10, 30, 100, 1000, 3000)

VALUES = {
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


def _analyzed(record, _):
    study = al.analyze(record)
    json.dumps(study.to_dict(), allow_nan=False)
    str(study), to_csv(study)


def _reported(record, _):
    with tempfile.TemporaryDirectory() as folder:
        al.report(al.analyze(record), Path(folder, "a.html"))


JOBS = {
    "analyze": _analyzed,
    "deviation": lambda record, rng: str(al.deviation(record, str(rng.choice(list(al.STATISTICS))))),
    "spectrum": lambda record, _: str(al.spectrum(record)),
    "dynamic": lambda record, _: str(al.dynamic(record)),
    "identify": lambda record, _: str(al.identify(record)),
    "compare": lambda record, _: str(al.compare(record, record)),
    "a page": _reported,
    "plan": lambda record, _: str(al.plan(al.identify(record), record.rate)),
}


def drawn(k: int) -> tuple[str, str, al.Record | None, np.random.Generator]:
    """Kind of values, job, record (None if it is refused as such) and generator of a number."""
    rng = np.random.default_rng((77, k))
    n = int(rng.choice(LENGTHS)) + int(rng.integers(0, 3))
    kind, job = str(rng.choice(list(VALUES))), str(rng.choice(list(JOBS)))
    y = VALUES[kind](rng, rng.standard_normal(n)) * 10.0 ** rng.choice([0, 0, 0, rng.uniform(-29, 29)])
    rate = float(10.0 ** rng.choice([0, 2, rng.uniform(-9, 15)]))
    unit = str(rng.choice(UNITS))
    if rng.random() < 0.3:
        y = np.where(rng.random(n) < rng.choice([0.01, 0.3]), np.nan, y)
    if rng.random() < 0.2:
        y = np.clip(y, -1e37, 1e37).astype(np.float32)
    try:
        return kind, job, al.Record(y, rate=rate, unit=unit, name="a", kind=KINDS.get(unit, "rate")), rng
    except al.AllaniteError:
        return kind, job, None, rng


def outcome(job: str, record: al.Record | None, rng: np.random.Generator) -> str:
    """What became of a record: done, refused, or a traceback."""
    if record is None:
        return "refused"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", al.LongJobWarning)
        try:
            JOBS[job](record, rng)
        except al.AllaniteError as error:
            return "refused" if len(str(error)) > 20 else f"too few words\n{error}"
        except Exception:
            return "traceback\n" + traceback.format_exc(limit=-3)
    return "done"


def main() -> None:
    run = begin(__doc__, count=2000, first=0)
    counts, slowest, wrong = Counter(), Counter(), []
    for k in range(run.asked.first, run.asked.first + run.asked.count):
        kind, job, record, rng = drawn(k)
        start = time.process_time()
        said = outcome(job, record, rng)
        took = time.process_time() - start
        counts[kind, said.split("\n")[0]] += 1
        slowest[kind] = max(slowest[kind], took)
        if said not in ("done", "refused") or took > SLOW:
            wrong.append(f"record {k}, {kind}, {job}: {took:.1f} s, {said}")
            print(wrong[-1], flush=True)
    rows = [
        (kind, *(str(counts[kind, what]) for what in ("done", "refused", "traceback")), f"{slowest[kind]:.1f}")
        for kind in VALUES
    ]
    notes = (
        f"record k has the seed (77, k), k from {run.asked.first}; 2 to 3002 samples, any unit, rates of 1e-9 "
        "to 1e15 Hz, gaps in 0.3 of them",
        f"failures: {len(wrong)}, of these more than {SLOW:g} s: {sum('traceback' not in one for one in wrong)}",
    )
    run.publish("Any record", notes, markdown(("values", "done", "refused", "tracebacks", "slowest s"), rows))
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
