"""The page of devices: how meanings are computed, the grades, and the causes by device."""

from collections.abc import Iterator
from pathlib import Path

from allanite.interpretation.device import REFERENCES, SCALES
from allanite.interpretation.devices import DEVICES
from generate.markdown import table


def devices_page() -> Iterator[str]:
    """The page behind the index of the noise terms."""
    yield Path(__file__).with_suffix(".md").read_text(encoding="utf-8")
    yield from ("## Grades of gyroscopes", "")
    for scale in SCALES:
        rows = [(grade.name, scale.words(grade)) for grade in scale.grades]
        yield from table(("grade", scale.title), rows)
        yield from (f"Source: {scale.source}.", "")
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
