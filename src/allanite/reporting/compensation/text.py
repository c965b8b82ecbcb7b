"""A compensation as text for the terminal, in ASCII."""

from collections.abc import Iterator

from allanite.compensation.study import Compensated, CompensationStudy
from allanite.reporting.sheet import printable
from allanite.reporting.tables import prose_lines, table_lines
from allanite.reporting.words import about, percent

from .numbers import CURVES, curve_rows, lines, verdict


def render(study: CompensationStudy, width: int = 120) -> str:
    """The study as text."""
    out = [f"file      {study.provenance.get('source') or '(data in memory)'}"]
    out += [f"{'' if i else 'assumed':<10}{note}" for i, note in enumerate(study.notes)]
    for channel in study.fitted:
        out += ["", *_channel(channel, study.recipe.level, width)]
    if study.applied:
        out += ["", f"applied to {study.provenance['applied to']}"]
    for channel in study.applied:
        out += ["", *_channel(channel, study.recipe.level, width)]
    return "".join(f"{printable(line)}\n" for line in out)


def _channel(channel: Compensated, level: float, width: int) -> Iterator[str]:
    yield f"{channel.record.name or 'channel'}  {about(channel.record)}"
    for note in channel.notes:
        yield from prose_lines(note, width, "  ! ")
    if channel.regression is None:
        yield from prose_lines(f"no result: {channel.refusal}", width, "  ! ")
        return
    yield from prose_lines(verdict(channel), width)
    if channel.gain is None:
        regression = channel.regression
        for note in regression.notes:
            yield from prose_lines(note, width, "  ! ")
        yield from prose_lines(
            f"noise beside it: {regression.noise}; {regression.effective:.4g} effective samples; condition "
            f"{regression.condition:.3g}", width,
        )  # fmt: skip
        yield ""
        head = ["regressor", "rate", "+-", f"{percent(level)} interval", "unit", "t", "p", "VIF", ""]
        yield from table_lines(head, [list(line) for line in lines(regression, level)])
    unit, rows = curve_rows(channel, level)
    if rows:
        yield ""
        yield f"  overlapping Allan deviation, {unit}, with {percent(level)} limits"
        yield from table_lines(CURVES, rows)
