"""The first run after an installation: what is compiled, in how many variants, and what the bar says meanwhile."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from allanite.kernels.ahead import HERE, THERE
from allanite.parallel.processors import PREPARING

pytestmark = pytest.mark.nightly("compiles the kernels in three processes")

SAMPLE = Path(__file__).parents[2] / "examples" / "tactical_gyro.csv"

COMPILED = 37
"""Kernels and parts that the sample needs, each for one set of types; more of them make the first run longer."""

PROGRAM = """
import json, sys
from numba.core.dispatcher import Dispatcher
from allanite.kernels import ahead
from allanite.study.analysis import analyze
from allanite.parallel.processors import processes

if "on demand" in sys.argv:
    ahead.load = lambda kernels: None
said = []
with processes(1 if "on demand" in sys.argv else 2):
    study = analyze(sys.argv[1], progress=lambda what, _: said.append(what))
used = [
    f"{name.removeprefix('allanite.kernels.')}.{kernel}"
    for name, module in sys.modules.items() if name.startswith("allanite.kernels.")
    for kernel, found in vars(module).items()
    if isinstance(found, Dispatcher) and found.py_func.__module__ == name and found.stats.cache_hits
]
print(json.dumps([said, used, [str(channel.fit.model) for channel in study.channels]]))
"""


def python(cache, *arguments):
    """What a process of its own prints, with this cache of kernels."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_kernels_are_compiled_once_and_none_in_vain(tmp_path):
    """A first run and two more, the last of which compiles on demand."""
    cache, runs, counts = tmp_path / "kernels", [], []
    for how in ("ahead", "ahead", "on demand"):
        done = python(cache, "-c", PROGRAM, str(SAMPLE), how)
        assert done.returncode == 0, done.stderr
        runs.append(json.loads(done.stdout))
        counts.append(len(list(cache.rglob("*.nbc"))))
    told, used, models = zip(*runs, strict=True)
    assert [PREPARING in said for said in told] == [True, False, False]
    assert told[0][-1] == told[1][-1] == "done"
    assert sorted(used[2]) == sorted({**HERE, **THERE})
    assert models[0] == models[1] == models[2]
    assert counts == [COMPILED] * 3


def test_a_mistake_does_not_wait_for_the_kernels(tmp_path):
    done = python(tmp_path / "kernels", "-m", "allanite.cli", "analyze", str(tmp_path / "missing.csv"))
    assert done.returncode == 3
    assert "missing.csv" in done.stderr
    assert len(list(tmp_path.rglob("*.nbc"))) < COMPILED // 2
