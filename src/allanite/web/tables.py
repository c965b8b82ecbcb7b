"""The menus of the page, read off the tables."""

import math
import shlex
from typing import Any

from allanite.cli.tasks import jobs
from allanite.core.choices import choices_of
from allanite.core.kinds import KIND_WORDS, KINDS
from allanite.core.units import SIGNALS
from allanite.core.version import __version__
from allanite.exporting.exports import EXPORTS
from allanite.identification.methods import METHODS
from allanite.interpretation.devices import DEVICES
from allanite.phrases.phrase import say
from allanite.planning.sensors import SENSORS
from allanite.reporting import words
from allanite.reporting.language import LANGUAGES, speaking, tr
from allanite.statistics import STATISTICS
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .requests import accepted

UNITS = {
    "gyro": ("deg/s", "rad/s", "deg/h", "mdeg/s", "arcsec/s", "deg", "rad", "arcsec"),
    "accel": ("m/s^2", "g", "mg", "ug", "mGal", "m/s"),
}
"""Units offered first; every unit can be typed."""

EXAMPLES = {
    "mems": (say("three MEMS gyros, 1 h"), "--sensor mems --rate 100 --duration 1h --channels 3"),
    "fog": (say("fiber-optic gyro, 2 h"), "--sensor fog --rate 100 --duration 2h"),
    "disturbed": (
        say("fiber-optic gyro with a disturbance, 1 h"),
        "--sensor fog --rate 100 --duration 1h --noise-profile '0:1, 3000:1, 3001:8, 3500:8, 3501:1, 3600:1'",
    ),
}
"""Options of ``allanite simulate`` for the recordings to play with; "disturbed" has a piece to cut out."""


def simulation(name: str, path: str) -> list[str]:
    """The words of the command line that writes an example."""
    return ["simulate", path, *shlex.split(EXAMPLES[name][1]), "--quiet", "--force"]


def tables(lang: str) -> dict[str, Any]:
    """Everything that a menu shows, in a language."""
    gyro = SIGNALS[0]
    with speaking(lang):
        return {
            "version": __version__,
            "statistics": [{"name": row.name, "title": tr(row.title)} for row in STATISTICS.values()],
            "terms": [
                {"symbol": s, "title": tr(words.title(s, gyro)), "color": row.color, "dark": row.dark,
                 "slope": row.slope if math.isfinite(row.slope) else None, "automatic": row.automatic}
                for s, row in TERMS.items()
            ],
            "methods": [{"name": name, "title": tr(row.title)} for name, row in METHODS.items()],
            "units": {sensor: list(units) for sensor, units in UNITS.items()},
            "kinds": [{"name": k, "title": tr(KIND_WORDS[k]), "meaning": tr(row[2])} for k, row in KINDS.items()],
            "exports": [
                {"name": name, "title": tr(row.title), "formats": list(row.forms)} for name, row in EXPORTS.items()
            ],
            "devices": list(DEVICES),
            "sensors": list(SENSORS),
            "examples": [{"name": name, "title": tr(title)} for name, (title, _) in EXAMPLES.items()],
            "languages": [{"code": code, "name": name} for code, name in LANGUAGES.items()],
            "outliers": [{"name": "", "title": tr(say("exclude from the fit only"))},
                         {"name": "mark", "title": tr(say("exclude everywhere"))},
                         {"name": "keep", "title": tr(say("use everywhere"))}],
            "verbs": jobs(),
            "options": {verb: {name: row.text for name, row in accepted(verb).items()} for verb in jobs()},
            "choices": [{"name": name, "group": row.group, "control": row.kind.control, "options": row.options}
                        for name, row in choices_of(Recipe).items()],
        }  # fmt: skip
