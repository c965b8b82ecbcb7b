"""What verbs do, as functions of files, a recipe and settings: the command line and the page call the same ones."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from allanite.core.errors import UsageError
from allanite.phrases.phrase import say

from .deliver import carry_out, outputs, recipe_of, settings_of
from .front import DATA, EXCEEDED, PARTLY
from .streams import stopping

if TYPE_CHECKING:
    from allanite.batch.batch import Batch
    from allanite.study.channels import Progress, Source
    from allanite.study.recipe import Recipe


@dataclass(frozen=True)
class Reports:
    """What hears of a job while it runs: how far it is, what happens in a stream, and what is analyzed of a file."""

    tell: "Progress" = lambda what, fraction: None
    event: Callable[[str, Any], None] = lambda words, watch: None
    # the recording of a file, if it is in memory
    source: "Callable[[str, Recipe], Source]" = lambda file, recipe: file
    deliver: Callable[[Any], None] = lambda result: None  # what is done with the result before the lines of a stream go


@dataclass(frozen=True)
class VerbTask:
    """What a verb does, beside its command in the row of `VERBS`."""

    run: "Callable[[Sequence[str], Recipe, Any, Reports], Any]"
    # the class of the settings; or module in `allanite` and name of it; empty if there are none
    settings: str | type[Any] = ""
    usual: Mapping[str, Any] = field(default_factory=dict)  # defaults of the recipe that are not its own
    code: Callable[[Any], int] = lambda result: 0  # the exit code, unless it is strict
    most: int | None = 1  # number of files at most

    @property
    def kind(self) -> type[Any] | None:
        """The class of the settings, imported now."""
        if not isinstance(self.settings, str):
            return self.settings
        module, _, name = self.settings.rpartition(".")
        return getattr(import_module(f"allanite.{module}"), name) if name else None


def perform(task: VerbTask, files: Sequence[str], choices: dict[str, Any]) -> Any:
    """Do a task with the options given, and deliver the result."""
    out = outputs(choices, [*files, choices["recipe"]])
    settings = settings_of(task.kind, choices) if task.kind else None
    recipe = recipe_of(choices, **task.usual)
    return carry_out(lambda tell: task.run(files, recipe, settings, Reports(tell)), out)


def _info(files: Sequence[str], recipe: "Recipe", _: Any, reports: Reports) -> Any:
    from allanite.study.analysis import examine

    return examine(reports.source(files[0], recipe), recipe, progress=reports.tell)


def _analyze(files: Sequence[str], recipe: "Recipe", _: Any, reports: Reports) -> Any:
    from allanite.batch.sources import several
    from allanite.study.analysis import analyze

    if several(files):
        from allanite.batch.job import analyze_files

        return analyze_files(files, recipe, opened=lambda file: reports.source(file, recipe), progress=reports.tell)
    return analyze(reports.source(files[0], recipe), recipe, progress=reports.tell)


def _survey(files: Sequence[str], recipe: "Recipe", settings: Any, reports: Reports) -> Any:
    from allanite.study.survey import side_by_side, survey

    surveys = [survey(reports.source(file, recipe), settings, recipe, progress=reports.tell) for file in files]
    return side_by_side(surveys, files)


def _compare(files: Sequence[str], recipe: "Recipe", settings: Any, reports: Reports) -> Any:
    from allanite.comparison import comparing
    from allanite.comparison.sheet import compare_with_sheet

    against, part, count = settings.against, settings.part, len(files)
    for choice, wrong, words in (
        ("part", part is not None and count > 1, f"splits a single file, but {count} files were given"),
        ("against", against is not None and count != 2,
         f"names channels of the second of two files, but {count} files were given"),
        ("pool", settings.pool and count == 1, "needs two files or more, but one was given"),
        ("datasheet", settings.datasheet is not None and (count > 1 or part is not None),
         "compares a single file with a data sheet; give one file, without --part"),
    ):  # fmt: skip
        if wrong:
            raise UsageError(f"--{choice} {words}", choice=choice)
    sources = [reports.source(file, recipe) for file in files]
    if settings.datasheet is not None:
        return compare_with_sheet(sources[0], settings.datasheet, recipe, progress=reports.tell)
    if part is not None:
        return comparing.truncation(sources[0], part, recipe, progress=reports.tell)
    if count == 1:
        return comparing.compare_channels(sources[0], recipe, progress=reports.tell)
    if count == 2 and not settings.pool:
        return comparing.compare(sources[0], sources[1], recipe, against=against, progress=reports.tell)
    return comparing.pool(sources, recipe, progress=reports.tell)


def _watch(files: Sequence[str], recipe: "Recipe", settings: Any, reports: Reports) -> Any:
    from allanite.study.watching import Watch

    watch = Watch(files[0], recipe, settings)
    with watch.keeping(lambda words: reports.event(words, watch)):
        with stopping() as watch.stopped:
            for words in watch.events():
                reports.event(words, watch)
            if watch.stopped():
                reports.event(say("the results are computed; interrupt again to end without them"), watch)
            study = watch.study()
        reports.deliver(study)
    return study


def ends_of_units(batch: "Batch", *, strict: bool = False) -> list[tuple[int, str]]:
    """The exit codes of what was found in many units, and the words for it; the worst comes first."""
    ends = ((EXCEEDED, batch.exceeding, "a limit is exceeded"), (PARTLY, batch.failed, "not analyzed"),
            (DATA, batch.rejected if strict else (), "not explained, or a limit is not decided"))  # fmt: skip
    return [(code, f"{what}: {', '.join(units)}") for code, units, what in ends if units]


INFO = VerbTask(_info, code=lambda study: DATA if all(channel.refusal for channel in study.channels) else 0)
ANALYZE = VerbTask(_analyze, code=lambda result: next((code for code, _ in ends_of_units(result)),
                                                      0) if hasattr(result, "exceeding") else 0, most=None)  # fmt: skip
DEVIATION = VerbTask(_survey, "study.survey.Deviations", most=None)
SPECTRUM = VerbTask(_survey, "study.survey.Densities", most=None)
DYNAMIC = VerbTask(_survey, "study.survey.Windows")
COMPARE = VerbTask(_compare, "comparison.comparison.ComparisonSettings", {"taus": "octave"}, most=None)
WATCH = VerbTask(_watch, "study.watching.WatchSettings")
