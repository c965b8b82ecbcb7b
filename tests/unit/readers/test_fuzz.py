"""Some hundred damaged files of each format: read or refused in words, never anything else.

The first mutations of the same seed files of which `benchmarks/fuzz_readers.py` reads many more.
"""

import importlib.util
import time
from pathlib import Path

import pytest
from tests import ALL, ROOT, examples, thinned

SCRIPT = ROOT / "benchmarks" / "fuzz_readers.py"
spec = importlib.util.spec_from_file_location("fuzz_readers", SCRIPT)
fuzz = importlib.util.module_from_spec(spec)
spec.loader.exec_module(fuzz)


@pytest.mark.ensemble
@pytest.mark.parametrize("name", thinned(fuzz.SEEDS, 13, "damaged files of every format"))
def test_damaged_files_are_read_or_refused(tmp_path, name):
    if (suffix := Path(name).suffix) in fuzz.IMPORTED:
        pytest.importorskip(fuzz.IMPORTED[suffix])
    seed = fuzz.SEEDS[name]
    data, path = seed.make(), tmp_path / name
    path.write_bytes(data)
    assert fuzz.outcome(path, seed.options) == "read"
    found, contained = set(), name.endswith(fuzz.CONTAINED)  # in a process of its own
    count = (4 if ALL else 1) if contained else examples(120)
    for k in range(count):
        rng = fuzz.generator(name, k)
        path.write_bytes(fuzz.mutated(rng, data))
        start = time.process_time()
        found.add(said := fuzz.outcome(path, fuzz.options_of(rng, seed.options)))
        assert said in ("read", "refused"), (name, k)
        assert time.process_time() - start < fuzz.SLOW, (name, k)
    assert "refused" in found or (contained and not ALL)
