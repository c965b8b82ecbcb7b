"""Name the tests of what has changed: those of the packages with changed files, and changed tests themselves.

    python tools/changed.py [COMMIT]

Compared with COMMIT, by default the last one, files that git does not know yet included.
"""

import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parents[1]
BESIDE = {
    "kernels": ("tests/conformance/test_kernels.py", "tests/unit/statistics"),
    "statistics": ("tests/conformance/test_statistics.py",),
    "terms": ("tests/conformance/test_noise_terms.py", "tests/unit/reporting/test_colors.py"),
}
"""Tests outside of the folder of a package: of all rows of its table, or of a package without a folder."""


def changed(commit: str) -> list[str]:
    """Paths of files that differ from a commit."""
    listed = (("diff", "--name-only", "--diff-filter=d", commit), ("ls-files", "--others", "--exclude-standard"))
    git = ("git", "-C", str(ROOT))
    return [
        name
        for words in listed
        for name in subprocess.run([*git, *words], capture_output=True, text=True, check=True).stdout.splitlines()  # noqa: S603
    ]


def selection(paths: Iterable[str], there: Path = ROOT) -> Iterator[str]:
    """The files and folders of tests that belong to files of the project.

    Examples
    --------
    >>> sorted(selection(["src/allanite/web/store.py", "tests/reference/allan.py"]))
    ['tests/conformance/test_statistics.py', 'tests/web']
    """
    for path in map(PurePosixPath, paths):
        match path.parts:
            case ("src", "allanite", room, _, *_):
                yield from BESIDE.get(room, ())
                yield from (f"tests/{kind}{room}" for kind in ("unit/", "") if (there / f"tests/{kind}{room}").is_dir())
            case ("tests", "reference", *_):
                yield from BESIDE["statistics"]
            case ("tests", *_, name) if name.startswith("test_"):
                yield str(path)
            case ("README.md",) | ("docs", *_):
                yield "tests/stories/test_docs.py"


if __name__ == "__main__":
    print(*dict.fromkeys(selection(changed(*sys.argv[1:] or ["HEAD"]))))
