"""What users and programs hand over: changed manifests, recipes and streams, and calls with arguments of any kind.

    python benchmarks/fuzz_inputs.py [--texts 1000] [--streams 200] [--calls 10000] [--first 0] [--write PATH]

Case k of a kind has the seed (crc32 of its name, k). A failure is an error of another type than AllaniteError, a
RuntimeWarning, a message of fewer than 20 or more than 1000 characters, an argument of another type that is taken, or
more than 2 s of processor time, of a stream 10. A call gives one parameter of a public function a value of any kind,
half of them of its type, and the others what they need. Ends with exit code 1 if there is a failure.
"""

from table import begin, markdown

import contextlib
import functools
import io
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.conformance.test_door import ANYTHING, NAMED, SIZED, declared, functions, values
from tests.unit.study.test_watching import Clock, watch_of

import allanite as al
from allanite.batch.sources import manifest_of
from allanite.core.declared import misfit
from damaged import generator, mutated
from fuzz_results import LEAVES

MANIFEST = (
    'file,unit_id,temperature,date,lab\na.csv,A1,20.5,2024-05-31,"north, 1"\nb.csv,A2,-40,2024-05-31T12:00+02:00,\n'
)
LIST = "# units\na.csv\nsub/b.csv\n"
RECIPE = 'rate = 100.0\nunit = "deg/h"\nchannels = ["gx", "2"]\nstart = 1.0\nterms = ["N", "B"]\nlevel = 0.95\n'
SECONDS = 12
"""Length of a stream of 100 rows a second."""

UNITS = {"Q": "arcsec", "N": "deg/sqrt(h)", "W": "deg/sqrt(h)", "B": "deg/h", "F": "deg/h", "K": "deg/h/sqrt(h)"}
"""Units of the terms whose unit is not that of a rate."""

USUAL: dict[Any, Any] = {float: 1.0, int: 2, str: "deg/s"}
"""What parameters of a plain type are given that have no example."""

SLOW = ("run_batch", "selfcheck", "testing.check_reader")
"""Functions that do much with the right arguments: only arguments of another type are given to them."""

OTHERS = [*LEAVES, np.zeros(3), np.array(["x"]), np.zeros((2, 2)), np.array([np.nan, 1.0]), 1 + 2j, b"x", {1}, object()]


class Kind(NamedTuple):
    """One kind of what is handed over: cases, what takes case k, and the seconds of processor time it may need."""

    cases: int
    take: Callable[[str, int], object]
    seconds: float = 2.0


def taken(text: str, reader: Callable[[Path], object]) -> Callable[[str, int], object]:
    """What gives a reader a changed text."""

    def take(name: str, k: int) -> object:
        path = Path(name)
        path.write_bytes(mutated(generator(name, k), text.encode()))
        return reader(path)

    return take


def watched(name: str, k: int) -> object:
    """What is told of a changed stream, and its analysis at the end."""
    rng = generator(name, k)

    class Changed(Clock):
        def take(self, _: object) -> bytes:
            data: bytes = super().take(_)
            return mutated(rng, data) if data and rng.random() < 0.05 else data

    with pytest.MonkeyPatch.context() as patch:
        Changed(patch, SECONDS, lambda times: times)
        with watch_of(al.Recipe(unit="deg/h", time="1"), duration=SECONDS + 1, every=4.0) as watch:
            list(watch.events())
            return watch.study()


@functools.cache
def made() -> dict[str, Any]:
    """Examples of what other functions make."""
    record = values()["record"]
    fit, curve, spectrum = al.identify(record), al.deviation(record), al.spectrum(record)
    return {"recording": al.Recording([record]), "fit": fit, "curve": curve, "spectrum": spectrum}


def example(function: str, parameter: str) -> Any:
    """What a parameter is given when another one is tried; None if there is nothing."""
    if parameter == "unit" or (parameter == "value" and "unit" in declared(function)):
        return UNITS.get(function, "deg/s") if parameter == "unit" else 1.0
    usual = USUAL.get(declared(function).get(parameter))
    return (values() | made()).get(parameter, usual)


def called(name: str, k: int) -> object:
    """What a public function makes of one argument of any kind."""
    rng = generator(name, k)
    places = [(f, one.name) for f, ones in NAMED.items() for one in ones if (f, one.name) not in ANYTHING]
    function, parameter = places[rng.integers(len(places))]
    fits = [one for one in OTHERS if not misfit(one, declared(function).get(parameter, Any))]
    chosen = fits if fits and rng.random() < 0.5 else OTHERS
    value = chosen[rng.integers(len(chosen))]
    if expected := misfit(value, declared(function).get(parameter, Any)):
        try:
            functions()[function](**{parameter: value})
        except al.AllaniteError as error:
            if f": {parameter} must be {expected}" in str(error):
                raise
        raise AssertionError(f"{function}({parameter}={value!r:.80}) is not refused as another type")
    needed = [one.name for one in NAMED[function] if one.default is one.empty or one.name in SIZED]
    given = {name: example(function, name) for name in needed} | {parameter: value}
    if function in SLOW or any(one is None for name, one in given.items() if name != parameter):
        return None
    try:
        return functions()[function](**given)
    except al.AllaniteError:
        raise
    except Exception as error:
        raise AssertionError(f"{function}({parameter}={value!r:.80})") from error


def outcome(take: Callable[[str, int], object], name: str, k: int) -> str:
    """What became of a case: taken, refused, or why it is a failure."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            take(name, k)
    except al.AllaniteError as error:
        return "refused" if 20 < len(str(error)) < 1000 else f"words\n{error}"
    except Exception:
        return "traceback\n" + traceback.format_exc(limit=-4)
    return "taken"


def main() -> None:
    """Make the table."""
    warnings.simplefilter("error", RuntimeWarning)
    run = begin(__doc__, texts=1000, streams=200, calls=10_000, first=0)
    asked = run.asked
    kinds = {
        "manifest.csv": Kind(asked.texts, taken(MANIFEST, manifest_of)),
        "manifest.txt": Kind(asked.texts, taken(LIST, manifest_of)),
        "recipe.toml": Kind(asked.texts, taken(RECIPE, al.Recipe.load)),
        "stream": Kind(asked.streams, watched, 10.0),
        "call": Kind(asked.calls, called),
    }
    rows, wrong = [], 0
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        tempfile.tempdir = folder  # what a stream keeps goes with it
        for name, kind in kinds.items():
            counts, slowest = Counter[str](), 0.0
            for k in range(asked.first, asked.first + kind.cases):
                start = time.process_time()
                said = outcome(kind.take, name, k)
                took = time.process_time() - start if k > asked.first else 0.0  # the first one compiles
                slowest = max(slowest, took)
                good = said in {"taken", "refused"} and took <= kind.seconds
                counts[said if good else "failure"] += 1
                if not good:
                    print(f"{name}, case {k}: {took:.1f} s, {said}", file=sys.stderr, flush=True)
            wrong += counts["failure"]
            cells = (name, kind.cases, counts["taken"], counts["refused"], counts["failure"], f"{1000 * slowest:.0f}")
            rows.append(tuple(map(str, cells)))
        tempfile.tempdir = None
    notes = ("case k of a kind has the seed (crc32 of its name, k)", f"failures: {wrong}")
    headings = ("kind", "cases", "taken", "refused", "failures", "slowest ms")
    run.publish("What is handed over", notes, markdown(headings, rows))
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
