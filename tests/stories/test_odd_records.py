"""Records that no sensor gives, and any number of channels, through every verb: a result, or a sentence."""

import json
import os
import re
import shlex

import numpy as np
import pytest
from tests.commands import run
from tests.rows import rows
from tests.verbs import ROWS

from allanite.cli import main

N, RATE = 500, 100.0
AXES = ("gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]")
SEED = int(os.environ.get("ALLANITE_SEED", "1"))
OUTPUTS = {"--json": "a.json", "--report": "a.html", "--plot": "a.svg"}

READ = {verb: row.options for verb, row in ROWS.items() if row.options is not None} | {
    "deviation": "--statistic oadev,theoh,mtie",
    "dynamic": "--window 1",
    "compare": "--part 2",
    "compensate": "--regressors gy",
    "rate": "--interval 1 --no-times",
    "export": "--to kalibr --unexplained",
    "watch": "--idle 0.01s",
    "vertical": "",
}
"""Every verb that reads a recording, and what it needs besides."""

NEEDS = {"compensate": 2, "export": 6, "vertical": 6}  # channels, where one is not enough


def missing(y, which):
    y[which] = np.nan
    return y


def twice(t):
    t[10::10] = t[9:-1:10]
    return t


SHAPES = {
    "noise": lambda y, t, rng: (y, t),
    "constant": lambda y, t, rng: (0 * y + 1.25, t),
    "zero": lambda y, t, rng: (0 * y, t),
    "two values": lambda y, t, rng: (np.heaviside(y, 0.0), t),
    "alternating": lambda y, t, rng: (np.arange(N) % 2.0, t),
    "ramp": lambda y, t, rng: (0.01 * np.arange(N), t),
    "parabola": lambda y, t, rng: (1e-6 * np.arange(N) ** 2, t),
    "huge": lambda y, t, rng: (1e12 * y, t),
    "beyond": lambda y, t, rng: (1e300 * y, t),
    "tiny": lambda y, t, rng: (1e-12 * y, t),
    "denormal": lambda y, t, rng: (5e-324 * np.rint(9 * y), t),
    "infinite": lambda y, t, rng: (np.where(np.arange(N) == 50, np.inf, y), t),
    "all missing": lambda y, t, rng: (y * np.nan, t),
    "half missing": lambda y, t, rng: (missing(y, rng.random(N) < 0.5), t),
    "every third missing": lambda y, t, rng: (missing(y, slice(None, None, 3)), t),
    "ten left": lambda y, t, rng: (missing(y, slice(10, None)), t),
    "a long gap": lambda y, t, rng: (missing(y, slice(100, 300)), t),
    "one spike": lambda y, t, rng: (y + 1e6 * (np.arange(N) == 137), t),
    "a step": lambda y, t, rng: (y + 1e3 * (np.arange(N) > 200), t),
    "a small step": lambda y, t, rng: (y + 5 * (np.arange(N) > 200), t),
    "integers": lambda y, t, rng: (np.rint(3 * y), t),
    "periodic": lambda y, t, rng: (np.sin(0.4 * np.pi * np.arange(N)), t),
    "sparse": lambda y, t, rng: (np.where(rng.random(N) < 0.02, y, 0.0), t),
    "an offset": lambda y, t, rng: (y + 1e9, t),
    "random walk": lambda y, t, rng: (y.cumsum(), t),
    "angle noise": lambda y, t, rng: (np.diff(y, append=0.0), t),
    "bursts": lambda y, t, rng: (y, t + 5 * (np.arange(N) // 50)),
    "duplicate stamps": lambda y, t, rng: (y, twice(t)),
    "stamps backward": lambda y, t, rng: (y, t - (np.arange(N) > 200)),
    "scattered stamps": lambda y, t, rng: (y, np.sort(rng.uniform(0, t[-1], N))),
    "stamps beyond": lambda y, t, rng: (y, t + 1e17),
    "slow": lambda y, t, rng: (y, 1e7 * t),
    **{f"{n} samples": lambda y, t, rng, n=n: (y[:n], t[:n]) for n in (1, 2, 3, 10, 100, 200)},
}
"""What becomes of white noise of standard deviation 1 and of its stamps."""


def write(path, shape, channels, seed):
    """A file of text with this shape in each channel; lost samples are empty cells."""
    rng = np.random.default_rng(seed)
    made = [SHAPES[shape](rng.standard_normal(N), np.arange(N) / RATE, rng) for _ in range(channels)]
    names = AXES[:channels] if channels <= len(AXES) else [f"g{k} [deg/s]" for k in range(channels)]
    table = np.column_stack([made[0][1], *(y for y, _ in made)])
    cells = [",".join("" if np.isnan(x) else f"{x:.17g}" for x in row) for row in table]
    path.write_text("\n".join([",".join(["t [s]", *names]), *cells]) + "\n")


def complaint(verb, shape, channels, seed, folder):
    """What is wrong with the answer of a verb to such a file; empty if nothing is."""
    write(folder / "a.csv", shape, channels, seed)
    known = {name for parameter in main.get_command(None, verb).params for name in parameter.opts}
    outputs = [str(word) for option, name in OUTPUTS.items() if option in known for word in (option, folder / name)]
    done = run(verb, folder / "a.csv", *shlex.split(READ[verb]), *outputs, "--details")
    written = {path.suffix: path.read_text() for path in folder.iterdir() if path.name != "a.csv"}
    if ".json" in written:
        json.loads(written[".json"], parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
    markup = written.get(".html", "") + written.get(".svg", "")
    shown = done.stdout + re.sub(r"(?s)<(style|script).*?</\1>|<[^>]*>", "\n", markup)
    number = re.search(r".*(?<![\w.-])-?(nan|inf)(?![\w-]).*", shown) or re.search(r'="[^"<]*\bnan\b[^"]*"', markup)
    wrong = {
        f"exit code {done.exit_code}: {done.stderr}": done.exit_code not in {0, 2, 3, 4},
        f"words of a library: {done.stderr}": re.search("internal error|Traceback|Warning|encountered", done.stderr),
        "nothing was said": not (done.stdout + done.stderr).strip(),
        f"not a number: {number and number.group()}": number,
    }
    return "; ".join(words for words, holds in wrong.items() if holds)


def judge(cases, tmp_path):
    """Every case in a folder of its own; all complaints at once."""
    wrong = {}
    for k, case in enumerate(cases):
        folder = tmp_path / str(k)
        folder.mkdir(parents=True)
        wrong |= {case: words} if (words := complaint(*case, SEED + k, folder)) else {}
    assert not wrong


@pytest.mark.nightly("every shape by every verb")
@rows("verb", READ)
def test_odd_records(verb, tmp_path):
    judge([(verb, shape, NEEDS.get(verb, 1)) for shape in SHAPES], tmp_path)


@pytest.mark.nightly("up to 24 channels by every verb")
@rows("verb", READ)
def test_channels(verb, tmp_path):
    judge([(verb, "noise", channels) for channels in (2, 3, 4, 5, 7, 12, 24)], tmp_path)
    judge([(verb, shape, 6) for shape in ("every third missing", "alternating", "a small step")], tmp_path / "more")


def test_a_few_of_them(tmp_path):
    cases = ("info all missing 1", "check alternating 1", "analyze every third missing 6", "vertical beyond 6",
             "compare alternating 1")  # fmt: skip
    judge([(verb, " ".join(shape), int(channels)) for verb, *shape, channels in map(str.split, cases)], tmp_path)
