"""``allanite angle plan`` and ``simulate``: experiments that need no file."""

from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import RateChoices
from allanite.core.choice_kinds import separated
from allanite.core.errors import UsageError
from allanite.study.settings import LengthChoices

from .angle_shared import (
    ANGLES,
    ARCSEC,
    DEGREE,
    HEADING,
    TRUE,
    columns_of,
    deliver_study,
    harmonics_of,
    prior_option,
    turn_option,
)
from .deliver import STDOUT, outputs, put
from .options import RESULTS, options
from .streams import show
from .types import NUMBERS, Converted

if TYPE_CHECKING:
    from allanite.applications.angle import AngleSettings

SWAY = Converted(separated(float, "amplitude in deg and period in s", 2, "1,60"))
RANGE = Converted(separated(float, "two angles in deg", 2, "-10,10"))

EXPERIMENT = (
    "latitude", "duration", "reading interval",
    click.option("--q-law", default="exact", show_default=True,
        help="Motion of the outer angle: exact, or linear as printed in the paper."),
    turn_option("Auto-compensation.", 300.0),
    click.option("--sway", type=SWAY, metavar="DEG,S",
        help="Sway of the base in roll and pitch: amplitude and period."),
    click.option("--ring-rate", type=float, metavar="DEG/MIN",
        help="Turn the outer ring of the equatorial gyro to and fro, at this mean rate."),
    click.option("--ring-range", type=RANGE, default="-10,10", show_default=True, metavar="DEG,DEG",
        help="Angles between which it turns, from the first."),
    click.option("--ring-step", type=float, default=0.0, metavar="DEG",
        help="Turn it in steps of this size.  [default: continuously]"),
    HEADING,
)  # fmt: skip


@click.command()
@options(
    *EXPERIMENT,
    click.option("--start", "starts", type=NUMBERS, metavar="S,...",
        help="Start, in seconds after h = 0; several are compared.  [default: every five minutes]"),
    "given sigma", prior_option("in the unit of --sigma", "3,10"), "orders", ANGLES, "level", "recipe", *RESULTS,
    settings=(LengthChoices, RateChoices),
)  # fmt: skip
def plan(**choices: Any) -> None:
    """Predict how accurately errors can be known."""
    out = outputs(choices, [choices["recipe"]])
    from allanite.applications.angle import plan as run
    from allanite.applications.angle import scan

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
    click.option("--start", type=float, default=0.0, show_default=True, metavar="S",
        help="Start, in seconds after h = 0."),
    click.option("--error", "errors", multiple=True, metavar="ANGLE:ORDER=S,C",
        help="A harmonic in arcsec, e.g. h:128=3,-1.5; repeatable."),
    "given sigma",
    click.option("--walk", type=float, default=0.0, show_default=True, metavar="ARCSEC",
        help="Standard deviation of a step of a random walk."),
    "seed", "plot", "lang", "force", "quiet", settings=(LengthChoices, RateChoices),
)  # fmt: skip
def simulate(out: str, **choices: Any) -> None:
    """Simulate a system with known errors.

    Writes a CSV file OUT; --plot draws the errors against time.
    """
    where = outputs(choices | {"csv": out}, [])
    import numpy as np

    from allanite.applications.angle import readings
    from allanite.applications.angle import simulate as run
    from allanite.applications.angle.geometry import ANGLES as NAMES

    known = harmonics_of(choices["errors"])
    if not known:
        raise UsageError("give at least one --error, e.g. h:128=3,-1.5 (arcsec)")
    settings = _experiment(choices)
    true = settings.gimbals(choices["start"])
    rng = np.random.default_rng(choices["seed"])
    z = run(true, known, sigma=choices["sigma"] * ARCSEC, walk=choices["walk"] * ARCSEC, rng=rng)
    seen = readings(true, known)
    table = {"time [s]": true.time, "difference": z}
    table |= {f"{name} [rad]": getattr(seen, name) for name in NAMES[: 4 if settings.ring is None else 5]}
    table |= {} if true.rho is None else {"rho [rad]": true.rho}
    put(out, f"{TRUE}{' '.join(choices['errors'])}\n{columns_of(table)}", force=where.force)
    if "plot" in where.paths:
        from allanite.reporting import figures
        from allanite.reporting.fonts import drawn_in
        from allanite.reporting.language import speaking
        from allanite.reporting.style import demand_figure_path, encode

        path = where.paths["plot"]
        with speaking(where.lang), speaking(drawn_in(where.lang)):
            figure = figures.plot_error_in_time(true, list(known.values())).printed()
            put(path, encode(figure, demand_figure_path(path, force=where.force)), force=where.force)
    if out != STDOUT and not where.quiet:
        show("\n".join(f"{name}: {path}" for name, path in where.paths.items()))


def _experiment(choices: dict[str, Any], **more: Any) -> "AngleSettings":
    from allanite.applications.angle import AngleSettings, Ring

    for name in ("latitude", "duration"):
        if choices[name] is None:
            raise UsageError(
                f"--{name} is required: "
                f"{'the latitude of the site' if name == 'latitude' else 'the length of the experiment'}"
            )
    sway = choices["sway"]
    same = {key: choices[key] for key in ("duration", "interval", "q_law", "turn_period")}
    turned = None if sway is None else (sway[0] * DEGREE, sway[1])
    rate, (low, high) = choices["ring_rate"], choices["ring_range"]
    if rate is None and choices["ring_step"]:
        raise UsageError("a ring in steps needs its mean rate: give --ring-rate, e.g. 2")
    angles = (value * DEGREE for value in (low, high, choices["ring_step"], choices["ring_heading"]))
    ring = None if rate is None else Ring(rate * DEGREE / 60, *angles)
    return AngleSettings(choices["latitude"] * DEGREE, **same, sway=turned, ring=ring, **more)
