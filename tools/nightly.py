"""Run everything that is tested, in parts, and keep a table of when each part ran last and how it ended.

    python tools/nightly.py [--write tests/nightly.md] [PART ...]

Without names: all parts, one after the other, which takes hours; the rows of parts that are not run stay as they are.
`make nightly` does this on a clean checkout. Ends with exit code 1 if a part has failed.
"""

import argparse
import os
import re
import subprocess
import sys
import time
from datetime import UTC, date, datetime
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "tests" / "nightly.md"
PYTEST = "pytest -n auto --dist worksteal -q"
TABLES = "tests/conformance/*table*.py"
FUZZ = "benchmarks/fuzz.py --first {night} --targets"
LANGUAGES, SITE = "tests/stories/test_languages.py", "tests/stories/test_site.py"

PARTS = {
    "all examples": f"{PYTEST} tests -m 'hypothesis and not ensemble'",
    "long ensembles": f"{PYTEST} tests -m ensemble",
    "rooms": f"{PYTEST} tests/unit tests/anchors -m 'not (hypothesis or ensemble)'",
    "recordings": f"{PYTEST} tests/recordings",
    "grids": f"{PYTEST} tests/conformance --ignore-glob={TABLES} -m 'not (hypothesis or ensemble)'",
    "committed tables": f"{PYTEST} {TABLES} tests/stories/test_numbers.py",
    "stories": f"{PYTEST} tests/stories --ignore={LANGUAGES} --ignore={SITE}",
    "languages": f"{PYTEST} {LANGUAGES}",
    "site": f"{PYTEST} {SITE}",
    "browser": f"{PYTEST} tests/web",
    "grid of tables": "benchmarks/grid.py again --share 0.02",
    "fuzz: files": f"{FUZZ} files --share 0.1",
    "fuzz: records": f"{FUZZ} records --share 0.2",
    "fuzz: results": f"{FUZZ} results --share 0.1",
    "fuzz: inputs": f"{FUZZ} inputs --share 0.2",
    "fuzz: page": f"{FUZZ} page --share 0.2",
}
"""What is run, from the root of the project: arguments of `python -m`, or a script with its own.

A part of a table is made again by its script, which takes new seeds each night and fails with the figures that have
moved by more than their error. {night} begins seeds that no other night has.
"""

SEEDS_A_NIGHT = 100_000  # more than a part of the fuzz takes

HEAD = """# Nightly

Everything that is tested, in parts: what ran last, with all examples, records and rows (`ALLANITE_TESTS=all`).

- command: `make nightly`

| part | command | result | minutes | commit | date |
|---|---|---|---|---|---|
"""


def words(command: str) -> list[str]:
    """The words of a command, with the seeds of tonight and the names that a pattern stands for."""
    command = command.replace("{night}", str(date.today().toordinal() * SEEDS_A_NIGHT))
    kept = [word for pair in re.findall(r"'([^']*)'|(\S+)", command) for word in pair if word]
    expanded = [[str(path.relative_to(ROOT)) for path in sorted(ROOT.glob(word))] or [word] for word in kept[1:]]
    module = ["-m", kept[0]] if not kept[0].endswith(".py") else [kept[0]]
    return [sys.executable, *module, *(word for part in expanded for word in part)]


def result(output: str, code: int) -> str:
    """How a part has ended: the counts that pytest prints last, or the exit code."""
    counts = re.findall(r"\d+ (?:failed|passed|skipped|xfailed|errors?)\b", (output.splitlines() or [""])[-1])
    return ", ".join(counts) or ("passed" if code == 0 else f"failed, exit code {code}")


def run(part: str, commit: str) -> tuple[str, int]:
    """Run a part: its row of the table, and its exit code."""
    print(f"== {part}: {PARTS[part]}", flush=True)
    begun = time.monotonic()
    single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.Popen(  # noqa: S603 - our own
        words(PARTS[part]), cwd=ROOT, env=os.environ | single | {"ALLANITE_TESTS": "all"}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    output = ""
    for line in done.stdout or ():
        print(line, end="", flush=True)
        output = (output + line)[-10_000:]
    code, minutes = done.wait(), (time.monotonic() - begun) / 60
    ended = result(output.strip(), code)
    cells = (part, f"`{PARTS[part]}`", ended, f"{minutes:.0f}", commit, f"{datetime.now(UTC):%Y-%m-%d}")
    return "| " + " | ".join(cells) + " |", code


def kept(page: Path) -> dict[str, str]:
    """The rows of a page, by their part."""
    lines = page.read_text("utf-8").splitlines() if page.exists() else []
    return {line.split(" | ")[0].removeprefix("| "): line for line in lines if line.startswith("| ")}


def main() -> int:
    """Run the parts that are asked for; each row is written when its part has ended."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--write", type=Path, default=PAGE)
    options = parser.parse_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; the parts are {', '.join(PARTS)}")
    git = ("git", "-C", str(ROOT), "rev-parse", "--short=7", "HEAD")
    commit = subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()  # noqa: S603
    rows, failed = kept(options.write), False
    for part in options.parts or PARTS:
        rows[part], code = run(part, commit)
        failed |= code != 0
        options.write.write_text(HEAD + "".join(f"{rows[name]}\n" for name in PARTS if name in rows), "utf-8")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
