"""Names of columns that define their units: those of sensor_msgs, PX4 and EuRoC."""

import re
from dataclasses import replace
from typing import NamedTuple

from .column import FileColumn


class Convention(NamedTuple):
    """Names that define a unit: what defines them, a pattern of names in lower case, and the unit."""

    family: str
    names: re.Pattern[str]
    unit: str


_ABOVE = r"(?:.*[./])?"
CONVENTIONS = (
    Convention("sensor_msgs/Imu", re.compile(_ABOVE + "angular_velocity[./][xyz]"), "rad/s"),
    Convention("sensor_msgs/Imu", re.compile(_ABOVE + "linear_acceleration[./][xyz]"), "m/s^2"),
    Convention("PX4", re.compile(_ABOVE + r"gyro_rad(?:\[[0-2]\]|[._][0-2])"), "rad/s"),
    Convention("PX4", re.compile(_ABOVE + r"accelerometer_m_s2(?:\[[0-2]\]|[._][0-2])"), "m/s^2"),
    Convention("EuRoC", re.compile("w_rs_s_[xyz]"), "rad/s"),
    Convention("EuRoC", re.compile("a_rs_s_[xyz]"), "m/s^2"),
    # the app writes 3, 4 and 5 before acceleration, angular rate and magnetic field
    Convention("Sensorstream IMU+GPS", re.compile("sensor 3 [xyz]"), "m/s^2"),
    Convention("Sensorstream IMU+GPS", re.compile("sensor 4 [xyz]"), "rad/s"),
)
"""The units of the definitions of messages and data sets: sensor_msgs/Imu.msg, SensorCombined.msg of PX4, ASL."""

_SHORT = {
    "gyro": Convention("sensor_msgs/Imu", re.compile("angular_velocity_[xyz]"), "rad/s"),
    "accelerometer": Convention("sensor_msgs/Imu", re.compile("linear_acceleration_[xyz]"), "m/s^2"),
}
"""Names of sensor_msgs without dots, which other files may have too: they count only if both sensors have them."""


def convention_of(column: FileColumn) -> Convention | None:
    """The convention that gave a column its unit; None if its header did."""
    every = (*CONVENTIONS, *_SHORT.values())
    return next((row for row in every if _names(row, column) and column.unit == row.unit), None)


def applied(columns: tuple[FileColumn, ...]) -> tuple[FileColumn, ...]:
    """The columns with the units that their names define, where their headers have none."""
    short = all(any(_names(convention, column) for column in columns) for convention in _SHORT.values())
    known = (*CONVENTIONS, *(_SHORT.values() if short else ()))
    united = list[FileColumn]()
    for column in columns:
        named = next((convention for convention in known if _names(convention, column)), None)
        # gyro_rad[0] looks like an angle in rad
        fits = named is not None and not column.kind and not column.text and column.unit in ("", "rad")
        united.append(replace(column, unit=named.unit) if named is not None and fits else column)
    return tuple(united)


def _names(convention: Convention, column: FileColumn) -> bool:
    return bool(convention.names.fullmatch((column.header or column.name).strip().lower()))
