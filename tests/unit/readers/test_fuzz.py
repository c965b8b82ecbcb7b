"""Dozens of damaged files of each format: read or refused in words, never anything else.

The first mutations of the same seed files of which `benchmarks/fuzz.py` reads thousands.
"""

from pathlib import Path
from types import SimpleNamespace

import pytest
from tests import ALL, thinned
from tests.hostile import generator, judged, mutated, options_of, read
from tests.rows import rows
from tests.sound_files import IMPORTED, SEEDS

from allanite.readers.formats.registry import readable, reader_for, reader_of_type
from allanite.readers.options import channel_names
from allanite.testing import check_reader


@pytest.mark.slow("takes more than half a second")
@pytest.mark.ensemble
@rows("name", thinned(SEEDS, 13))
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
        found.add(outcome := judged(read, path, options_of(rng, seed.options)))
        assert outcome in ("taken", "refused"), (name, k)
    assert "refused" in found or (contained and not ALL)


BARE = [name for name in SEEDS if not name.endswith((".zip", ".gz", ".bz2", ".xz"))]


@pytest.mark.ensemble
@rows("name", thinned(BARE, 4))
def test_files_cut_off_are_read_or_refused(tmp_path, name):
    if (suffix := Path(name).suffix) in IMPORTED:
        pytest.importorskip(IMPORTED[suffix])
    seed, path = SEEDS[name], tmp_path / name
    path.write_bytes(data := seed.make())
    choices = {key: channel_names(value) if key == "channels" else value for key, value in seed.options.items()}
    dtype = choices.get("dtype")
    reader = reader_of_type(dtype) if dtype else reader_for(data[:4096], suffix)
    check_reader(SimpleNamespace(TITLE=reader.TITLE, sniff=readable, read=reader.read), path, **choices)
