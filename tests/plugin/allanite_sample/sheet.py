"""The data sheet of a sensor."""

from allanite.planning.datasheets import Claim, DataSheet

SHEET = DataSheet(
    name="SG-1",
    maker="Sample",
    document="SG-1 data sheet, Rev. A",
    claims=(
        Claim("gyro", "random walk", "Angle random walk", 0.2, "deg/sqrt(h)", place="page 2, Table 1"),
        Claim("gyro", "bias stability", "Bias stability", 1.0, "deg/h", place="page 2, Table 1"),
    ),
)
