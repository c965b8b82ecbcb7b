"""A few hundred damaged files of each format: read or refused in words, never anything else."""

import io

import numpy as np
import pytest

from allanite.errors import AllaniteError
from allanite.readers import read

MUTANTS = 300
NUMBERS = np.random.default_rng(11).normal(size=(40, 3))


def _csv(delimiter):
    rows = (delimiter.join((f"{k * 0.01:.2f}", *(f"{x:.5f}" for x in row))) for k, row in enumerate(NUMBERS))
    head = delimiter.join(("time[s]", "gx[deg/s]", "gy[deg/s]", "T[degC]"))
    return "\n".join(("# a logger", head, *rows, "# end")).encode()


def _npy(array, save=np.save, **arrays):
    file = io.BytesIO()
    save(file, *([array] if array is not None else []), **arrays)
    return file.getvalue()


SEEDS = {
    "comma.csv": _csv(","),
    "semicolon.csv": _csv(";"),
    "blanks.txt": _csv("  "),
    "bare.txt": "\n".join(f"{x:.5f}" for x in NUMBERS[:, 0]).encode(),
    "plain.npy": _npy(NUMBERS),
    "fields.npy": _npy(np.zeros(40, dtype=[("time_ms", "i8"), ("gx_dps", "f4")])),
    "archive.npz": _npy(None, np.savez, gx=NUMBERS[:, 0], t=np.arange(40) * 0.01),
    "squeezed.npz": _npy(None, np.savez_compressed, gx=NUMBERS[:, 0], rate=np.array(100.0)),
    "simu.imu": (
        "% PSINS\n0 0 -90.6 0 0 0\n34.2 108.9 380 0 8.0 9.7803\n0.1 0.1 0.1 125 125 125\n" + "0 -4 2 0 0 80\n" * 40
    ).encode(),
}
SNIPPETS = ["\n", "\r", ",", ";", '"', "#", "nan", "-", "\0", "\xff", "1e999", "[", "O", "%", "\t", "  "]


def mutated(rng, data):
    data = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        at, way = int(rng.integers(0, max(1, len(data)))), int(rng.integers(0, 5))
        if way == 0 and data:
            data[at % len(data)] = int(rng.integers(0, 256))
        elif way == 1:
            del data[at : at + int(rng.integers(1, 30))]
        elif way == 2:
            data[at:at] = SNIPPETS[int(rng.integers(0, len(SNIPPETS)))].encode("latin-1")
        elif way == 3:
            data[at:at] = data[: int(rng.integers(0, 60))]
        elif rng.random() < 0.2:
            del data[at:]
    return bytes(data)


def outcome(path, options):
    try:
        read(path, **options)
    except AllaniteError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", SEEDS)
def test_damaged_files_are_read_or_refused(tmp_path, name):
    rng = np.random.default_rng(sum(name.encode()))
    path = tmp_path / name
    path.write_bytes(SEEDS[name])
    asked = {"rate": 100.0, "unit": "deg/s"}
    assert outcome(path, asked) == ""
    messages = []
    for _ in range(MUTANTS):
        path.write_bytes(mutated(rng, SEEDS[name]))
        messages.append(outcome(path, asked if rng.random() < 0.5 else {}))
    assert any(messages)
    assert all(len(message) > len(str(path)) + 20 for message in messages if message)
