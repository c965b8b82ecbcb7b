"""What the commands of ``allanite angle`` share: units, options, how results are delivered."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from allanite.core.choice_kinds import separated
from allanite.core.errors import UsageError

from .deliver import Extra, Outputs, deliver
from .options import Decorator
from .types import NAMES, Converted

if TYPE_CHECKING:
    from allanite.applications.angle import Harmonics
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
    "--angles", type=NAMES, default="h,q", show_default=True, help="Angle sensors: h, q, h_polar, q_polar, mu."
)
HEADING = click.option("--ring-heading", type=float, default=0.0, show_default=True, metavar="DEG",
    help="Direction of the outer ring's axis, from north to east.")  # fmt: skip

TRUE = "# simulated errors, arcsec: "
"""What begins a simulated file."""


def harmonics_of(texts: Sequence[str]) -> dict[str, "Harmonics"]:
    """Known errors of sensors, written as ``ANGLE:ORDER=S,C`` in arcsec."""
    from allanite.applications.angle import Harmonics

    found: dict[str, dict[int, tuple[float, float]]] = {}
    for text in texts:
        try:
            name, _, rest = text.partition(":")
            order, _, pair = rest.partition("=")
            s, c = (float(part) * ARCSEC for part in pair.split(","))
            found.setdefault(name.strip(), {})[int(order)] = (s, c)
        except ValueError:
            raise UsageError(
                f"an error has the form ANGLE:ORDER=S,C in arcsec, e.g. h:128=3,-1.5, not {text!r}"
            ) from None
    return {name: Harmonics.of(amplitudes, name) for name, amplitudes in found.items()}


def true_of(path: str) -> tuple["Harmonics", ...]:
    """The errors that a file was simulated with; none if its first line does not say so."""
    with Path(path).open("rb") as file:
        first = file.readline(1 << 16).decode("utf-8", "replace")
    return tuple(harmonics_of(first.removeprefix(TRUE).split()).values()) if first.startswith(TRUE) else ()


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
