"""The job of many records: what is missing in a folder of results is analyzed, stored, and put together as tables."""

import os
from collections.abc import Iterable
from dataclasses import replace

from allanite.core.errors import AllaniteError, UsageError
from allanite.core.threads import one_thread
from allanite.core.version import __version__
from allanite.phrases.wording import command_line
from allanite.study.analysis import analyzed
from allanite.study.channels import Progress
from allanite.study.recipe import Recipe

from .batch import lightened
from .executor import Done, Executor, Plain, Serial
from .job import reason_of
from .manifest import Entry, manifest_of
from .sources import PathLike
from .status import DONE, FAILED, OPEN, FileStatus, Resumed, put_files, put_tables
from .store import Store, identity


def run_batch(
    source: PathLike,
    results: PathLike,
    recipe: Recipe | None = None,
    *,
    executor: Executor | None = None,
    besides: Iterable[str | None] = (),
    progress: Progress | None = None,
) -> Resumed:
    """Analyze many records, and store each result at once; a run that was interrupted is continued.

    Parameters
    ----------
    source : path
        A folder, a pattern, or a manifest; see `manifest_of`.
    results : path
        The folder of results, new or of an earlier run. What it holds for the same content, recipe and version is not
        done again.
    recipe : Recipe, optional
        All choices, the same for each file.
    executor : Executor, optional
        `Serial` by default; `Processes` and `Dask` give the same numbers.
    besides : iterable of path or None
        Files of a folder that are not recordings.
    progress : callable, optional
        Called with the last file and the completed fraction.

    Returns
    -------
    Resumed
        A file that cannot be analyzed carries the reason; the others are analyzed all the same. The folder holds
        ``files.parquet``, ``coefficients.parquet``, ``curves.parquet`` and ``findings.parquet``.

    Raises
    ------
    DataError
        No file is found.
    UsageError
        The manifest is wrong, the folder of results cannot be used or another run writes to it, or its disk is full:
        what is stored is kept.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from allanite.core.model import N
    >>> from allanite.readers import write
    >>> from allanite.simulation.record import simulate
    >>> folder = tempfile.TemporaryDirectory()
    >>> write(simulate(N(0.1, "deg/sqrt(h)"), 2000, 10.0, rng=np.random.default_rng(0)), Path(folder.name, "a.csv"))
    >>> results = Path(folder.name, "results")
    >>> [run_batch(folder.name, results).analyzed for _ in range(2)]
    [1, 0]
    >>> folder.cleanup()
    """
    choices = (recipe or Recipe()).to_dict()
    found = manifest_of(source, besides)
    store = Store.opened(results, new=True)
    tell = progress or (lambda what, fraction: None)
    with store.alone():
        files = {entry.file: _known(entry, choices, store, tell) for entry in found.entries}
        put_files(store, files.values(), choices)
        before = sum(file.status == DONE for file in files.values())
        missing = _missing(files.values(), choices)
        _analyze(missing, files, store, executor or Serial(), tell)
        ended = tuple(put_tables(store, files.values()))
        put_files(store, ended, choices)
    return Resumed(ended, len(missing), before, found.notes)


def _analyze(
    missing: list[Plain], files: dict[str, FileStatus], store: Store, executor: Executor, tell: Progress
) -> None:
    """Store the results that are missing, and mark the files that they belong to."""
    named: dict[str, list[str]] = {}
    for file in files.values():
        named.setdefault(file.key, []).append(file.file)
    wrong = []
    for i, done in enumerate(executor.run(analyze_plainly, missing), 1):
        error = _kept(done, store)
        wrong += [error] if done.result and done.result.get("usage") else []
        for name in named[done.item["key"]]:
            files[name] = replace(files[name], status=FAILED if error else DONE, error=error)
        tell(f"{i} of {len(missing)}, {done.item['file']}", i / len(missing))
    if wrong and all(file.error in wrong for file in files.values()):
        raise UsageError(f"none of the {len(files)} files could be analyzed: {wrong[0]}")


def analyze_plainly(item: Plain) -> Plain:
    """The study of a file as plain data without its name, or the error: the task that executors are given."""
    file = item["file"]
    try:
        # what is stored does not depend on who started it, nor on which process it ran in
        with command_line(), one_thread():
            study = analyzed(file, Recipe.from_dict(item["choices"]))
            found = lightened(replace(study, provenance=study.provenance | {"source": ""}))
            return {"study": found.to_dict(), "rejected": ", ".join(study.rejected), "allanite": __version__}
    except AllaniteError as error:
        # a missing library, for example, may be there the next time
        return {"error": reason_of(error, file), "usage": isinstance(error, UsageError), "allanite": __version__}


def _known(entry: Entry, choices: Plain, store: Store, tell: Progress) -> FileStatus:
    """What is known of a file before anything is analyzed."""
    tell(f"looking at {entry.file}", 0.0)
    try:
        digest, key = identity(entry.file, choices)
    except AllaniteError as error:
        return FileStatus(entry.file, entry.facts, status=FAILED, error=reason_of(error, entry.file))
    return FileStatus(entry.file, entry.facts, key, digest, DONE if store.has(key) else OPEN)


def _missing(files: Iterable[FileStatus], choices: Plain) -> list[Plain]:
    """The items to do: of files with the same content, one."""
    first = {file.key: file for file in reversed([*files]) if file.status == OPEN}
    wanted = sorted(first.values(), key=lambda file: file.file)
    return [{"file": os.path.abspath(f.file), "key": f.key, "sha256": f.sha256, "choices": choices} for f in wanted]


def _kept(done: Done, store: Store) -> str:
    """Store a result; the reason if there is none, which is not stored where another run may find otherwise."""
    result = done.result or {}
    error: str = done.error or _unfit(done) or (result["error"] if result.get("usage") else "")
    if not error:
        store.put(done.item["key"], result)
    return error


def _unfit(done: Done) -> str:
    """Why a result is not that of this file and this version; empty if it is."""
    result = done.result or {}
    if result.get("allanite") != __version__:
        return f"it was analyzed by version {result.get('allanite')}, not {__version__}; install the same everywhere"
    digest = result.get("study", {}).get("provenance", {}).get("sha256") or done.item["sha256"]
    changed = digest != done.item["sha256"]
    return "the file changed while the batch was running; run the batch again" if changed else ""
