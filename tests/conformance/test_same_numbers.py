"""What a change of the record that means nothing does to the results: the digits that docs/command.md promises.

Every number of a result is compared by its place in the JSON; it may grow with a power of the scale from -2 to 2.
"""

import os
import subprocess
import sys

import numpy as np
import pytest
from tests.rows import paired, rows

import allanite as al

RATE = 100.0
BASE = al.simulate(al.sensor("mems"), 6000, RATE, rng=np.random.default_rng(1)).values
JOBS = {
    "identify": (al.identify, 1e-5),  # deviates of cells are small differences
    "deviation": (al.deviation, 2e-8),  # the limits follow the noise that is identified
    "mdev": (lambda record: al.deviation(record, "mdev", noise=None), 1e-12),
    "spectrum": (al.spectrum, 1e-12),
    "dynamic": (al.dynamic, 1e-12),
}
SCALES = {"2^60": 2.0**60, "2^-60": 2.0**-60} | {text: float(text) for text in ("1e15", "1e-15", "1e28", "1e-25")}
"""Of values of about 1e-3; tests/unit/cli/test_streams.py has what is refused beyond."""
UNCHANGED = {
    "sign": lambda values: -values, "bias": lambda values: values + 1 / 4, "reversal": lambda values: values[::-1],
    "memory order": lambda values: np.asfortranarray(np.column_stack([values, values]))[:, 0],
}  # fmt: skip
ORDERED = {("spectrum", "reversal"), ("dynamic", "reversal")}  # their windows are laid from the beginning
SIGNED = "R"  # the rate ramp has a sign, which the first two sorts of mirror change


def leaves(value, path=()):
    """(path, leaf) of every value in a result."""
    if not isinstance(value, (dict, list, tuple)):
        yield path, value
        return
    for key, part in value.items() if isinstance(value, dict) else enumerate(value):
        yield from leaves(part, (*path, key))


def results(job, values):
    found = job(al.Record(values, rate=RATE, unit="rad/s")).to_dict()
    if "terms" in found:
        found["terms"] = [term for term in found["terms"] if term["symbol"] != SIGNED]
        for of_signed in ("profile", "alternatives", "rivals", "correlation"):
            found.pop(of_signed, None)
        # a component that hardly stands may be another of the same weight
        found["components"] = [part for part in found.get("components", ()) if part["weight"] >= 0.5]
    return dict(leaves(found))


def assert_same(got, expected, digits, scale=1):
    assert got.keys() == expected.keys()
    for path, value in expected.items():
        other = got[path]
        if any(isinstance(one, bool) or not isinstance(one, (int, float)) for one in (value, other)):
            assert other == value, path
        elif value != other and not np.isnan(value):
            wanted = [value * scale**k for k in ((0,) if scale == 1 else (1, 2, 0, -1, -2))]
            assert any(abs(other - number) <= digits * abs(number) for number in wanted), (path, value, other)


@pytest.fixture(scope="module")
def plain():
    return {name: results(job, BASE) for name, (job, _) in JOBS.items()}


@rows("name, scale", paired(JOBS, SCALES))
def test_a_scale_is_that_of_the_results(name, scale, plain):
    job, digits = JOBS[name]
    assert_same(results(job, BASE * SCALES[scale]), plain[name], digits, SCALES[scale])


@rows("name, change", [(name, change) for name in JOBS for change in UNCHANGED if (name, change) not in ORDERED])
def test_what_means_nothing_changes_nothing(name, change, plain):
    job, digits = JOBS[name]
    assert_same(results(job, UNCHANGED[change](BASE)), plain[name], digits)


@rows("name", JOBS)
def test_single_precision_is_read_as_it_is(name):
    job, single = JOBS[name][0], BASE.astype(np.float32)
    assert results(job, single) == results(job, single.astype(np.float64))


WITH_THREADS = """
import json
import allanite as al
import numpy as np
record = al.simulate(al.sensor("mems"), 20_000, 100.0, rng=np.random.default_rng(1))
curve = al.deviation(record, "oadev")
found = (curve, al.identify(curve, method="gls"), al.identify(record), al.spectrum(record, "multitaper"))
print(json.dumps([one.to_dict() for one in found]))
"""


@pytest.mark.slow("processes with other numbers of threads")
def test_libraries_for_linear_algebra_may_have_any_number_of_threads():
    environments = (dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), k) for k in "13")
    command = [sys.executable, "-c", WITH_THREADS]
    first, second = (subprocess.run(command, env=os.environ | e, capture_output=True, check=True) for e in environments)
    assert first.stdout == second.stdout


@pytest.mark.slow("takes more than half a second")
def test_no_channel_depends_on_its_neighbours():
    one, other = (al.Record(BASE[::step], rate=RATE, unit="rad/s", name=f"x{step}") for step in (1, -1))
    there, back, alone = (al.analyze(al.Recording(order)) for order in ((one, other), (other, one), (one,)))
    first, second = (channel.fit.to_dict() for channel in there.channels)
    assert [channel.fit.to_dict() for channel in back.channels] == [second, first]
    assert alone.channels[0].fit.to_dict() == first
