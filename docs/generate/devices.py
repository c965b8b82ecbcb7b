"""The tables of causes by device, and of grades."""

from collections.abc import Iterator

from allanite.interpretation.device import REFERENCES, SCALES
from allanite.interpretation.devices import DEVICES
from generate.markdown import table


def devices_page() -> Iterator[str]:
    """What is included by docs/devices.md."""
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
