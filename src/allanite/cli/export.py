"""From identified noise to the file of a filter, from a value to its field, and what fields and statistics mean."""

import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import click

from allanite.core.errors import UsageError
from allanite.study.settings import ExportChoices, LengthChoices, NoiseChoices

from .deliver import Extra, carry_out, outputs, recipe_of, settings_of
from .helping import command
from .options import IDENTIFYING, RECORDING, SHOWN, options

FILE = ("written file", "plot", "json", *SHOWN)

USUAL = "datasheet"  # the target where none is named


@command()
@options("some files", "target", "axis", "inflate", "cover", "filter_rate", "models", "datasheet", "unexplained",
         "from_curve", *RECORDING, *IDENTIFYING, *FILE, settings=(NoiseChoices, ExportChoices))  # fmt: skip
def export(files: tuple[str, ...], target: str | None, models: tuple[str, ...], datasheet: str | None,
           **choices: Any) -> None:  # fmt: skip
    """Write the noise as a file of a filter.

    FILES are recordings, or results that analyze has written with --json, for example of a gyro and of an
    accelerometer. Without --output, the fields are printed. A coefficient that was not identified is written as its
    upper limit, and the file says so. 'allanite explain' lists the targets.
    """
    from allanite.exporting.export import exported, prepared
    from allanite.exporting.fields import How
    from allanite.exporting.imported import load

    models = (*models, datasheet) if datasheet else models
    if not files and not models:
        raise UsageError("give a recording, a result of analyze in JSON, or the noise with --model or --datasheet")
    out = outputs(choices, [*files, choices["recipe"]], also=("output",))
    how = settings_of(How, dict(choices))
    row, suffix = prepared(target or USUAL, how, _suffix(out.paths))
    recipe = recipe_of(choices)
    carry_out(lambda tell: exported(row, load(files, recipe, models, tell), how, suffix), out, _EXTRA)


@command()
@options(click.argument("values", nargs=-1, required=True, metavar="VALUE..."), "target", "origin", "rate", "axis",
         "inflate", "cover", *FILE, settings=(ExportChoices,))  # fmt: skip
def convert(values: tuple[str, ...], target: str | None, origin: str | None, **choices: Any) -> None:
    """Convert values of a data sheet to fields.

    VALUE is a value with its unit ('0.66 deg/sqrt(h)', '100 ug/sqrt(Hz)'), a model ('N 0.66 deg/sqrt(h), K 3
    deg/h/sqrt(h)') or the name of a data sheet (adis16470). --to names the target, by default the units of data sheets.
    With --file-of, VALUE is a file of that target, whose coefficients are printed, or converted to --to.
    """
    from allanite.exporting.export import exported, prepared
    from allanite.exporting.fields import How
    from allanite.exporting.imported import models_of, read_noise
    from allanite.reporting.views.export import first_of_models

    out = outputs(choices, values if origin else [], also=("output",))
    rate = choices["rate"]
    read = [read_noise(value, origin, rate=rate) for value in values] if origin else []
    if origin and target is None:
        for noise in read:
            carry_out(lambda _, noise=noise: noise, out)  # type: ignore[misc]  # bound in the loop
        return
    stated = next((noise.rate for noise in read), None)
    how = settings_of(How, {**choices, "rate": rate or stated, "partial": "output" not in out.paths})
    row, suffix = prepared(target or USUAL, how, _suffix(out.paths))
    models = [model for noise in read for model in noise.models] if origin else models_of(values)
    extra = _EXTRA if target else replace(_EXTRA, first=lambda: first_of_models(models, () if origin else values))
    carry_out(lambda _: exported(row, models, how, suffix), out, extra)


_EXTRA = Extra(data={"output": lambda made: made.data})


def _suffix(paths: Mapping[str, str]) -> str:
    return os.path.splitext(paths.get("output", ""))[1]


@command()
@options(click.argument("name", required=False, default=""), "samples", "taus", "csv", "json", *SHOWN,
         settings=(LengthChoices,))  # fmt: skip
def explain(name: str, samples: int | None, taus: Any, **choices: Any) -> None:
    """Explain a word, target or data sheet.

    Of a noise term, a status, an abbreviation or another word, prints what it means, with a formula and an example; of
    a target of export, the fields with their units, formulas and sources; of a paper (stabilizer, laser, ...), how it
    is reproduced and applied to a recording; of a statistic, also its ratio to the Allan variance and its degrees of
    freedom for each noise, in a record of 7200 samples or of --samples, at averaging times in sampling intervals; of a
    data sheet, what it says of noise, and where. Without NAME, lists them.
    """
    from allanite.core.names import row_alike
    from allanite.exporting.exports import EXPORTS, TEMPERATURE
    from allanite.exporting.imported import Explanation
    from allanite.interpretation.glossary import Word, named_words
    from allanite.papers.paper import Paper, papers
    from allanite.planning.datasheets import DATASHEETS, DataSheet
    from allanite.planning.plan import SIZE, properties
    from allanite.statistics import STATISTICS
    from allanite.statistics.row import Statistic

    out = outputs(choices, [])
    thermal = {row.name: row for row in TEMPERATURE.values()}
    told = named_words()
    tables = {**papers(), **told, **STATISTICS, **EXPORTS, **thermal, **DATASHEETS}
    row: Any = row_alike("name", name, tables, lister="allanite explain") if name else None
    if isinstance(row, Statistic) and (row.name not in told or not (row.extreme or row.power)):
        carry_out(lambda _: properties(row.name, samples or SIZE, taus=taus), out)
        return
    if samples is not None or taus is not None:
        raise UsageError("--samples and --taus apply to a statistic; omit them, or name one: " + ", ".join(STATISTICS))
    shown = told[row.name] if isinstance(row, Statistic) else row
    if isinstance(row, Paper):
        shown = row.within(out.lang).word
    carry_out(lambda _: shown if isinstance(shown, (DataSheet, Word)) else Explanation(row.name if row else ""), out)
