"""Public recordings of the ADIS16405 beside its data sheet, as `allanite compare FILE --datasheet adis16405` has them.

    ALLANITE_RECORDINGS=folder python benchmarks/data_sheets.py [--write PATH]

The recordings are not part of the project; INDEX.md of the folder says where each comes from.
"""

from table import begin, markdown

import os
from pathlib import Path

import allanite as al
from allanite.reporting.digits import digits, printed_unit

FILES = tuple(f"adis_16405_imu{i}.rda" for i in (1, 2, 3))
UNIT = "gyro=deg/s,accel=g"  # what the files do not say

HEADINGS = ("file", "channel", "quantity", "unit", "data sheet", "measured", "95 % interval", "ratio", "remark")


def rows(file: Path) -> list[tuple[str, ...]]:
    """Every line of the data sheet beside what was measured, a row for each channel."""
    found, table = al.comparison.compare_with_sheet(file, "adis16405", unit=UNIT), []
    for channel in found:
        for m in found.measured(channel):
            size, limits = digits(m.value, m.low, m.high).plain()
            ratio, _ = digits(*m.ratio).plain()
            said = (f"{m.claim.value:g}", size, limits, ratio, str(m.remark))
            table.append((file.name, channel.record.name, m.claim.printed, printed_unit(m.claim.unit), *said))
    return table


def main() -> None:
    """Make the table."""
    run = begin(__doc__)
    folder = Path(os.environ["ALLANITE_RECORDINGS"])
    table = [row for name in FILES for row in rows(folder / name)]
    sheet = al.planning.data_sheet_named("adis16405")
    notes = ["no random numbers", f"{sheet.maker} {sheet.document}"]
    run.publish("Recordings of the ADIS16405 beside its data sheet", notes, markdown(HEADINGS, table))


if __name__ == "__main__":
    main()
