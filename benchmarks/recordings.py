"""Real recordings made by others: what is identified beside what was published or computed independently.

    ALLANITE_RECORDINGS=folder python benchmarks/recordings.py [--write PATH]

The recordings are not part of the project; INDEX.md of the folder says where each comes from. "others" are figures of
an independent program, the overlapped Allan deviation at 1 s and its minimum over 0.664 (which textbooks call B).
"""

from table import begin, markdown

import os
from dataclasses import dataclass
from pathlib import Path

import allanite as al
from allanite.reporting import words

HEADINGS = (
    "recording",
    "channel",
    "N",
    "deviation at 1 s, others",
    "B",
    "minimum / 0.664, others",
    "p",
    "what is said",
)


@dataclass(frozen=True)
class Case:
    """A file, how it is read, its channels, the unit of the figures, and those of others by channel."""

    file: str
    reading: dict[str, object]
    channels: tuple[str, ...]
    unit: str
    others: dict[str, tuple[float, float]]
    window: tuple[float | None, float | None] = (None, None)
    band: tuple[float, float] | None = None


ADIS = {"rate": 100.0, "unit": "deg/s"}
MPU = {"time": "1", "unit": "deg/s"}
CASES = (
    Case("adis_16405_imu1.rda", ADIS, ("1", "2", "3"), "deg/s",
         {"1": (0.0409, 0.00757), "2": (0.0430, 0.01266), "3": (0.0387, 0.01218)}),
    Case("adis_16405_imu1.rda", ADIS, ("1", "2", "3"), "deg/s",
         {"1": (0.0409, 0.00757), "2": (0.0430, 0.01266), "3": (0.0387, 0.01218)}, band=(0.0, 5.0)),
    Case("adis_16405_imu2.rda", ADIS, ("1",), "deg/s", {"1": (0.0404, 0.01322)}, band=(0.0, 5.0)),
    Case("psins_lasergyro.imu", {}, ("gx", "gy", "gz"), "deg/h",
         {"gx": (17.35, 1.11 / 0.664), "gy": (60.7, 1.36 / 0.664), "gz": (8.71, 0.116 / 0.664)}),
    Case("psins_lasergyro.imu", {}, ("gx", "gy", "gz"), "deg/h",
         {"gx": (3.76, 0.31 / 0.664), "gy": (5.04, 0.34 / 0.664), "gz": (2.77, 0.14 / 0.664)}, window=(600.0, 900.0)),
    Case("mpu6050_static10min/mpu6050_gyroscope.mat", MPU, ("2", "3", "4"), "deg/s",
         {"2": (0.01291, 0.0042), "3": (0.00917, 0.0026), "4": (0.00935, 0.0013)}),
    Case("mpu6050_static10min/mpu6050_accelerometer.mat", {"time": "1", "unit": "g"}, ("4",), "g",
         {"4": (4.93e-4, 6.6e-5 / 0.664)}),
    Case("phone_gyro4.txt", {"unit": "rad/s"}, ("3", "4", "5"), "rad/s",
         {"3": (4.76e-4, 1.6e-4), "4": (4.47e-4, 1.7e-4), "5": (4.52e-4, 7e-5)}),
    Case("imu_tk_xsens_gyro.mat", {"time": "1", "unit": "deg/s"}, ("2",), "deg/s", {}, window=(None, 51.0)),
    Case("imu_tk_xsens_gyro.mat", {"time": "1", "unit": "deg/s"}, ("2",), "deg/s", {}),
    Case("aegiverse_fog_0917.txt", {"unit": "deg/h"}, ("fog",), "deg/h", {}),
    Case("aegiverse_fpga_gyro_0802.txt", {"time": "1", "unit": "deg/s"}, ("2",), "deg/s", {}),
    Case("vn100_car_idle.bag", {}, ("1",), "rad/s", {}),
    Case("cubeorange_sample_log_small.ulg", {}, ("1",), "rad/s", {}),
)  # fmt: skip


def rows(folder: Path, case: Case) -> list[tuple[str, ...]]:
    """One row a channel, or one with the refusal."""
    span = "" if case.window == (None, None) else f", {case.window[0] or 0:g} to {case.window[1]:g} s"
    name = case.file.split("/")[-1] + span + (f", {case.band[0]:g} to {case.band[1]:g} Hz" if case.band else "")
    recipe = al.Recipe(
        channels=case.channels, start=case.window[0], until=case.window[1], band=case.band, **case.reading
    )
    try:
        study = al.analyze(folder / case.file, recipe)
    except al.AllaniteError as error:
        return [(name, ", ".join(case.channels), "", "", "", "", "", brief(str(error).replace(f"{folder}/", "")))]
    return [(name, *row(channel, wanted, case)) for channel, wanted in zip(study.channels, case.channels, strict=True)]


def row(channel, wanted: str, case: Case) -> tuple[str, ...]:
    """Channel, N, others' N, B, others' B, p, and what is said of it."""
    if channel.fit is None:
        return (wanted, "", "", "", "", "", brief(channel.refusal))
    others = case.others.get(wanted)
    one, floor = ("", "") if others is None else (f"{v:.3g} {words.printed_unit(case.unit)}" for v in others)
    fit, said = channel.fit, []
    if fit.goodness is not None and not fit.goodness.explained:
        said.append("not explained: " + "; ".join(fit.goodness.reasons))
    said += [finding.what for finding in channel.quality.warnings]
    if fit.lines:
        said.insert(0, f"sinusoids taken out at {', '.join(f'{line.frequency:.4g}' for line in fit.lines)} Hz")
    said = [f"GM {e.words(case.unit)}, T = {e.shape[0]:.3g} s" for e in fit if e.shape] + said
    p = f"{fit.goodness.p:.2g}" if fit.goodness and fit.goodness.p > 1e-12 else "< 1e-12"
    return (wanted, printed(fit["N"], case.unit + "*sqrt(s)"), one, printed(fit["B"], case.unit), floor, p,
            brief("; ".join(said)))  # fmt: skip


def printed(estimate, unit: str) -> str:
    """Value and interval, or the limit."""
    return words.in_print(estimate, unit, 0.95)


def brief(text: str, most: int = 260) -> str:
    """Without line breaks and bars, cut."""
    text = " ".join(text.replace("|", "/").split())
    return text if len(text) <= most else text[: most - 1] + "…"


def main() -> None:
    run = begin(__doc__)
    folder = Path(os.environ.get("ALLANITE_RECORDINGS", "../shared/recordings"))
    table = [found for case in CASES for found in rows(folder, case)]
    run.publish("Real recordings", ["nothing here is random, there is no seed"], markdown(HEADINGS, table))


if __name__ == "__main__":
    main()
