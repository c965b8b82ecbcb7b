"""The tables of the fields of every target."""

from collections.abc import Iterator

from allanite.exporting.exports import EXPORTS
from generate.markdown import table


def exports_page() -> Iterator[str]:
    """What is included by docs/log_to_filter.md."""
    for row in EXPORTS.values():
        forms = ", ".join(f"`{suffix}`" for suffix in row.forms)
        yield from (f"### {row.name}", "", f"{row.title}; {forms}.", "")
        if row.fields:
            rows = [
                (f"`{f.full}`", f.sensor, f"`{f.unit}`", f"`{f.formula}`", *f.nature, _span(f.span)) for f in row.fields
            ]
            yield from table(("field", "sensor", "unit", "is", "kind", "often mistaken for", "wrong by", "range"), rows)
        step = (
            [f"f is 1/{row.step:g} s, the rate of the filter's steps, whatever the sampling rate"] if row.step else []
        )
        yield from (f"- {_sentence(note)}" for note in (*step, *row.notes, f"source: {row.source}"))
        yield ""


def _span(span: tuple[float, float]) -> str:
    return "" if span[1] == float("inf") else f"{span[0]:g} to {span[1]:g}"


def _sentence(note: str) -> str:
    """A note that Markdown leaves as it is."""
    return note.replace("*", r"\*").replace("_", r"\_")
