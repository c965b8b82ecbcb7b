"""What the commands of ``allanite angle`` share: units, options, how results are delivered."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from allanite.core.choice_kinds import separated

from .deliver import Extra, Outputs, deliver
from .options import Decorator
from .types import NAMES, Converted

if TYPE_CHECKING:
    from allanite.readers.columns.sheet import FileSheet

DEGREE, ARCSEC = math.pi / 180, math.pi / 648_000

PRIOR = Converted(separated(float, "two standard deviations", 2, "3,10"))


def prior_option(words: str, default: str | None = None) -> Decorator:
    """The option of the prior standard deviations, the second of which are in the units that `words` say."""
    return click.option("--prior", type=PRIOR, default=default, show_default=True, metavar="A,B",
        help=f"Prior standard deviations: of amplitudes, and of the other parameters, {words}.")  # fmt: skip


def turn_option(words: str, default: float | None = None) -> Decorator:
    """The option of the period of the auto-compensating rotation."""
    return click.option("--turn-period", type=float, default=default, show_default=True, metavar="S", help=words)


ANGLES = click.option(
    "--angles", type=NAMES, default="h,q", show_default=True, help="Angle sensors: h, q, h_polar, q_polar."
)


def deliver_study(
    result: Any,
    out: Outputs,
    choices: dict[str, Any],
    data: "FileSheet | None" = None,
    /,
    *corrected: Mapping[str, Any],
) -> None:
    """Deliver a result together with the options that produced it, and the corrected angles."""
    from allanite.applications.angle.calibrating import AngleStudy
    from allanite.study.provenance import provenance_of

    chosen = {key: v for key, v in choices.items() if v is not None and key not in ("level", "recipe")}
    made = provenance_of() | ({} if data is None else {"source": data.source, "sha256": data.digest})
    notes = () if data is None else data.notes
    study = AngleStudy(result, chosen, choices["level"] or 0.95, notes, made)
    deliver(study, out, Extra({"corrected": lambda _: columns_of(corrected[0])}))


def columns_of(data: Mapping[str, Any]) -> str:
    """Arrays of equal length as columns; floats keep every digit."""
    rows = zip(*(values.tolist() for values in data.values()), strict=True)
    return "".join(f"{','.join(map(str, row))}\n" for row in (data, *rows))
