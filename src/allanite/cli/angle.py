"""``allanite angle``: harmonic errors of a gimbal's angle sensors in service, or of an encoder with a reference."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from allanite.core.errors import UsageError

from .deliver import STDOUT, Extra, Outputs, deliver, outputs, put
from .options import RESULTS, options
from .types import NAMES, NUMBERS, Separated

if TYPE_CHECKING:
    from allanite.angle import AngleSettings, Gimbals, Harmonics
    from allanite.readers.columns.sheet import Sheet

DEGREE, ARCSEC = math.pi / 180, math.pi / 648_000

PRIOR = Separated(float, "two standard deviations", 2, "3,10")
SWAY = Separated(float, "amplitude in deg and period in s", 2, "1,60")

ANGLES = click.option(
    "--angles", type=NAMES, default="h,q", show_default=True, help="Angle sensors: h, q, h_polar, q_polar."
)
EXPERIMENT = (
    "latitude",
    "duration",
    "reading interval",
    click.option(
        "--q-law",
        default="exact",
        show_default=True,
        help="Motion of the outer angle: exact, or linear as printed in the paper.",
    ),
    click.option("--turn-period", type=float, default=300.0, show_default=True, metavar="S", help="Auto-compensation."),
    click.option(
        "--sway", type=SWAY, metavar="DEG,S", help="Sway of the base in roll and pitch: amplitude and period."
    ),
)


@click.group()
def angle() -> None:
    """Analyze harmonic errors of angle sensors.

    `calibrate` compares an encoder with a reference; `estimate` identifies the errors of a gimbal's angle sensors in
    service, from the measured cosine between the momentum vectors of two gyros; `plan` predicts where that works best,
    without data; `simulate` writes a test file.
    """


@angle.command()
@options(
    "file",
    click.option("--measured", required=True, metavar="COLUMN", help="Angle measured by the sensor under test."),
    "reference angle",
    "orders",
    "angle unit",
    "estimated sigma",
    "angle trend",
    "corrected angles",
    "level",
    "recipe",
    *RESULTS,
)
def calibrate(file: str, **choices: Any) -> None:
    """Calibrate an encoder against a reference."""
    out = outputs(choices, [file, choices["recipe"]], also=("corrected",))
    from allanite.angle import calibrate as run
    from allanite.readers.columns.sheet import sheet

    data, name = sheet(file), choices["measured"]
    a, b = (data.values(choices[key], "rad", given=choices["unit"]) for key in ("measured", "reference"))
    sigma = _scaled(choices["sigma"], ARCSEC)
    found = run(a, b, choices["orders"], sigma=sigma, trend=choices["trend"], name=name)
    _deliver(found, out, choices, data, {"measured [rad]": a, "corrected [rad]": a - found.at(a)})


@angle.command()
@options(
    "file",
    click.option(
        "--difference",
        required=True,
        metavar="COLUMN",
        help="Measured minus computed cosine between the momentum vectors.",
    ),
    "angle time",
    click.option(
        "--h", "h", default="h", show_default=True, metavar="COLUMN", help="Inner angle of the equatorial gyro."
    ),
    click.option(
        "--q", "q", default="q", show_default=True, metavar="COLUMN", help="Intermediate angle of the equatorial gyro."
    ),
    click.option("--h-polar", metavar="COLUMN", help="Inner angle of the polar gyro.  [default: the latitude]"),
    click.option("--q-polar", metavar="COLUMN", help="Intermediate angle of the polar gyro.  [default: 0]"),
    "latitude",
    click.option("--rho", metavar="COLUMN", help="Angle of the auto-compensating rotation."),
    click.option(
        "--turn-period", type=float, metavar="S", help="Or the period of that rotation, which starts at time 0."
    ),
    "orders",
    ANGLES,
    click.option(
        "--nuisance",
        type=NAMES,
        metavar="A,B,...",
        help="Parameters estimated jointly with the harmonics.  [default: ax,az,A1,A2,A3]",
    ),
    "angle unit",
    "estimated sigma",
    click.option(
        "--prior",
        type=PRIOR,
        metavar="A,B",
        help="Prior standard deviations: of amplitudes, and of the other parameters, arcsec (arcsec/s for A3).",
    ),
    "corrected angles",
    "level",
    "recipe",
    *RESULTS,
)
def estimate(file: str, **choices: Any) -> None:
    """Estimate the errors of a gimbal's sensors."""
    out = outputs(choices, [file, choices["recipe"]], also=("corrected",))
    from allanite.angle import estimate as run
    from allanite.angle.design import USUAL
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
    _deliver(found, out, choices, data, {"time [s]": gimbals.time, **angles})


def _gimbals(data: "Sheet", choices: dict[str, Any]) -> "Gimbals":
    from allanite.angle import Gimbals
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
    return Gimbals(time, read("h"), read("q"), *polar, rho=rho)


@angle.command()
@options(
    *EXPERIMENT,
    click.option(
        "--start",
        "starts",
        type=NUMBERS,
        metavar="S,...",
        help="Start, in seconds after h = 0; several are compared.  [default: every five minutes]",
    ),
    "given sigma",
    click.option(
        "--prior",
        type=PRIOR,
        default="3,10",
        show_default=True,
        metavar="A,B",
        help="Prior standard deviations: of amplitudes, and of the other parameters, in the unit of --sigma.",
    ),
    "orders",
    ANGLES,
    "level",
    "recipe",
    *RESULTS,
)
def plan(**choices: Any) -> None:
    """Predict how accurately errors can be known."""
    out = outputs(choices, [choices["recipe"]])
    from allanite.angle import plan as run
    from allanite.angle import scan

    starts = choices["starts"] or ()
    if len(starts) == 1 and "plot" in out.paths:
        raise UsageError("the figure compares several starts: give more than one, or write a --report instead")
    orders = dict.fromkeys(choices["angles"], choices["orders"])
    settings = _experiment(choices, sigma=choices["sigma"], prior=choices["prior"], orders=orders)
    _deliver(run(settings, *starts) if len(starts) == 1 else scan(settings, starts or None), out, choices)


@angle.command()
@options(
    click.argument("out", type=click.Path()),
    *EXPERIMENT,
    click.option(
        "--start", type=float, default=0.0, show_default=True, metavar="S", help="Start, in seconds after h = 0."
    ),
    click.option(
        "--error",
        "errors",
        multiple=True,
        metavar="ANGLE:ORDER=S,C",
        help="A harmonic in arcsec, e.g. h:128=3,-1.5; repeatable.",
    ),
    "given sigma",
    click.option(
        "--walk",
        type=float,
        default=0.0,
        show_default=True,
        metavar="ARCSEC",
        help="Standard deviation of a step of a random walk.",
    ),
    "seed",
    "plot",
    "lang",
    "force",
)
def simulate(out: str, **choices: Any) -> None:
    """Simulate a system with known errors.

    Writes a CSV file OUT; --plot draws the errors against time.
    """
    where = outputs(choices | {"csv": out}, [])
    import numpy as np

    from allanite.angle import readings
    from allanite.angle import simulate as run

    known = _known(choices["errors"])
    true = _experiment(choices).gimbals(choices["start"])
    rng = np.random.default_rng(choices["seed"])
    z = run(true, known, sigma=choices["sigma"] * ARCSEC, walk=choices["walk"] * ARCSEC, rng=rng)
    seen = readings(true, known)
    table = {"time [s]": true.time, "difference": z}
    table |= {f"{name} [rad]": getattr(seen, name) for name in ("h", "q", "h_polar", "q_polar")}
    table |= {} if true.rho is None else {"rho [rad]": true.rho}
    put(out, _csv(table), force=where.force)
    if "plot" in where.paths:
        put(where.paths["plot"], _drawn(true, list(known.values()), where), force=where.force)
    if out != STDOUT:
        click.echo("\n".join(f"{name}: {path}" for name, path in where.paths.items()))


def _drawn(gimbals: "Gimbals", known: "Sequence[Harmonics]", where: Outputs) -> bytes:
    """The errors against time, as the figure that was asked for."""
    from allanite.reporting import figures
    from allanite.reporting.fonts import drawn_in
    from allanite.reporting.language import speaking
    from allanite.reporting.style import demand_figure_path, encode

    path = where.paths["plot"]
    with speaking(where.lang), speaking(drawn_in(where.lang)):
        return encode(figures.plot_error_in_time(gimbals, known), demand_figure_path(path, force=where.force))


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
            raise UsageError(
                f"an error has the form ANGLE:ORDER=S,C in arcsec, e.g. h:128=3,-1.5, not {text!r}"
            ) from None
    if not found:
        raise UsageError("give at least one --error, e.g. h:128=3,-1.5 (arcsec)")
    return {name: Harmonics.of(amplitudes, name) for name, amplitudes in found.items()}


def _experiment(choices: dict[str, Any], **more: Any) -> "AngleSettings":
    from allanite.angle import AngleSettings

    for name in ("latitude", "duration"):
        if choices[name] is None:
            raise UsageError(
                f"--{name} is required: "
                f"{'the latitude of the site' if name == 'latitude' else 'the length of the experiment'}"
            )
    sway = choices["sway"]
    same = {key: choices[key] for key in ("duration", "interval", "q_law", "turn_period")}
    turned = None if sway is None else (sway[0] * DEGREE, sway[1])
    return AngleSettings(choices["latitude"] * DEGREE, **same, sway=turned, **more)


def _deliver(
    result: Any, out: Outputs, choices: dict[str, Any], data: "Sheet | None" = None, /, *corrected: Mapping[str, Any]
) -> None:
    """Deliver a result together with the options that produced it, and the corrected angles."""
    from allanite.angle.study import AngleStudy
    from allanite.study.channels import provenance_of

    chosen = {key: v for key, v in choices.items() if v is not None and key not in ("level", "recipe")}
    made = provenance_of() | ({} if data is None else {"source": data.source, "sha256": data.digest})
    notes = () if data is None else data.notes
    study = AngleStudy(result, chosen, choices["level"] or 0.95, notes, made)
    deliver(study, out, Extra({"corrected": lambda _: _csv(corrected[0])}))


def _csv(data: Mapping[str, Any]) -> str:
    """Arrays of equal length as columns; floats keep every digit."""
    rows = zip(*(values.tolist() for values in data.values()), strict=True)
    return "".join(f"{','.join(map(str, row))}\n" for row in (data, *rows))


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
