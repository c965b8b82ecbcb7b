"""The job of many files: each is analyzed, or its error is kept, in memory or in a folder of results."""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from allanite.core.aliases import public
from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.threads import one_thread
from allanite.core.version import __version__
from allanite.phrases.phrase import Phrase, command_line, say
from allanite.study.analysis import analyzed, demand_shown
from allanite.study.channels import Progress, Source
from allanite.study.recipe import Recipe

from .batch import Batch, BatchUnit, lightened, unit_of
from .executor import Done, Executor, Plain, Serial
from .sources import PathLike, expand, manifest_of
from .specification import Specification, limits_of
from .store import Store, identity
from .tables import DONE, FAILED, OPEN, FileStatus, Resumed, put_files, put_tables


@public
def analyze_files(
    files: PathLike | Sequence[PathLike], recipe: Recipe | None = None, *,
    limits: Specification | PathLike | None = None, besides: Iterable[str | None] = (),
    opened: Callable[[str], Source] = str, progress: Progress | None = None,
) -> Batch:  # fmt: skip
    """The noise coefficients of many units, and whether they keep their limits.

    Parameters
    ----------
    files : path, or sequence of paths
        Files, folders, and patterns such as ``"units/*.csv"``; ``"-"`` is standard input.
    recipe : Recipe, optional
        All choices, the same for each file.
    limits : Specification or path, optional
        What the coefficients must not exceed; see `Specification` for the rule, and for the TOML file.
    besides : iterable of path
        Files in the folders that are not recordings.
    opened : callable, optional
        Gives for a file what is analyzed: its recording, if that is in memory.
    progress : callable, optional
        Called with the current step and the completed fraction.

    Returns
    -------
    Batch
        A file that cannot be analyzed carries the reason in `BatchUnit.error`; the others are analyzed all the same.

    Raises
    ------
    DataError
        No file is found, or none of them can be analyzed.
    UsageError
        An option is wrong, or a limit of a channel does not fit its kind of sensor.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from allanite import N, simulate, write
    >>> folder = tempfile.TemporaryDirectory()
    >>> for i, size in enumerate((0.1, 0.2)):
    ...     record = simulate(N(size, "deg/sqrt(h)"), 4096, 10.0, rng=np.random.default_rng(i))
    ...     write(record, Path(folder.name, f"unit{i}.csv"))
    >>> spec = Specification.from_toml({"limits": {"N": {"max": "0.15 deg/sqrt(h)"}}})
    >>> batch = analyze_files(folder.name, limits=spec)
    >>> [unit.outcome for unit in batch]
    ['pass', 'fail']
    >>> folder.cleanup()
    """
    recipe = recipe or Recipe()
    named = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    specification = limits_of(limits)
    path = os.fspath(limits) if isinstance(limits, (str, os.PathLike)) else None
    sources = expand(named, (*besides, path))
    tell = progress or (lambda what, fraction: None)

    def step(i: int) -> Progress:
        before = f"{i + 1} of {len(sources.files)}, {sources.files[i]}"
        return lambda what, fraction: tell(f"{before}: {what}", (i + fraction) / len(sources.files))

    units, errors = list[BatchUnit](), list[AllaniteError]()
    for i, file in enumerate(sources.files):
        try:
            study = analyzed(opened(file), recipe, progress=step(i))
        except AllaniteError as error:
            errors.append(error)
            units.append(BatchUnit(file, error=reason_of(error, file), judged=specification is not None))
        else:
            units.append(unit_of(file, lightened(study, samples=len(sources.files) == 1), specification))
    if len(errors) == len(units):
        kind = UsageError if all(isinstance(error, UsageError) for error in errors) else DataError
        message, *more = _reasons(units)
        raise kind(message, more=tuple(more))
    demand_shown(recipe, (channel.record.signal for unit in units for channel in unit.channels))
    return Batch(tuple(units), recipe.to_dict(), recipe.level, specification, sources.notes, {"allanite": __version__})


def _reasons(units: Sequence[BatchUnit]) -> list[str]:
    """Why no file gave a result, in lines."""
    if len(units) == 1:
        return [f"{units[0].file}: {units[0].error}"]
    files: dict[str, list[str]] = {}
    for unit in units:
        files.setdefault(unit.error, []).append(unit.file)
    reasons = (f"{', '.join(which)}: {why}" for why, which in files.items())
    return [f"none of the {len(units)} files could be analyzed:", *reasons]


@public
def run_batch(
    source: PathLike, results: PathLike, recipe: Recipe | None = None, *, executor: Executor | None = None,
    besides: Iterable[str | None] = (), progress: Progress | None = None,
) -> Resumed:  # fmt: skip
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
    >>> from allanite import Record, write
    >>> folder = tempfile.TemporaryDirectory()
    >>> write(Record(np.random.default_rng(0).normal(size=2000), 10.0, "deg/h"), f"{folder.name}/a.csv")
    >>> [run_batch(folder.name, f"{folder.name}/results").analyzed for _ in range(2)]
    [1, 0]
    >>> folder.cleanup()
    """
    choices = (recipe or Recipe()).to_dict()
    sources = manifest_of(source, besides)
    store = Store.opened(results, new=True)
    tell = progress or (lambda what, fraction: None)
    with store.alone():
        files, notes = dict[str, FileStatus](), list(sources.notes)
        for file in sources.files:
            tell(f"looking at {file}", 0.0)
            status = FileStatus(file, sources.facts.get(file, {}))
            try:
                digest, key = identity(file, choices)
                status = replace(status, key=key, sha256=digest, status=DONE if store.has(key) else OPEN)
                if status.status == OPEN and store.part(key).exists():
                    notes.append(say("the stored result of {file} is damaged, and is made again", file=file))
            except AllaniteError as error:
                status = replace(status, status=FAILED, error=reason_of(error, file))
            files[file] = status
        put_files(store, files.values(), choices)
        before = sum(file.status == DONE for file in files.values())
        analyzed_now = _complete(files, choices, store, executor or Serial(), tell)
        ended = tuple(put_tables(store, files.values()))
        put_files(store, ended, choices)
    return Resumed(ended, analyzed_now, before, tuple(notes))


def _complete(files: dict[str, FileStatus], choices: Plain, store: Store, executor: Executor, tell: Progress) -> int:
    """Store the results that are missing, mark the files that they belong to, and count the results."""
    same: dict[str, list[FileStatus]] = {}
    for file in files.values():
        same.setdefault(file.key, []).append(file)
    missing: list[Plain] = [{"file": os.path.abspath(first.file),
                             "key": key, "sha256": first.sha256, "choices": choices}
                            for key, (first, *_) in same.items() if first.status == OPEN]  # fmt: skip
    wrong = []
    for i, done in enumerate(executor.run(analyze_plainly, missing), 1):
        result = done.result or {}
        error: str = done.error or _unfit(done) or (result["error"] if result.get("usage") else "")
        if not error:  # what another run may find otherwise is not stored
            store.put(done.item["key"], result)
        wrong += [error] if result.get("usage") else []
        for file in same[done.item["key"]]:
            files[file.file] = replace(file, status=FAILED if error else DONE, error=error)
        tell(f"{i} of {len(missing)}, {done.item['file']}", i / len(missing))
    if wrong and all(file.error in wrong for file in files.values()):
        raise UsageError(f"none of the {len(files)} files could be analyzed: {wrong[0]}")
    return len(missing)


def analyze_plainly(item: Plain) -> Plain:
    """The study of a file as plain data without its name, or the error: the task that executors are given."""
    try:
        with command_line(), one_thread():  # what is stored does not depend on who started it, nor on the process
            study = analyzed(item["file"], Recipe.from_dict(item["choices"]))
            unnamed = lightened(replace(study, provenance=study.provenance | {"source": ""}))
            return {"study": unnamed.to_dict(), "rejected": ", ".join(study.rejected), "allanite": __version__}
    except AllaniteError as error:
        # a missing library, for example, may be there the next time
        usage = isinstance(error, UsageError)
        return {"error": reason_of(error, item["file"]), "usage": usage, "allanite": __version__}


def reason_of(error: AllaniteError, file: str) -> str:
    """The message of an error without the name of the file, which is shown beside it."""
    message, before = error.message, f"{file}: "
    if isinstance(message, Phrase) and message.startswith(before) and message.fields.get("_0") == file:
        message = str(message.fields["_1"])
    return message.removeprefix(before)


def _unfit(done: Done) -> str:
    """Why a result is not that of this file and this version; empty if it is."""
    result = done.result or {}
    if result.get("allanite") != __version__:
        return f"it was analyzed by version {result.get('allanite')}, not {__version__}; install the same everywhere"
    digest = result.get("study", {}).get("provenance", {}).get("sha256") or done.item["sha256"]
    changed = digest != done.item["sha256"]
    return "the file changed while the batch was running; run the batch again" if changed else ""
