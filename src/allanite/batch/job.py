"""The job: analyze every file, and go on where one cannot be read."""

import os
from collections.abc import Iterable, Sequence

from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.version import __version__
from allanite.phrases.phrase import Phrase
from allanite.study.analysis import analyzed, demand_shown
from allanite.study.channels import Progress
from allanite.study.recipe import Recipe
from allanite.study.results import Study

from .batch import Batch, BatchUnit, lightened
from .judgement import judge_study
from .sources import PathLike, expand
from .specification import Specification


def analyze_files(
    files: PathLike | Sequence[PathLike],
    recipe: Recipe | None = None,
    *,
    limits: Specification | PathLike | None = None,
    besides: Iterable[str | None] = (),
    progress: Progress | None = None,
) -> Batch:
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
    >>> from allanite.core.model import N
    >>> from allanite.readers import write
    >>> from allanite.simulation.record import simulate
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
    wanted = limits if limits is None or isinstance(limits, Specification) else Specification.load(limits)
    path = limits if isinstance(limits, (str, os.PathLike)) else None
    sources = expand(named, (*besides, None if path is None else os.fspath(path)))
    tell = progress or (lambda what, fraction: None)
    units, errors = [], []
    for i, file in enumerate(sources.files):
        try:
            study = analyzed(file, recipe, progress=_part(tell, i, sources.files))
        except AllaniteError as error:
            errors.append(error)
            units.append(BatchUnit(file, error=reason_of(error, file), judged=wanted is not None))
        else:
            units.append(_unit(file, study, wanted))
    _demand_one(units, errors)
    demand_shown(recipe, (channel for unit in units for channel in unit.channels))
    return Batch(tuple(units), recipe.to_dict(), recipe.level, wanted, sources.notes, {"allanite": __version__})


def reason_of(error: AllaniteError, file: str) -> str:
    """The message of an error without the name of the file, which is shown beside it."""
    message, before = str(error), f"{file}: "
    if isinstance(message, Phrase) and message.startswith(before) and message.fields.get("_0") == file:
        return str(message.fields["_1"])
    return message.removeprefix(before) if message.startswith(before) else message


def _unit(file: str, study: Study, wanted: Specification | None) -> BatchUnit:
    judgements = () if wanted is None else judge_study(study, wanted)
    return BatchUnit(file, lightened(study), judgements, judged=wanted is not None)


def _part(tell: Progress, i: int, files: Sequence[str]) -> Progress:
    """Progress of one file as part of the whole."""
    return lambda what, fraction: tell(f"{i + 1} of {len(files)}, {files[i]}: {what}", (i + fraction) / len(files))


def _demand_one(units: Sequence[BatchUnit], errors: Sequence[AllaniteError]) -> None:
    """Raise what was found where no file gave a result."""
    if len(errors) < len(units):
        return
    kind = UsageError if all(isinstance(error, UsageError) for error in errors) else DataError
    if len(units) == 1:
        raise kind(f"{units[0].file}: {units[0].error}")
    files: dict[str, list[str]] = {}
    for unit in units:
        files.setdefault(unit.error, []).append(unit.file)
    reasons = (f"\n  {', '.join(which)}: {why}" for why, which in files.items())
    raise kind(f"none of the {len(units)} files could be analyzed:" + "".join(reasons))
