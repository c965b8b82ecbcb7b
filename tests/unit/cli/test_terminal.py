"""Whatever a file, a name or an option holds: on a terminal it moves no cursor, sets no title and begins no line."""

import json
import os
import re
import sys
import threading
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest

from allanite.cli import VERBS, main

pty = pytest.importorskip("pty")

EVIL = "e\x1b]0;PWN\x07\x1b[35;46m\x9b35m\u202e\u2066\r\nINJ\x08\x7f\u200b" + "n" * 20
OWN = re.compile(r"\x1b\[\d+(;\d+)*m|\x1b\[\?25[lh]|\x1b\[1A|\x1b\[2K|\r")
"""What the program itself writes: styles, and the moves of its progress bar."""

ODD = f"f{EVIL}\udcff.h5"  # the last one is no letter of UTF-8
SIX = f"s{EVIL}.h5"
LINES = {
    "info": (f"{ODD}", f"{ODD} --details", f"none{EVIL}", "h.zip", f"h.zip::{EVIL}", f"{ODD} --unit {EVIL}",
             f"{ODD} --channels {EVIL}", f"--{EVIL}", f"{ODD} {EVIL}", f"{ODD} --lang {EVIL}", f"{ODD} --plot {EVIL}"),
    "analyze": (f"{ODD} --report p{EVIL}.html", f"{ODD} good.csv none{EVIL}", f"{ODD} --terms {EVIL}", f"{ODD} --csv -",
                f"{ODD} --json -", f"{ODD} --limits limits.toml", f"{ODD} --recipe recipe.toml"),
    "batch": (f"units.csv --out r{EVIL} --workers 1", f"{EVIL} --out r"),
    "lot": (f"r{EVIL}", f"r{EVIL} --details", f"{EVIL}"),
    "deviation": (f"{ODD} {SIX} --channels 1", f"{ODD} --csv -", f"--model {EVIL}"),
    "spectrum": (f"{ODD} --fit", f"{ODD} --window {EVIL}"),
    "dynamic": (f"{ODD} --window 10", f"{ODD} --window {EVIL}"),
    "compare": (f"{SIX}", f"{ODD} good.csv", f"{ODD} good.csv --against {EVIL}"),
    "check": (f"{ODD} --claims", f"{ODD} --claims {EVIL}"),
    "watch": (f"good.csv --idle 0.1s --record w{EVIL}.csv", f"none{EVIL}", f"{ODD} --idle 0.1s"),
    "serve": (f"--limit {EVIL}", f"--port {EVIL}"),
    "simulate": (f"m{EVIL}.csv --sensor mems --rate 20 --samples 90", f"m{EVIL} --sensor mems --rate 2 --samples 9"),
    "plan": (f"{ODD} --unexplained", f"--sensor {EVIL}"),
    "drift": (f"{SIX} --unexplained", f"{ODD} --require {EVIL}"),
    "selfcheck": (f"{ODD} --records 2 --unexplained",),
    "statespace": (f"{ODD} --unexplained",),
    "export": (f"{SIX} --to kalibr --unexplained", f"{SIX} --to px4 --unexplained -o -", f"{ODD} --to {EVIL}"),
    "convert": (f"{EVIL}", f"parameters{EVIL} --from px4", f"parameters{EVIL} --from kalibr"),
    "explain": (f"{EVIL}", f"oadev --samples {EVIL}"),
    "example": (f"{EVIL} folder",),
    "rate": (f"{ODD} --interval 10", f"{ODD} --interval 10 --csv -"),
    "angle": (f"{EVIL}", f"calibrate {ODD} --measured {EVIL} --reference {EVIL}"),
    "quantization": (f"{ODD} --stage", f"{ODD} --stage {EVIL}"),
    "compensate": (f"{ODD} --regressors 3", f"{ODD} --regressors {EVIL}"),
    "vertical": (f"{SIX}", f"{SIX} --filter {EVIL}"),
}  # fmt: skip
MORE = {"check": ["N 1 deg/sqrt(h)", "--at-most"], "quantization": [f"{EVIL} 16 300deg/s"]}
"""Words with blanks, behind an option that ends a line."""


def recording(path, columns):
    """An HDF5 file, whose names may hold anything."""
    rng = np.random.default_rng(1)
    with h5py.File("new.h5", "w", track_order=True) as file:
        file.attrs["rate"] = 20.0
        for column in columns:
            name, _, unit = column.replace("/", "_", column.count("/") - 1).rpartition(" [")
            file[name] = rng.normal(size=600)
            file[name].attrs["units"] = unit.rstrip("]")
    os.replace("new.h5", path)


def furnish():
    """Files whose names, columns and words are hostile."""
    recording(ODD, (f"g{EVIL}x [deg/h]", f"t{EVIL} [degC]"))
    recording(SIX, [f"{kind}{axis}{EVIL} [{unit}]" for kind, unit in (("a", "g"), ("g", "deg/s")) for axis in "xyz"])
    values = np.column_stack([np.arange(600) / 20, np.random.default_rng(2).normal(size=600)])
    np.savetxt("good.csv", values, "%.4f", ",", header="t [s],gx [deg/h]", comments="")
    word, name = json.dumps(EVIL), EVIL.replace("\n", "").replace("\r", "")
    Path("units.csv").write_text(f"file,unit_id,temperature\ngood.csv,{name},20\nnone{name}.csv,{name},30\n", "utf-8")
    with zipfile.ZipFile("h.zip", "w") as archive:
        for member in (f"{EVIL}.csv", f"two{EVIL}.csv"):
            archive.write("good.csv", member)
    for path, text in (("limits.toml", f"[channels.{word}]\nN = {{max = {word}}}\n"), ("recipe.toml", f"{word} = 1\n"),
                       (f"parameters{EVIL}", f"1\t1\tEKF2_GYR_NOISE{EVIL}\t{EVIL}\t9\n")):  # fmt: skip
        Path(path).write_text(text, encoding="utf-8")


def on_terminal(run):
    """What a function writes to a pseudo-terminal that is both standard streams."""
    ours, theirs = pty.openpty()
    came = []

    def drain():
        try:
            while data := os.read(ours, 1 << 16):
                came.append(data)
        except OSError:  # closed at the other end
            pass

    reading = threading.Thread(target=drain)
    reading.start()
    with pytest.MonkeyPatch.context() as patch:
        for name in ("stdout", "stderr"):
            patch.setattr(sys, name, open(theirs, "w", closefd=False, encoding="utf-8", errors="surrogateescape"))  # noqa: SIM115
        try:
            run()
        except SystemExit as end:
            came.append(f"ended {end.code}\n".encode())
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    os.close(theirs)
    reading.join()
    os.close(ours)
    return b"".join(came).decode("utf-8", "surrogateescape")


def drives(text, *, table=False):
    """What a text does to a terminal beside the program's own styles; the cells of a `table` may have line breaks."""
    plain = OWN.sub("", text)
    assert "\x1b[35;46m" not in text
    lines = [line for line in plain.split("\n") if line.startswith("INJ") and not table]
    return lines or [c for c in plain if not c.isprintable() and c != "\n" and not "\udc80" <= c <= "\udcff"]


@pytest.mark.slow("every verb")
@pytest.mark.filterwarnings("ignore")  # of odd records, not of what is tried here
def test_no_name_drives_the_terminal(tmp_path, monkeypatch, subtests):
    assert list(LINES) == list(VERBS)
    monkeypatch.chdir(tmp_path)
    furnish()
    for verb, lines in LINES.items():
        for line in lines:
            words = [verb, *line.split(" ")]  # the hostile text has line breaks and no blanks
            words += MORE.get(verb, []) if line.endswith(("--claims", "--stage")) else []
            with subtests.test(msg=repr(words)[:90]):
                text = on_terminal(lambda words=words: main(words))
                assert "internal error" not in text
                assert "Traceback" not in text
                assert not drives(text, table="--csv" in words)


@pytest.mark.slow("a batch")
def test_a_name_that_is_not_utf_8_is_read_written_and_stored(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    furnish()
    folder = "d\udcff"
    os.mkdir(folder)
    os.replace("good.csv", f"{folder}/a\udcfe.csv")
    for line in (f"analyze {folder}/a\udcfe.csv --json o.json --csv o.csv --report o.html",
                 f"batch {folder} --out {folder}/out --workers 1", f"lot {folder}/out",
                 f"simulate {folder}/m.parquet --sensor mems --rate 20 --samples 300", f"info {folder}/m.parquet",
                 f"deviation {folder}/m.parquet --memory 1KB"):  # fmt: skip
        text = on_terminal(lambda line=line: main(line.split(" ")))
        assert "ended 0" in text, text
    assert json.loads(Path("o.json").read_bytes())["provenance"]["source"] == f"{folder}/a\udcfe.csv"
