"""``allanite angle``: harmonic errors of a gimbal's angle sensors in service, or of an encoder with a reference."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import RateChoices
from allanite.core.errors import UsageError

from .angle_design import plan, simulate
from .angle_shared import ANGLES, ARCSEC, DEGREE, HEADING, deliver_study, prior_option, true_of, turn_option
from .deliver import outputs
from .options import RESULTS, options
from .types import NAMES

if TYPE_CHECKING:
    from allanite.applications.angle import Gimbals
    from allanite.readers.columns.sheet import FileSheet


@click.group()
def angle() -> None:
    """Analyze harmonic errors of angle sensors.

    `calibrate` compares an encoder with a reference; `estimate` identifies the errors of a gimbal's angle sensors in
    service, from the measured cosine between the momentum vectors of two gyros; `plan` predicts where that works best,
    without data; `simulate` writes a test file.
    """


angle.add_command(plan)
angle.add_command(simulate)


@angle.command()
@options(
    "file",
    click.option("--measured", required=True, metavar="COLUMN", help="Angle measured by the sensor under test."),
    "reference angle", "orders", "angle unit", "estimated sigma", "angle trend", "corrected angles", "level", "recipe",
    *RESULTS,
)  # fmt: skip
def calibrate(file: str, **choices: Any) -> None:
    """Calibrate an encoder against a reference."""
    out = outputs(choices, [file, choices["recipe"]], also=("corrected",))
    from allanite.applications.angle import calibrate as run
    from allanite.readers.columns.sheet import sheet

    data, name = sheet(file), choices["measured"]
    a, b = (data.values(choices[key], "rad", given=choices["unit"]) for key in ("measured", "reference"))
    sigma = _scaled(choices["sigma"], ARCSEC)
    found = run(a, b, choices["orders"], sigma=sigma, trend=choices["trend"], name=name)
    deliver_study(found, out, choices, data, {"measured [rad]": a, "corrected [rad]": a - found.at(a)})


@angle.command()
@options(
    "file",
    click.option("--difference", required=True, metavar="COLUMN",
        help="Measured minus computed cosine between the momentum vectors."),
    "angle time",
    click.option("--h", "h", default="h", show_default=True, metavar="COLUMN",
        help="Inner angle of the equatorial gyro."),
    click.option("--q", "q", default="q", show_default=True, metavar="COLUMN",
        help="Intermediate angle of the equatorial gyro."),
    click.option("--h-polar", metavar="COLUMN", help="Inner angle of the polar gyro.  [default: the latitude]"),
    click.option("--q-polar", metavar="COLUMN", help="Intermediate angle of the polar gyro.  [default: 0]"),
    "latitude",
    click.option("--mu", metavar="COLUMN",
        help="Angle of the equatorial gyro's outer ring.  [default: mu, if there is such a column]"),
    HEADING,
    click.option("--rho", metavar="COLUMN", help="Angle of the auto-compensating rotation."),
    turn_option("Or the period of that rotation, which starts at time 0."),
    "orders", ANGLES,
    click.option("--nuisance", type=NAMES, metavar="A,B,...",
        help="Parameters estimated jointly with the harmonics.  [default: ax,az,A1,A2,A3]"),
    "angle unit", "estimated sigma", prior_option("arcsec (arcsec/s for A3)"), "corrected angles", "level", "recipe",
    *RESULTS, settings=(RateChoices,),
)  # fmt: skip
def estimate(file: str, **choices: Any) -> None:
    """Estimate the errors of a gimbal's sensors."""
    out = outputs(choices, [file, choices["recipe"]], also=("corrected",))
    from allanite.applications.angle import estimate as run
    from allanite.applications.angle.design import USUAL
    from allanite.readers.columns.sheet import sheet

    data = sheet(file)
    gimbals, prior = _gimbals(data, choices), choices["prior"]
    found = run(
        data.values(choices["difference"], "1"),
        gimbals,
        orders=dict.fromkeys(choices["angles"], choices["orders"]),
        nuisance=choices["nuisance"] or USUAL,
        sigma=_scaled(choices["sigma"], ARCSEC),
        prior=None if prior is None else (prior[0] * ARCSEC, prior[1] * ARCSEC),
    )
    angles = {f"{h.name} [rad]": getattr(gimbals, h.name) - h.at(getattr(gimbals, h.name)) for h in found}
    deliver_study(replace(found, true=true_of(data.source)), out, choices, data, {"time [s]": gimbals.time, **angles})


def _gimbals(data: "FileSheet", choices: dict[str, Any]) -> "Gimbals":
    from allanite.applications.angle import Gimbals
    from allanite.readers.columns.column import lookup

    def read(key: str, otherwise: float = 0.0) -> Any:
        column = choices[key]
        return otherwise if column is None else data.values(column, "rad", given=choices["unit"])

    has_unit = bool(lookup(data.columns, choices["time"]).unit)
    time = data.values(choices["time"], "s", given=None if has_unit else "s")
    latitude, period = choices["latitude"], choices["turn_period"]
    if choices["h_polar"] is None and latitude is None:
        raise UsageError(
            "give the latitude of the polar gyro's gimbal (--latitude), or its inner angle (--h-polar COLUMN)"
        )
    if choices["rho"] is not None and period is not None:
        raise UsageError("--rho and --turn-period describe the same rotation: give only one of them")
    if period is not None and not period > 0:
        raise UsageError(f"--turn-period must be a positive number of seconds, not {period!r}")
    turn = None if choices["rho"] is None else read("rho")
    rho = turn if period is None else 2 * math.pi / period * time
    polar = read("h_polar", (latitude or 0.0) * DEGREE), read("q_polar")
    heading = choices["ring_heading"] * DEGREE
    if choices["mu"] is None and any(column.name == "mu" for column in data.columns):
        choices["mu"] = "mu"
    return Gimbals(time, read("h"), read("q"), *polar, rho=rho, mu=read("mu"), ring_heading=heading)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
