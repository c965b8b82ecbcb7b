"""Device: what each noise term is called in one kind of device, where it comes from, what to try; grades."""

import math
from dataclasses import dataclass
from itertools import pairwise

from allanite.phrases.phrase import say

# none by angle random walk: the bounds of overviews contradict the data sheets of tactical sensors
GRADES: dict[str, float] = {
    say("Navigation grade"): 0.01,
    say("Tactical grade"): 5.0,
    say("Industrial grade"): 360.0,
    say("Consumer grade"): math.inf,
}
"""Grades of gyroscopes, the best first, each with the in-run bias stability, deg/h, that it is below."""

GRADES_SOURCE = (
    "navigation and consumer: N. El-Sheimy, A. Youssef, Inertial sensors technologies for navigation applications, "
    "Satellite Navigation 1 (2020) 2, doi:10.1186/s43020-019-0001-5, table 1 (gyroscope drift below 0.01 deg/h; "
    "0.1 deg/s); tactical against industrial: N. Miller, D. Robbins, J. Bessette, Benefits of a tactical grade IMU in "
    "low-cost GNSS/INS systems, RoboticsTomorrow, July 2021 (in-run bias stability of 5 deg/h)"
)


def grade_of(stability: float) -> str:
    """The grade of an in-run bias stability in deg/h."""
    return next(grade for grade, below in GRADES.items() if stability < below)


def bounds_of(grade: str) -> str:
    """The bounds of a grade: ``0.01 to 5 deg/h``."""
    low, high = dict(zip(GRADES, pairwise((0.0, *GRADES.values())), strict=True))[grade]
    if not low:
        return say("below {limit:g} {unit}", limit=high, unit="deg/h")
    if math.isinf(high):
        return say("from {limit} {unit} on", limit=f"{low:g}", unit="deg/h")
    return say("{low} to {high:g} {unit}", low=f"{low:g}", high=high, unit="deg/h")


@dataclass(frozen=True)
class Cause:
    """A noise term in a device."""

    name: str  # what the term is called there
    # sources, remedies: where it is likely to come from, and what to try
    sources: tuple[str, ...]
    remedies: tuple[str, ...]
    reference: str  # who says so, with page or section; keys of `REFERENCES`


@dataclass(frozen=True)
class Device:
    """A kind of device."""

    name: str
    title: str
    signals: tuple[str, ...]  # names of the signals that its table is about
    terms: dict[str, Cause]  # by symbol
    note: str = ""  # how it has to be measured, or what else must be known to read the table


REFERENCES: dict[str, str] = {
    say("Gazaryan"): say(
        "I. R. Gazaryan, A. Yu. Tairov, V. K. Ponomarev, Application of Allan variance for the analysis of random "
        "errors of gyroscope stabilization systems, Izvestiya of Tula State University, Technical Sciences, "
        "pp. 143-153 (in Russian)"
    ),
    say("Geng 2021"): say(
        "M. Geng, Y. Ren, Y. Fan, L. Wang, C. Yu, Random error test and error source analysis of MSCSG, Journal of "
        "Beijing University of Aeronautics and Astronautics 47 (2021) 1697-1704, "
        "doi:10.13700/j.bh.1001-5965.2020.0269 (in Chinese)"
    ),
    say("Enin 2017"): say(
        "V. N. Enin, I. V. Saneev, Science and Education of the Bauman MSTU 2017, no. 2, pp. 52-69 (in Russian)"
    ),
    say("IEEE 952"): say(
        "IEEE Std 952-1997, Specification Format Guide and Test Procedure for Single-Axis Interferometric Fiber Optic "
        "Gyros, Annex C (noise terms and their origin)"
    ),
    say("IEEE 647"): say(
        "IEEE Std 647-2006, Specification Format Guide and Test Procedure for Single-Axis Laser Gyros, Annex C (noise "
        "terms and their origin)"
    ),
    say("Tehrani 2020"): say(
        "M. M. Tehrani, S. Soltanieh, Ring laser gyro: noise improves performance, arXiv:2005.09749, abstract"
    ),
    say("arXiv:2208.11213"): say(
        "Simultaneous suppression of thermal phase noise and relative intensity noise in a fiber optic gyroscope, "
        "2022, abstract"
    ),
    say("Shupe 1980"): say(
        "D. M. Shupe, Thermally induced nonreciprocity in the fiber-optic interferometer, Applied Optics 19 (1980) "
        "654-655, doi:10.1364/AO.19.000654"
    ),
    say("Zhuo"): say(
        "Zhuo Chao, Du Jian-Bang, Shupe effect of fiber sensing coils in multidimensional thermal field, abstract"
    ),
    say("Woodman 2007"): say(
        "O. J. Woodman, An introduction to inertial navigation, Technical report UCAM-CL-TR-696, University of "
        "Cambridge, 2007"
    ),
    say("Shiau"): say(
        "J.-K. Shiau, C.-X. Huang, M.-Y. Chang, Noise characteristics of MEMS gyro's null drift and temperature "
        "compensation, abstract"
    ),
    say("Koo 2012"): say(
        "M. Koo, S. H. Oh, D.-H. Hwang, Design of an error model for performance enhancement of MEMS IMU-based GPS/INS "
        "integrated navigation systems, 2012, abstract"
    ),
    say("allanite"): say("what follows from the definition of the term, or what this program can do about it"),
}
"""What the tables cite."""
