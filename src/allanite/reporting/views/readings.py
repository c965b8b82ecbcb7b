"""How values read off a curve are shown."""

from allanite.core.readings import Readings
from allanite.phrases.phrase import say
from allanite.reporting import words
from allanite.reporting.digits import digits
from allanite.reporting.sheet import Column, Face, Sheet, Table

from . import View

KEY = say(
    "Read off the overlapping Allan deviation, as data sheets do. No model is assumed; the intervals "
    "use the power law identified at each averaging time. The deviation at 1 s equals the random walk coefficient only "
    "where the curve has slope -0.5. Data sheets quote the minimum as in-run bias stability. N-second stability is the "
    "standard deviation of successive means; unless the noise is white it grows with the length of the record."
)


def readings_table(readings: Readings, level: float) -> Table:
    """Values read off a curve, in the units of data sheets."""
    heads = (
        Column(say("read off the curve"), "name"), Column(say("value")), Column(words.interval(level), "interval"),
        Column(say("unit"), "unit"), Column("", "name"),
    )  # fmt: skip
    rows = []
    for title, _, value, low, high, unit, *_, remark in readings.rows(level)[1]:
        slope = (f"{value:.3f}", f"{low:.3f} .. {high:.3f}")  # which has no unit
        rows.append([title, *(digits(value, low, high).plain() if unit else slope), unit, remark])
    return Table(heads, rows, key=KEY)


READINGS = View(
    lambda readings, level: Face(
        say("Readings"),
        say("read off the Allan deviation"),
        (Sheet(say("readings"), parts=(readings_table(readings, level),)),),
    ),
    rows=lambda readings, level: readings.rows(level),
)
