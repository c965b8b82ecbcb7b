"""How the statistics of a recording are shown."""

from collections.abc import Sequence

from allanite.core.fit import Fit
from allanite.phrases.phrase import join, say
from allanite.reporting.sheet import Drawing, Face, Plot
from allanite.study.survey import Survey

from . import view
from .jobs import channel_sheet, job_face, source_of
from .numbers import first_of_survey
from .values import BRAND, FORMS, numbers_table, rows_of


def _plot(values: Sequence[Survey], fit: Fit | None, level: float) -> Plot:
    shown = [value for survey in values for value in survey.values]
    fits = {name: found for survey in values for name, found in survey.fits.items()}
    return FORMS[type(shown[0])].plot(shown, fits, level)


@view(_plot, lambda survey, level: rows_of(survey.values, level), first=first_of_survey)
def survey_view(survey: Survey, level: float) -> Face:
    """The statistics of each channel."""
    sheets = [channel_sheet(c, [numbers_table(value, level) for value in c.values]) for c in survey]
    names = ", ".join(dict.fromkeys(value.name for value in survey.values if value.name))
    titles = join("; ", dict.fromkeys(FORMS[type(value)].title(value) for value in survey.values))
    drawing = Drawing(
        lambda: _plot([survey], None, level),
        say("{titles}, of {channels}", titles=titles, channels=names) if names else titles,
    )
    return job_face(survey, (source_of(survey), BRAND), sheets, [drawing])
