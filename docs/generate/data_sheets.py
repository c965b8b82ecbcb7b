"""The table of data sheets, and the recordings of the ADIS16405 beside theirs."""

from collections.abc import Iterator
from pathlib import Path

from allanite.planning.datasheets import DATASHEETS, QUANTITIES
from allanite.reporting.digits import printed_unit
from generate.markdown import table, table_of, typeset

COMPARED = ("Random Walk", "Stability")  # ends of the names of the quantities that the model of a data sheet is made of


def data_sheets_page() -> Iterator[str]:
    """The page of all data sheets."""
    yield from ("# Table of data sheets", "")
    yield from ("What is printed in the document of each sensor, and [what follows from it](../data_sheet.md).", "")
    for name, sheet in DATASHEETS.items():
        yield from (f"## {name}", "", f"{sheet.maker}. Document: {sheet.document}.", "")
        rows = [
            (c.sensor, c.printed, f"{c.value:g}", printed_unit(c.unit), c.limit, c.conditions.replace("_", r"\_"),
             c.place, printed_unit(str(c.term or "")))
            for c in sheet.claims
        ]  # fmt: skip
        yield from table(("sensor", "quantity", "value", "unit", "", "conditions", "place", "is"), rows)


def quantities_table() -> Iterator[str]:
    """What a quantity is of a coefficient."""
    yield from table(
        ("coefficient", "follows from"), [(how.symbol, typeset(how.meaning)) for how in QUANTITIES.values()]
    )


def compared_page(results: Path) -> Iterator[str]:
    """What was measured, over what the data sheet says: a column a recording."""
    every = (row for row in table_of(results, "Data sheets") if row["file"].startswith("adis"))
    rows = [row for row in every if row["quantity"].endswith(COMPARED)]
    files = list(dict.fromkeys(row["file"] for row in rows))
    by_cell = {(row["channel"], row["quantity"], row["file"]): row for row in rows}
    lines = []
    for channel, quantity in dict.fromkeys((row["channel"], row["quantity"]) for row in rows):
        measured = [by_cell[channel, quantity, file] for file in files]
        ratios = (f"{'≤ ' if row['remark'] else ''}{row['measured']} (× {row['ratio']})" for row in measured)
        lines.append((channel, quantity, f"{measured[0]['data sheet']} {measured[0]['unit']}", *ratios))
    yield from table(("channel", "quantity", "data sheet", *(f"`{file}`" for file in files)), lines)
