"""allanite angle: harmonic errors of angle sensors, of a gimbal in service or of any encoder against a reference."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from allanite import __version__
from allanite.core.errors import UsageError
from allanite.reporting.outputs import STDOUT, demand_outputs

from .angle_options import EXPERIMENT, LEVEL, ORDERS, OUTPUTS, numbers, words
from .angle_output import deliver, made_of, paths_of, put, said

if TYPE_CHECKING:
    from allanite.angle import Gimbals, Harmonics
    from allanite.readers.columns.sheet import Sheet

DEGREE, ARCSEC = math.pi / 180, math.pi / 648_000


@click.group()
def angle() -> None:
    """Harmonic errors of angle sensors: estimate, plan, simulate.

    `calibrate` compares any encoder with a reference; `estimate` finds the errors of a gimbal's sensors in service,
    from the measured cosine between two gyros' momentum vectors; `plan` says where that works best, without data.
    """


@angle.command()
@click.argument("file", type=click.Path())
@click.option("--measured", required=True, metavar="COLUMN", help="Angle of the sensor.")
@click.option("--reference", required=True, metavar="COLUMN", help="Angle of a better one.")
@ORDERS
@click.option("--unit", help="Of both angles, over the header: deg, rad, arcsec ...")
@click.option("--sigma", type=float, metavar="ARCSEC", help="Noise of a difference; estimated if left out.")
@click.option("--trend", type=int, default=0, show_default=True, help="Degree of a drift that is estimated along.")
@click.option("--corrected", metavar="PATH", type=click.Path(), help="Write the corrected angle as CSV.")
@LEVEL
@OUTPUTS
def calibrate(file: str, *, measured: str, reference: str, orders: tuple[int, ...], **choices: Any) -> None:
    """Find the harmonic errors of an encoder in FILE (text or CSV)."""
    paths = paths_of(choices, [file])
    from allanite.angle import calibrate as run
    from allanite.readers.columns.sheet import sheet

    data = sheet(file)
    a, b = (data.values(key, "rad", given=choices["unit"]) for key in (measured, reference))
    found = run(a, b, orders, sigma=_scaled(choices["sigma"], ARCSEC), trend=choices["trend"], name=measured)
    corrected = {"measured [rad]": a, "corrected [rad]": a - found.at(a)}
    deliver(found, paths, choices, made=made_of(data), corrected=corrected)


@angle.command()
@click.argument("file", type=click.Path())
@click.option(
    "--difference", required=True, metavar="COLUMN", help="Measured minus computed cosine between the momentum vectors."
)
@click.option("--time", default="time", show_default=True, metavar="COLUMN", help="Seconds after h = 0.")
@click.option("--h", "h", default="h", show_default=True, metavar="COLUMN", help="Inner angle, equatorial gyro.")
@click.option("--q", "q", default="q", show_default=True, metavar="COLUMN", help="Intermediate angle, equatorial gyro.")
@click.option("--h-polar", metavar="COLUMN", help="Inner angle of the polar gyro; the latitude if left out.")
@click.option("--q-polar", metavar="COLUMN", help="Its intermediate angle; 0 if left out.")
@click.option("--latitude", type=float, metavar="DEG", help="Of the place; needed without --h-polar.")
@click.option("--rho", metavar="COLUMN", help="Angle of the auto-compensating turn.")
@click.option("--turn-period", type=float, metavar="S", help="Its period, instead; it begins at time 0.")
@ORDERS
@click.option("--angles", callback=words, default="h,q", show_default=True, help="Sensors: h, q, h_polar, q_polar.")
@click.option("--nuisance", callback=words, metavar="A,B,...", help="Estimated along.  [ax,az,A1,A2,A3]")
@click.option("--unit", help="Of angles, over the header: deg, rad, arcsec ...")
@click.option("--sigma", type=float, metavar="ARCSEC", help="Noise of a reading; estimated if left out.")
@click.option(
    "--prior",
    callback=numbers(2, "two standard deviations are"),
    metavar="A,B",
    help="Known before: deviation of amplitudes and of the rest, arcsec (arcsec/s for A3).",
)
@click.option("--corrected", metavar="PATH", type=click.Path(), help="Write the corrected angles as CSV.")
@LEVEL
@OUTPUTS
def estimate(file: str, *, difference: str, orders: tuple[int, ...], **choices: Any) -> None:
    """Find the harmonic errors of a gimbal's angle sensors in FILE (text or CSV)."""
    paths = paths_of(choices, [file])
    from allanite.angle import estimate as run
    from allanite.angle.design import USUAL
    from allanite.readers.columns.sheet import sheet

    data = sheet(file)
    gimbals = _gimbals(data, choices)
    prior = choices["prior"]
    found = run(
        data.values(difference, "1"),
        gimbals,
        orders=dict.fromkeys(choices["angles"], orders),
        nuisance=choices["nuisance"] or USUAL,
        sigma=_scaled(choices["sigma"], ARCSEC),
        prior=None if prior is None else (prior[0] * ARCSEC, prior[1] * ARCSEC),
    )
    angles = {f"{h.name} [rad]": getattr(gimbals, h.name) - h.at(getattr(gimbals, h.name)) for h in found}
    deliver(found, paths, choices, made=made_of(data), corrected={"time [s]": gimbals.time, **angles})


def _gimbals(data: "Sheet", choices: dict[str, Any]) -> "Gimbals":
    from allanite.angle import Gimbals

    def read(key: str) -> Any:
        return data.values(choices[key], "rad", given=choices["unit"])

    time = data.values(choices["time"], "s", given=None if _has_unit(data, choices["time"]) else "s")
    if choices["h_polar"] is None and choices["latitude"] is None:
        raise UsageError("give --latitude, where the polar gyro's gimbal stands, or its angle as --h-polar COLUMN")
    if choices["rho"] is not None and choices["turn_period"] is not None:
        raise UsageError("--rho and --turn-period say the same thing: give one of them")
    rho = read("rho") if choices["rho"] is not None else None
    if choices["turn_period"] is not None:
        if not choices["turn_period"] > 0:
            raise UsageError(f"--turn-period is a positive number of s, not {choices['turn_period']!r}")
        rho = 2 * math.pi / choices["turn_period"] * time
    return Gimbals(
        time=time,
        h=read("h"),
        q=read("q"),
        h_polar=read("h_polar") if choices["h_polar"] is not None else choices["latitude"] * DEGREE,
        q_polar=read("q_polar") if choices["q_polar"] is not None else 0.0,  # type: ignore[arg-type]
        rho=rho,
    )


def _has_unit(data: "Sheet", key: str) -> bool:
    from allanite.readers.columns.column import lookup

    return bool(lookup(data.columns, key).unit)


@angle.command()
@EXPERIMENT
@click.option("--start", type=float, metavar="S", help="Seconds after h = 0; all starts are tried if left out.")
@click.option(
    "--sigma", type=float, default=1.0, show_default=True, help="Noise of a reading; results are in its unit."
)
@click.option(
    "--prior", callback=numbers(2, "two standard deviations are"), default="3,10", show_default=True, metavar="A,B",
    help="Known before: deviation of amplitudes and of the rest, in the unit of sigma.",
)  # fmt: skip
@ORDERS
@click.option("--angles", callback=words, default="h,q", show_default=True, help="Sensors: h, q, h_polar, q_polar.")
@LEVEL
@OUTPUTS
def plan(*, start: float | None, orders: tuple[int, ...], **choices: Any) -> None:
    """Say how well the errors of a gimbal's sensors would be known, and where best to estimate them."""
    paths = paths_of(choices, [])
    from allanite.angle import plan as run
    from allanite.angle import scan

    setup = _experiment(choices) | {
        "sigma": choices["sigma"],
        "prior": choices["prior"],
        "orders": dict.fromkeys(choices["angles"], orders),
    }
    if start is not None and {"report", "plot"} & set(paths):
        raise UsageError("page and figure compare all starts of the interval; leave --start out, or ask for --json")
    value = scan(**setup) if start is None else run(start=start, **setup)
    deliver(value, paths, choices, made={"allanite": __version__, "options": said()})


@angle.command()
@click.argument("out", type=click.Path())
@EXPERIMENT
@click.option("--start", type=float, default=0.0, show_default=True, metavar="S", help="Seconds after h = 0.")
@click.option(
    "--error",
    "errors",
    multiple=True,
    metavar="ANGLE:ORDER=S,C",
    help="A harmonic, arcsec, as h:128=3,-1.5; may be given again.",
)
@click.option("--sigma", type=float, default=1.0, show_default=True, metavar="ARCSEC", help="White noise of a reading.")
@click.option("--walk", type=float, default=0.0, show_default=True, metavar="ARCSEC", help="Step of a random walk.")
@click.option("--seed", type=int, default=1, show_default=True, help="Of the random numbers.")
@click.option("--force", is_flag=True, help="Overwrite OUT.")
def simulate(out: str, *, start: float, errors: Sequence[str], force: bool, **choices: Any) -> None:
    """Write a CSV file OUT as a system with known errors would have recorded it."""
    demand_outputs({"csv": out}, inputs=[], force=force)
    import numpy as np

    from allanite.angle import gimbals, readings
    from allanite.angle import simulate as run
    from allanite.reporting.angle.plain import columns

    setup = _experiment(choices)
    known = _known(errors)
    duration, interval = setup.pop("duration"), setup.pop("interval")
    if not (0 < 2 * interval <= duration):
        raise UsageError(f"{duration:g} s hold fewer than 2 readings at an interval of {interval:g} s")
    true = gimbals(start + interval * np.arange(round(duration / interval)), **setup)
    rng = np.random.default_rng(choices["seed"])
    z = run(true, known, sigma=choices["sigma"] * ARCSEC, walk=choices["walk"] * ARCSEC, rng=rng)
    seen = readings(true, known)
    table = {"time [s]": true.time, "difference": z}
    table |= {f"{name} [rad]": getattr(seen, name) for name in ("h", "q", "h_polar", "q_polar")}
    table |= {} if true.rho is None else {"rho [rad]": true.rho}
    put(out, columns(table), force=force)
    if out != STDOUT:
        click.echo(f"csv: {out}")


def _known(errors: Sequence[str]) -> "dict[str, Harmonics]":
    from allanite.angle import Harmonics

    found: dict[str, dict[int, tuple[float, float]]] = {}
    for text in errors:
        try:
            name, _, rest = text.partition(":")
            order, _, pair = rest.partition("=")
            s, c = (float(part) * ARCSEC for part in pair.split(","))
            found.setdefault(name.strip(), {})[int(order)] = (s, c)
        except ValueError:
            raise UsageError(f"an error is ANGLE:ORDER=S,C in arcsec, as h:128=3,-1.5, not {text!r}") from None
    if not found:
        raise UsageError("give at least one --error, as h:128=3,-1.5 (arcsec)")
    return {name: Harmonics.of(amplitudes, name) for name, amplitudes in found.items()}


def _experiment(choices: dict[str, Any]) -> dict[str, Any]:
    sway = choices["sway"]
    return {
        "latitude": choices["latitude"] * DEGREE,
        "duration": choices["duration"],
        "interval": choices["interval"],
        "q_law": choices["q_law"],
        "turn_period": choices["turn_period"],
        "sway": None if sway is None else (sway[0] * DEGREE, sway[1]),
    }


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
