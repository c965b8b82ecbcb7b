"""The accuracy of typical sensors by the length of the record."""

import allanite as al
from generate.markdown import table

SENSOR_TITLES = {"mems": "MEMS", "fog": "fiber-optic", "rlg": "ring laser"}


def accuracies() -> list[str]:
    """What is included by docs/how_long.md."""
    rows = []
    for name, title in SENSOR_TITLES.items():
        planned = al.plan(al.sensor(name), rate=100.0)
        for symbol, errors in zip(planned.names, planned.errors, strict=True):
            rows.append((title, symbol, *map(_percent, errors)))
            title = ""  # noqa: PLW2901 - once a sensor
    return table(("sensor", "", "10 min", "1 h", "6 h", "24 h"), rows)


def _percent(error: float) -> str:
    return "over\N{NO-BREAK SPACE}100\N{NO-BREAK SPACE}%" if error > 1 else f"{100 * error:.2g}\N{NO-BREAK SPACE}%"
