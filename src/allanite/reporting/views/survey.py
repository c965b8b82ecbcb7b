"""How the statistics of every channel of a file are shown."""

from collections.abc import Sequence

from allanite.core.fit import Fit
from allanite.phrases.phrase import join, say
from allanite.reporting.first import First
from allanite.reporting.sheet import Drawing, Face, Plot
from allanite.study.survey import Survey

from . import view
from .channels import how_read, title_of
from .jobs import alerts, channel_sheet, doubts, job_face, source_of
from .values import BRAND, FORMS, numbers_table, rows_of, tables_of


def first_of_survey(survey: Survey, level: float) -> First:
    """The values of every channel, at averaging times or frequencies that are spread evenly."""
    after = [("--plot curve.png", say("figure")), ("--csv FILE", say("all values")), ("--details", say("edf"))]
    answer = list(tables_of(survey.values, level))
    return First(title_of(survey), "", answer, [*doubts(survey.channels), *alerts(survey)], (), how_read(survey), after)


def _plot_survey(values: Sequence[Survey], fit: Fit | None, level: float) -> Plot:
    shown = [value for survey in values for value in survey.values]
    fits = {name: each for survey in values for name, each in survey.fits.items()}
    return FORMS[type(shown[0])].plot(shown, fits, level)


@view(_plot_survey, lambda survey, level: rows_of(survey.values, level), first=first_of_survey)
def survey_view(survey: Survey, level: float) -> Face:
    """The statistics of each channel."""
    sheets = [channel_sheet(c, [numbers_table(value, level) for value in c.values]) for c in survey]
    names = ", ".join(dict.fromkeys(value.name for value in survey.values if value.name))
    titles = join("; ", dict.fromkeys(FORMS[type(value)].title(value) for value in survey.values))
    drawing = Drawing(lambda: _plot_survey([survey], None, level),
        say("{titles}, of {channels}", titles=titles, channels=names) if names else titles)  # fmt: skip
    return job_face(survey, (source_of(survey), BRAND), sheets, [drawing])
