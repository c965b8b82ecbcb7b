"""Dozens of damaged files of each format: read or refused in words, never anything else.

The first mutations of the same seed files of which `benchmarks/fuzz.py` reads thousands.
"""

import time
from pathlib import Path

import pytest
from tests import ALL, thinned
from tests.pace import pace

from allanite.readers.formats.registry import reader_for, reader_of_type
from allanite.readers.options import channel_names
from allanite.testing import check_reader
from damaged import IMPORTED, SEEDS, generator, mutated, options_of, read
from fuzz import TARGETS, judged


@pytest.mark.ensemble
@pytest.mark.parametrize("name", thinned(SEEDS, 13, "damaged files of every format"))
def test_damaged_files_are_read_or_refused(tmp_path, name):
    if (suffix := Path(name).suffix) in IMPORTED:
        pytest.importorskip(IMPORTED[suffix])
    seed = SEEDS[name]
    data, path = seed.make(), tmp_path / name
    path.write_bytes(data)
    read(path, seed.options)
    found, contained = set(), name.endswith(tuple(IMPORTED))  # in a process of its own
    count = (2 if ALL else 1) if contained else 48 if ALL else 24
    for k in range(count):
        rng = generator(name, k)
        path.write_bytes(mutated(rng, data))
        start = time.process_time()
        found.add(said := judged(read, path, options_of(rng, seed.options)))
        assert said in ("taken", "refused"), (name, k)
        assert time.process_time() - start < TARGETS["files"].seconds * pace(), (name, k)
    assert "refused" in found or (contained and not ALL)


BARE = [name for name in SEEDS if not name.endswith((".zip", ".gz", ".bz2", ".xz"))]


@pytest.mark.ensemble
@pytest.mark.parametrize("name", thinned(BARE, 9, "files of every format, cut off"))
def test_files_cut_off_are_read_or_refused(tmp_path, name):
    if (suffix := Path(name).suffix) in IMPORTED:
        pytest.importorskip(IMPORTED[suffix])
    seed, path = SEEDS[name], tmp_path / name
    path.write_bytes(data := seed.make())
    choices = {key: channel_names(value) if key == "channels" else value for key, value in seed.options.items()}
    dtype = choices.get("dtype")
    check_reader(reader_of_type(dtype) if dtype else reader_for(data[:4096], suffix), path, **choices)
