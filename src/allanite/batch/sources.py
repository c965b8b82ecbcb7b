"""Which files are meant: paths, folders and patterns become a list of files."""

import glob
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from allanite.core.errors import DataError
from allanite.phrases.phrase import say
from allanite.readers.sandbox.packing import PROSE
from allanite.readers.sandbox.source import STDIN, is_recording

PathLike = str | os.PathLike[str]


@dataclass(frozen=True)
class Sources:
    """Files in the order in which they were named, and what was left out of folders, in `notes`."""

    files: tuple[str, ...]
    notes: tuple[str, ...] = ()


def several(named: Sequence[PathLike]) -> bool:
    """Whether these names ask for many units: more than one, a folder that is not a ROS bag, or a pattern.

    Examples
    --------
    >>> several(["gyro.csv"]), several(["-"]), several(["a.csv", "b.csv"]), several(["units/*.csv"])
    (False, False, True, True)
    """
    return len(named) != 1 or (
        not is_recording(named[0]) and (os.path.isdir(named[0]) or _is_pattern(os.fspath(named[0])))
    )


def expand(named: Sequence[PathLike], besides: Iterable[str | None] = ()) -> Sources:
    """The files that are meant by these names.

    Parameters
    ----------
    named : sequence of str or path
        A file, ``"-"`` for standard input, a folder (the files in it, in the order of their names, but not those of
        folders inside it), or a pattern such as ``"units/*.csv"`` (``**`` goes through folders). A file that is named
        twice is taken once. The folder of a ROS 2 bag counts as a file.
    besides : iterable of path or None
        Files that are not recordings: those that will be written, and settings.

    Returns
    -------
    Sources

    Raises
    ------
    DataError
        A folder cannot be read or holds no recording, or no file matches a pattern.
    """
    left = {os.path.realpath(path) for path in besides if path is not None}
    found: dict[str, str] = {}
    notes: list[str] = []
    for name in [os.fspath(path) for path in named]:
        files: Sequence[str] = [name]
        if os.path.isdir(name) and not is_recording(name):
            files = _in_folder(name, left, notes)
        elif name != STDIN and _is_pattern(name):
            every = [file for file in sorted(glob.glob(name, recursive=True)) if is_recording(file)]
            files = [file for file in every if os.path.realpath(file) not in left]
            if not files:
                raise DataError(f"no file matches {name!r}; check the folder, and the pattern")
        for file in files:
            found.setdefault(file if file == STDIN else os.path.realpath(file), file)
    return Sources(tuple(found.values()), tuple(notes))


def _in_folder(folder: str, left: set[str], notes: list[str]) -> Sequence[str]:
    try:
        inside = sorted(str(path) for path in Path(folder).iterdir() if is_recording(path) and path.name[0] != ".")
    except OSError as error:
        raise DataError(f"the directory {folder!r} cannot be read ({error.strerror or error})") from None
    prose = {file for file in inside if PROSE.search(os.path.basename(file))}
    files = [file for file in inside if file not in prose and os.path.realpath(file) not in left]
    if not files:
        raise DataError(f"the directory {folder!r} holds no recording; name its files, or a pattern such as '**/*.csv'")
    other = [os.path.basename(file) for file in inside if file not in files]
    if other:
        shown = ", ".join(other[:5]) + (" ..." if len(other) > 5 else "")
        notes.append(say("left out of {folder}, by their names not recordings: {files}", folder=folder, files=shown))
    return files


def _is_pattern(name: str) -> bool:
    """Whether a name is a pattern, and not that of a file which happens to have such letters."""
    return glob.has_magic(name) and not os.path.exists(name)
