"""The page of devices: how meanings are computed, the grades, and the causes by device."""

from collections.abc import Iterator
from pathlib import Path

from allanite.core.readings import IN_RUN
from allanite.interpretation.devices import DEVICES, GRADES, GRADES_SOURCE, REFERENCES, bounds_of
from generate.markdown import table


def devices_page() -> Iterator[str]:
    """The page behind the index of the noise terms."""
    yield Path(__file__).with_suffix(".md").read_text(encoding="utf-8")
    yield from ("## Grades of gyroscopes", "")
    yield from table(("grade", IN_RUN), [(grade, bounds_of(grade)) for grade in GRADES])
    yield from (f"Source: {GRADES_SOURCE}.", "")
    for device in DEVICES.values():
        title = f"{device.title[0].upper()}{device.title[1:]}"
        yield from (f"## {title}", "", f"`--device {device.name}`. {device.note}", "")
        rows = [
            (symbol, cause.name, "; ".join(cause.sources), "; ".join(cause.remedies), cause.reference)
            for symbol, cause in device.terms.items()
        ]
        yield from table(("term", "its name there", "likely sources", "what to try", "reference"), rows)
    yield from ("## References", "")
    yield from table(("cited as", "work"), REFERENCES.items())
