"""What was measured beside what a data sheet says of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from allanite.core.aliases import public
from allanite.core.encoding import plain
from allanite.core.limits import held
from allanite.core.readings import FALLING, FLICKER
from allanite.planning.datasheets import QUANTITIES, Claim, DataSheet, data_sheet_named
from allanite.study.analysis import analyze
from allanite.study.channels import Progress, Source
from allanite.study.job import Job
from allanite.study.recipe import Recipe
from allanite.study.results import Channel


class Measured(NamedTuple):
    """A line of a data sheet beside what was measured, both in the unit of the sheet; NaN if it was not measured."""

    claim: Claim
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    remark: str = ""

    @property
    def ratio(self) -> tuple[float, float, float]:
        """What was measured over what the data sheet says, with its interval."""
        return self.value / self.claim.value, self.low / self.claim.value, self.high / self.claim.value

    @property
    def outcome(self) -> str:
        """Whether the interval keeps the value of the data sheet, as a limit is judged; empty if nothing is known."""
        low = 0.0 if self.remark == FALLING else self.low
        return held(low, self.high, self.claim.value) if math.isfinite(self.high) else ""


@dataclass(frozen=True, eq=False, repr=False)
class SheetComparison(Job[Channel]):
    """An analysis, and the data sheet of the sensor.

    Attributes
    ----------
    sheet : DataSheet
    channels, recipe, findings, notes, provenance
        Those of the `Study`.
    """

    _channel = Channel

    sheet: DataSheet

    def measured(self, channel: Channel, level: float = 0.95) -> Iterator[Measured]:
        """The lines of the data sheet that speak of the sensor of a channel and have a coefficient.

        Random walks and densities are compared with N of the model, a stability with the minimum of the Allan
        deviation.
        """
        for claim in self.sheet.claims:
            if claim.sensor == channel.record.signal.name and claim.term is not None:
                yield _measured(channel, claim, level)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[object]]]:
        """Headings and rows for any table."""
        heads = ["channel", "quantity", "printed", "limit", "sheet", "measured", "low", "high", "unit", "ratio"]
        pairs = ((channel.record.name, m, m.claim) for channel in self for m in self.measured(channel, level))
        return [*heads, "outcome"], [[name, c.quantity, c.printed, c.limit, c.value, m.value, m.low, m.high, c.unit,
                                      m.ratio[0], m.outcome] for name, m, c in pairs]  # fmt: skip

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        return self.recipe.to_dict() | {"datasheet": self.sheet.name}

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        heads, rows = self.rows(self.recipe.level if level is None else level)
        return super().to_dict(level) | {"measured": plain([dict(zip(heads, row, strict=True)) for row in rows])}


def _measured(channel: Channel, claim: Claim, level: float) -> Measured:
    """What was measured of a coefficient, as the value that the data sheet would have for it."""
    term, readings = claim.term, channel.readings
    assert term is not None  # noqa: S101 - lines without a coefficient are left out
    scale = claim.value / term.value
    if QUANTITIES[claim.quantity].symbol == "B":
        if readings is None or readings.minimum is None:
            return Measured(claim)
        scale *= FLICKER
        low, high = readings.minimum.interval(level)
        remark = "" if readings.inside else FALLING
        return Measured(claim, readings.minimum.deviation * scale, low * scale, high * scale, remark)
    estimate = next((e for e in channel.fit or () if e.symbol == term.symbol), None)
    if estimate is None or estimate.value is None or not estimate.valued:
        return Measured(claim, remark=estimate.row.name if estimate else "")
    low, high = estimate.interval(level)
    return Measured(claim, estimate.value * scale, low * scale, high * scale)


@public
def compare_with_sheet(source: Source, sheet: str | DataSheet, recipe: Recipe | None = None, *,
                       progress: Progress | None = None, **choices: Any) -> SheetComparison:  # fmt: skip
    """Compare the noise of a recording with what a data sheet says.

    Parameters
    ----------
    source : Recording, Record or path
    sheet : str or DataSheet
        A name in `DATASHEETS`, or a data sheet.
    recipe, progress, **choices
        As for `analyze`.

    Returns
    -------
    SheetComparison

    Raises
    ------
    UsageError
        There is no such data sheet.
    DataError
        The file cannot be read, or no channel has a result.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite import N, simulate
    >>> record = simulate(N(0.3, "deg/sqrt(h)"), 8192, 100.0, rng=np.random.default_rng(1))
    >>> found = compare_with_sheet(record, "adis16470")
    >>> [(m.claim.printed, round(m.ratio[0], 2)) for m in found.measured(found[0])][0]
    ('Angular Random Walk', 0.87)
    """
    known = sheet if isinstance(sheet, DataSheet) else data_sheet_named(sheet)
    study = analyze(source, recipe, progress=progress, **choices)
    return SheetComparison(study.channels, study.recipe, study.findings, study.notes, study.provenance, known)
