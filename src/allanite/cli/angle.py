"""``allanite angle``: harmonic errors of a gimbal's angle sensors in service, or of an encoder with a reference."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import RateChoices
from allanite.core.choices import NUMBERS, separated
from allanite.core.errors import UnitError, UsageError
from allanite.core.ranges import ANGLE, LATITUDE, POSITIVE, REAL, SIZE, STAMP, TIME
from allanite.core.units import unit_of
from allanite.phrases.phrase import say, say_count
from allanite.study.settings import LengthChoices, WatchChoices

from .deliver import STDOUT, Extra, Outputs, deliver, outputs, put, settings_of
from .options import NAMES, RESULTS, Converted, Decorator, number, options
from .streams import show

if TYPE_CHECKING:
    from allanite.applications.angle import AngleSettings, Gimbals, Harmonics
    from allanite.core.arrays import FloatArray
    from allanite.core.record import Recording

DEGREE, ARCSEC = math.pi / 180, math.pi / 648_000

PRIOR = Converted(separated(float, "two standard deviations", 2, "3,10"), POSITIVE)


def prior_option(words: str, default: str | None = None) -> Decorator:
    """The option of the prior standard deviations, the second of which are in the units that `words` say."""
    return click.option("--prior", type=PRIOR, default=default, show_default=True, metavar="A,B",
        help=f"Prior standard deviations: of amplitudes, and of the other parameters, {words}.")  # fmt: skip


def turn_option(words: str, default: float | None = None) -> Decorator:
    """The option of the period of the auto-compensating rotation."""
    return click.option("--turn-period", type=number(TIME), default=default, show_default=True, metavar="S", help=words)


ANGLES = click.option("--angles", type=NAMES, default="h,q", show_default=True,
                      help="Angle sensors: h, q, h_polar, q_polar, mu.")  # fmt: skip
HEADING = click.option("--ring-heading", type=number(ANGLE), default=0.0, show_default=True, metavar="DEG",
    help="Direction of the outer ring's axis, from north to east.")  # fmt: skip

TRUE = "# simulated errors, arcsec: "  # what begins a simulated file


def harmonics_of(texts: Sequence[str]) -> dict[str, "Harmonics"]:
    """Known errors of sensors, written as ``ANGLE:ORDER=S,C`` in arcsec."""
    from allanite.applications.angle import Harmonics

    orders: dict[str, dict[int, tuple[float, float]]] = {}
    for text in texts:
        try:
            name, _, rest = text.partition(":")
            order, _, pair = rest.partition("=")
            s, c = (float(part) * ARCSEC for part in pair.split(","))
            orders.setdefault(name.strip(), {})[int(order)] = (s, c)
        except ValueError:
            raise UsageError("an error has the form ANGLE:ORDER=S,C in arcsec, e.g. h:128=3,-1.5, not "
                             f"{text!r}") from None  # fmt: skip
    return {name: Harmonics.of(amplitudes, name) for name, amplitudes in orders.items()}


def true_of(path: str) -> tuple["Harmonics", ...]:
    """The errors that a file was simulated with; none if its first line does not say so."""
    with Path(path).open("rb") as file:
        first = file.readline(1 << 16).decode("utf-8", "replace")
    return tuple(harmonics_of(first.removeprefix(TRUE).split()).values()) if first.startswith(TRUE) else ()


def deliver_study(result: Any, out: Outputs, choices: dict[str, Any], data: "Recording | None" = None, /,
                  *corrected: Mapping[str, Any]) -> None:  # fmt: skip
    """Deliver a result together with the options that produced it, and the corrected angles."""
    from allanite.applications.angle.plans import AngleStudy
    from allanite.study.job import provenance_of

    chosen = {key: v for key, v in choices.items() if v is not None and key not in ("level", "recipe")}
    made = provenance_of() | ({} if data is None else {"source": data.source, "sha256": data.digest})
    notes = () if data is None else data.notes
    study = AngleStudy(result, chosen, choices["level"] or 0.95, notes, made)
    deliver(study, out, Extra({"corrected": lambda _: columns_of(corrected[0])}))


def columns_of(data: Mapping[str, Any]) -> str:
    """Arrays of equal length as columns; floats keep every digit."""
    rows = zip(*(values.tolist() for values in data.values()), strict=True)
    return "".join(f"{','.join(map(str, row))}\n" for row in (data, *rows))


SWAY = Converted(separated(float, "amplitude in deg and period in s", 2, "1,60"), POSITIVE)
RANGE = Converted(separated(float, "two angles in deg", 2, "-10,10"), ANGLE)

EXPERIMENT = (
    "latitude", "duration", "reading interval",
    click.option("--q-law", default="exact", show_default=True,
        help="Motion of the outer angle: exact, or linear as printed in the paper."),
    turn_option("Auto-compensation.", 300.0),
    click.option("--sway", type=SWAY, metavar="DEG,S",
        help="Sway of the base in roll and pitch: amplitude and period."),
    click.option("--ring-rate", type=number(REAL), metavar="DEG/MIN",
        help="Turn the outer ring of the equatorial gyro to and fro, at this mean rate."),
    click.option("--ring-range", type=RANGE, default="-10,10", show_default=True, metavar="DEG,DEG",
        help="Angles between which it turns, from the first."),
    click.option("--ring-step", type=number(ANGLE), default=0.0, metavar="DEG",
        help="Turn it in steps of this size.  [default: continuously]"),
    HEADING,
)  # fmt: skip


@click.command()
@options(
    *EXPERIMENT,
    click.option("--start", "starts", type=Converted(NUMBERS, STAMP), metavar="S,...",
        help="Start, in seconds after h = 0; several are compared.  [default: every five minutes]"),
    "given sigma", prior_option("in the unit of --sigma", "3,10"), "orders", ANGLES, "level", "recipe", *RESULTS,
    settings=(LengthChoices, RateChoices),
)  # fmt: skip
def plan(**choices: Any) -> None:
    """Predict how accurately errors can be known."""
    out = outputs(choices, [choices["recipe"]])
    from allanite.applications.angle import plan as run, scan

    starts = choices["starts"] or ()
    if len(starts) == 1 and "plot" in out.paths:
        raise UsageError("the figure compares several starts: give more than one, or write a --report instead")
    orders = dict.fromkeys(choices["angles"], choices["orders"])
    settings = _experiment(choices, sigma=choices["sigma"], prior=choices["prior"], orders=orders)
    deliver_study(run(settings, *starts) if len(starts) == 1 else scan(settings, starts or None), out, choices)


@click.command()
@options(
    click.argument("out", type=click.Path()),
    *EXPERIMENT,
    click.option("--start", type=number(STAMP), default=0.0, show_default=True, metavar="S",
        help="Start, in seconds after h = 0."),
    click.option("--error", "errors", multiple=True, metavar="ANGLE:ORDER=S,C",
        help="A harmonic in arcsec, e.g. h:128=3,-1.5; repeatable."),
    "given sigma",
    click.option("--walk", type=number(SIZE), default=0.0, show_default=True, metavar="ARCSEC",
        help="Standard deviation of a step of a random walk."),
    "seed", "plot", "lang", "force", "quiet", settings=(LengthChoices, RateChoices),
)  # fmt: skip
def simulate(out: str, **choices: Any) -> None:
    """Simulate a system with known errors.

    Writes a CSV file OUT; --plot draws the errors against time.
    """
    where = outputs(choices | {"csv": out}, [])
    import numpy as np

    from allanite.applications.angle import readings, simulate as run
    from allanite.applications.angle.geometry import ANGLES as SENSORS

    known = harmonics_of(choices["errors"])
    if not known:
        raise UsageError("give at least one --error, e.g. h:128=3,-1.5 (arcsec)")
    settings = _experiment(choices)
    true = settings.gimbals(choices["start"])
    rng = np.random.default_rng(choices["seed"])
    z = run(true, known, sigma=choices["sigma"] * ARCSEC, walk=choices["walk"] * ARCSEC, rng=rng)
    shown = readings(true, known)
    table = {"time [s]": true.time, "difference": z}
    table |= {f"{name} [rad]": getattr(shown, name) for name in SENSORS[: 4 if settings.ring is None else 5]}
    table |= {} if true.rho is None else {"rho [rad]": true.rho}
    put(out, f"{TRUE}{' '.join(choices['errors'])}\n{columns_of(table)}", force=where.force)
    if "plot" in where.paths:
        from allanite.reporting import figures, printing
        from allanite.reporting.fonts import drawn_in
        from allanite.reporting.language import speaking

        with speaking(where.lang), speaking(drawn_in(where.lang)):
            figure = printing.printed(figures.plot_error_in_time(true, list(known.values())))
            printing.save(figure, where.paths["plot"], force=where.force)
    if out != STDOUT and not where.quiet:
        show(*(f"{name}: {path}" for name, path in where.paths.items()))


def _experiment(choices: dict[str, Any], **more: Any) -> "AngleSettings":
    from allanite.applications.angle import AngleSettings, Ring

    for name, meaning in (("latitude", "the latitude of the site"), ("duration", "the length of the experiment")):
        if choices[name] is None:
            raise UsageError(f"--{name} is required: {meaning}")
    sway = choices["sway"]
    same = {key: choices[key] for key in ("duration", "interval", "q_law", "turn_period")}
    turned = None if sway is None else (sway[0] * DEGREE, sway[1])
    rate, (low, high) = choices["ring_rate"], choices["ring_range"]
    if rate is None and choices["ring_step"]:
        raise UsageError("a ring in steps needs its mean rate: give --ring-rate, e.g. 2")
    angles = (value * DEGREE for value in (low, high, choices["ring_step"], choices["ring_heading"]))
    ring = None if rate is None else Ring(rate * DEGREE / 60, *angles)
    return AngleSettings(choices["latitude"] * DEGREE, **same, sway=turned, ring=ring, **more)


@click.group()
def angle() -> None:
    """Analyze harmonic errors of angle sensors.

    `calibrate` compares an encoder with a reference; `estimate` identifies the errors of a gimbal's angle sensors in
    service, from the measured cosine between the momentum vectors of two gyros, and `watch` does so while the samples
    come; `plan` predicts where that works best, without data; `simulate` writes a test file.
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

    data, columns = _rows(file, choices, ("measured", "reference"))
    a, b = columns.values()
    sigma = None if choices["sigma"] is None else choices["sigma"] * ARCSEC
    harmonics = run(a, b, choices["orders"], sigma=sigma, trend=choices["trend"], name=choices["measured"])
    deliver_study(harmonics, out, choices, data, {"measured [rad]": a, "corrected [rad]": a - harmonics.at(a)})


GIMBALS = (
    click.option("--difference", default="difference", show_default=True, metavar="COLUMN",
        help="Measured minus computed cosine between the momentum vectors."),
    "angle time",
    click.option("--h", "h", default="h", show_default=True, metavar="COLUMN",
        help="Inner angle of the equatorial gyro."),
    click.option("--q", "q", default="q", show_default=True, metavar="COLUMN",
        help="Intermediate angle of the equatorial gyro."),
    click.option("--h-polar", metavar="COLUMN", help="Inner angle of the polar gyro.  [default: the latitude]"),
    click.option("--q-polar", metavar="COLUMN", help="Intermediate angle of the polar gyro.  [default: 0]"),
    click.option("--latitude", type=number(LATITUDE), metavar="DEG",
        help="Latitude of the site.  [default: from the motion of h and q]"),
    click.option("--mu", metavar="COLUMN",
        help="Angle of the equatorial gyro's outer ring.  [default: mu, if there is such a column]"),
    HEADING,
    click.option("--rho", metavar="COLUMN",
        help="Angle of the auto-compensating rotation.  [default: rho, if there is such a column]"),
    turn_option("Or the period of that rotation, which starts at time 0."),
    "orders", ANGLES,
    click.option("--nuisance", type=NAMES, metavar="A,B,...",
        help="Parameters estimated jointly with the harmonics.  [default: ax,az,A1,A2,A3]"),
    "angle unit", "estimated sigma", prior_option("arcsec (arcsec/s for A3)"),
)  # fmt: skip


@angle.command()
@options("file", *GIMBALS, "corrected angles", "level", "recipe", *RESULTS)
def estimate(file: str, **choices: Any) -> None:
    """Estimate the errors of a gimbal's sensors."""
    out = outputs(choices, [file, choices["recipe"]], also=("corrected",))
    from allanite.applications.angle import estimate as run

    data, z, gimbals = gimbals_of(file, choices)
    result = run(z, gimbals, **model_of(choices))
    angles = {f"{h.name} [rad]": getattr(gimbals, h.name) - h.at(getattr(gimbals, h.name)) for h in result}
    deliver_study(replace(result, true=true_of(data.source)), out, choices, data, {"time [s]": gimbals.time, **angles})


@angle.command()
@options(click.argument("target", metavar="FILE|PORT|udp://127.0.0.1:9000"), *GIMBALS, "level", "recipe", "every",
         "duration", "idle", "baud", *RESULTS, settings=(WatchChoices,))  # fmt: skip
def watch(target: str, **choices: Any) -> None:
    """Estimate the errors of a gimbal's sensors live.

    Reads lines of numbers from a file that grows, a serial port, or datagrams sent to this machine. Each sample enters
    a Kalman filter without prediction, whose memory does not grow. Prints every few seconds what is known so far.
    Ctrl-C, SIGTERM, --for or --idle end it, and the results of 'allanite angle estimate' are printed and written.
    """
    out = outputs(choices, [target, choices["recipe"]])
    from allanite.applications.angle.service import Service

    from .following import follow

    settings = settings_of(WatchChoices, choices)
    service = Service(**model_of(choices))
    with follow(target, choices, settings, service, gimbals_of, quiet=out.quiet) as (result, data):
        true = true_of(target) if Path(target).is_file() else ()
        deliver_study(replace(result, true=true), out, choices, data)


def model_of(choices: Mapping[str, Any]) -> dict[str, Any]:
    """What is estimated, in rad."""
    from allanite.applications.angle.harmonics import USUAL

    sigma, prior = choices["sigma"], choices["prior"]
    return {"orders": dict.fromkeys(choices["angles"], choices["orders"]), "nuisance": choices["nuisance"] or USUAL,
            "sigma": None if sigma is None else sigma * ARCSEC,
            "prior": None if prior is None else (prior[0] * ARCSEC, prior[1] * ARCSEC)}  # fmt: skip


UNITS = {"difference": ("1", "rad"), "time": ("s", "1")}  # of columns that are no angles; a small angle is its sine
ROLES = ("h", "q", "h_polar", "q_polar", "mu", "rho")  # of columns of angles


def _rows(file: Any, choices: Mapping[str, Any], angles: Sequence[str],
          plain: Sequence[str] = ()) -> "tuple[Recording, dict[str, FloatArray]]":  # fmt: skip
    """The complete rows of a file, SI: the columns chosen for these angles and for other roles."""
    import numpy as np

    from allanite.readers import read

    names, others = ([choices[role] for role in roles] for roles in (angles, plain))
    units = None if choices["unit"] is None else dict.fromkeys(names, choices["unit"])
    data = read(file, channels=names, along=others or None, time="none", rate=1.0, kind="value", unit=units)
    for role, record in zip((*angles, *plain), data, strict=True):
        fitting = UNITS.get(role, ("rad",))
        if unit_of(record.unit).dimension not in [unit_of(unit).dimension for unit in fitting]:
            raise UnitError(f"column {record.name!r} is in {record.unit!r}, which cannot be converted to "
                            f"{fitting[0]!r}")  # fmt: skip
    columns = np.array([record.values * record.factor for record in data])
    whole = np.isfinite(columns).all(axis=0)
    if lost := int(whole.size - whole.sum()):
        told = say_count(lost, "{count} row with a missing value is left out",
                         "{count} rows with missing values are left out")  # fmt: skip
        data = replace(data, notes=(told, *data.notes))
    return data, dict(zip((*angles, *plain), columns[:, whole], strict=True))


def gimbals_of(file: Any, choices: dict[str, Any]) -> "tuple[Recording, FloatArray, Gimbals]":
    """The rows of a file, their differences of cosines, and their gimbals."""
    from allanite.applications.angle import Gimbals
    from allanite.applications.angle.latitude import demand_latitude

    period = choices["turn_period"]
    if choices["rho"] is not None and period is not None:
        raise UsageError("--rho and --turn-period describe the same rotation: give only one of them")
    usual = [role for role in ("mu", "rho") if choices[role] is None and not (role == "rho" and period)]
    for more in (usual, *([role] for role in usual), []):  # columns of their usual names, as far as the file has them
        chosen = choices | dict(zip(more, more, strict=True))
        try:
            data, at = _rows(file, chosen, [role for role in ROLES if chosen[role] is not None], tuple(UNITS))
            break
        except UsageError:
            if not more:
                raise
    choices.update(chosen)
    z, time, known = at.pop("difference"), at.pop("time"), choices["latitude"]
    turning = {} if period is None else {"rho": 2 * math.pi / period * time}
    angles: dict[str, Any] = {"h_polar": (known or 0.0) * DEGREE, "q_polar": 0.0, **at, **turning}
    gimbals = Gimbals(time, **angles, ring_heading=choices["ring_heading"] * DEGREE)
    if known is None and "h_polar" not in at:
        implied = demand_latitude(gimbals)
        gimbals = gimbals.moved(h_polar=implied.value)
        data = replace(data, notes=(say("{latitude} from the motion of h and q", latitude=str(implied)), *data.notes))
    return data, z, gimbals
