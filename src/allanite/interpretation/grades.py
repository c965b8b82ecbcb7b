"""Grades of gyroscopes by their in-run bias stability: a convention, not a standard.

There are none by angle random walk: the bounds of overviews contradict the data sheets of tactical sensors.
"""

from dataclasses import dataclass

from allanite.core.units import convert
from allanite.phrases.phrase import say

IN_RUN = (
    "navigation and consumer: N. El-Sheimy, A. Youssef, Inertial sensors technologies for navigation applications, "
    "Satellite Navigation 1 (2020) 2, doi:10.1186/s43020-019-0001-5, table 1 (gyroscope drift below 0.01 deg/h; "
    "0.1 deg/s); tactical against industrial: N. Miller, D. Robbins, J. Bessette, Benefits of a tactical grade IMU in "
    "low-cost GNSS/INS systems, RoboticsTomorrow, July 2021 (in-run bias stability of 5 deg/h)"
)


@dataclass(frozen=True)
class Grade:
    """Sensors whose coefficient is below `below`, and not below that of the row before; the last row has no bound."""

    name: str
    below: float


@dataclass(frozen=True)
class Scale:
    """The grades by one quantity of a gyroscope."""

    # title, unit: the quantity, and the unit of its bounds
    title: str
    unit: str
    grades: tuple[Grade, ...]  # the best first
    source: str

    def of(self, value: float, unit: str) -> Grade:
        """The grade of a value.

        Examples
        --------
        >>> BY_MINIMUM.of(1.2, "deg/h").name
        'Tactical grade'
        """
        size = convert(value, unit, self.unit)
        return next(grade for grade in self.grades if size < grade.below)

    def words(self, grade: Grade) -> str:
        """The bounds of a grade: ``0.01 to 5 deg/h``."""
        i = self.grades.index(grade)
        low = f"{self.grades[i - 1].below:g}" if i else ""
        if not low:
            return say("below {limit:g} {unit}", limit=grade.below, unit=self.unit)
        if grade.below == float("inf"):
            return say("from {limit} {unit} on", limit=low, unit=self.unit)
        return say("{low} to {high:g} {unit}", low=low, high=grade.below, unit=self.unit)


BY_MINIMUM = Scale(
    say("in-run bias stability"),
    "deg/h",
    (
        Grade(say("Navigation grade"), 0.01),
        Grade(say("Tactical grade"), 5.0),
        Grade(say("Industrial grade"), 360.0),
        Grade(say("Consumer grade"), float("inf")),
    ),
    IN_RUN,
)
SCALES = (BY_MINIMUM,)
