"""What a column's header states: name, unit, and whether the column is an inertial signal."""

import re
from functools import lru_cache

from allanite.core.errors import UnitError
from allanite.core.units import Signal, Unit, latin, signal_with, unit_of

_INSIDE = re.compile(r"[^\[\](){}]*(?:\([^()]*\)[^\[\](){}]*)*")
"""Content of the brackets of a unit: no brackets except pairs of round ones."""

LONGEST_HEADER = 200  # maximum number of characters of a header, and of a unit

_TIME = unit_of("s").dimension

# suffixes of names such as gyro_x_rad_per_s: loggers avoid slashes in names
SUFFIXES: dict[str, str] = {
    "dps": "deg/s", "degps": "deg/s", "deg_per_s": "deg/s", "deg_per_sec": "deg/s", "deg_s": "deg/s", "mdps": "mdeg/s",
    "dph": "deg/h", "deg_per_h": "deg/h", "deg_per_hr": "deg/h", "deg_h": "deg/h", "deg_hr": "deg/h",
    "rps": "rad/s", "radps": "rad/s", "rad_per_s": "rad/s", "rad_per_sec": "rad/s", "rad_s": "rad/s", "rads": "rad/s",
    "mrad_per_s": "mrad/s", "urad_per_s": "urad/s",
    "mps2": "m/s^2", "m_per_s2": "m/s^2", "m_s2": "m/s^2", "ms2": "m/s^2", "m_per_s_2": "m/s^2", "mpss": "m/s^2",
    "g": "g", "mg": "mg", "ug": "ug", "mgal": "mGal", "mps": "m/s", "m_per_s": "m/s",
    "arcsec": "arcsec", "urad": "urad", "mrad": "mrad", "rad": "rad", "deg": "deg", "mdeg": "mdeg",
    "s": "s", "sec": "s", "secs": "s", "seconds": "s", "ms": "ms", "msec": "ms", "us": "us", "usec": "us",
    "ns": "ns", "nsec": "ns",
}  # fmt: skip

TIME_NAMES: dict[str, str] = {  # names of a clock, with the unit that some of them imply
    "time": "", "t": "", "timestamp": "", "timestamps": "", "stamp": "", "stamps": "", "clock": "", "epoch": "",
    "elapsed": "", "datetime": "", "tow": "", "utc": "",
    "zeit": "", "zeitstempel": "", "uhrzeit": "", "temps": "", "tiempo": "", "tempo": "",
    "second": "s", "seconds": "s", "sec": "s", "secs": "s", "s": "s", "millis": "ms", "milliseconds": "ms", "ms": "ms",
    "micros": "us", "microseconds": "us", "us": "us", "nanoseconds": "ns", "ns": "ns",
    "msec": "ms", "usec": "us", "nsec": "ns", "nsecs": "ns", "nanosec": "ns", "nanosecs": "ns",
    "время": "", "t,с": "s", "时间": "", "时间戳": "", "时刻": "", "采样时间": "", "時間": "", "時刻": "", "시간": "",
}  # fmt: skip

_RAW = ("-", "", "lsb", "lsbs", "count", "counts", "raw", "digit", "digits", "adc", "bit", "bits", "a.u.", "au")

_COUNTS = re.compile(
    r"\[ *(lsbs?|counts?|raw|digits?|adc|bits?) *\]|\( *(lsbs?|counts?|raw|digits?|adc|bits?) *\)|[_ ](lsbs?|counts?)$"
)
"""What a header says of numbers as they come from a converter."""

_INCREMENT = re.compile(r"(delta_?|(^|[^a-z])d(el)?_?)(ang(?!ul)|theta|vel|v(_?[xyz])?$)|vel_?inc")

_OTHER = re.compile(  # a name that begins like this, up to its end or a number, is not an inertial signal
    r"(temp|temperature|t_?deg_?c|index|idx|id|count|counter|packet|seq|sequence|samples?|frame|row|no|n|status|flags?|date|"
    r"mag|magnetometer|magnetic|m_?[xyz]|baro|pressure|press|humidity|alt|altitude|lat|latitude|lon|longitude|volt|voltage|"
    r"battery|quat|quaternion|q_?[0-3wxyz]|roll|pitch|yaw|heading|euler|heater|ori_?inc|dq|sensor_5)([^a-z]|$)|.*temperature|.*[^a-z](temp|cnt|ctr)([^a-z]|$)|"
    r"(номер|сч[её]тчик|пакет|кадр|статус|флаг|магн|давлен|высот|широт|долгот|крен|тангаж|курс|напряж|ток)|"
    r"(序号|编号|计数|帧|状态|标志|磁|气压|压力|湿度|高度|纬度|经度|横滚|滚转|俯仰|航向|偏航|姿态|电压|电流)"
)
_TEMPERATURE = re.compile(r"((^|[^a-z])(temp|temperature)|(^|[^a-zа-я])темпер[а-я]*|温度)(_?[0-9xyz])*$")
_LENGTH = re.compile(
    r"free_?acc|(absolute|magnitude|norm|модуль|模)($|_(acc|gyr|ang|lin|rate|уск|угл))|.*_(norm|magnitude|abs)$"
)
"""A name of the length of a vector, or of an acceleration without gravity: not the output of a sensor."""

_IDENTIFIER = re.compile(
    r"(^|[^a-z])(ids?|dt|seq|sequence|instance|index|idx|status|state|flags?|valid|health|timestamp_relative|counter|cnt|ctr|"
    r"(error|calib(ration)?|message|samples?|packet)_?counts?)[^a-z]*$|(^|[^a-z])clip(s|ped|ping)?([^a-z]|$)|"
    r"covariance|orientation|sample_?time_?fine"  # a count of 10 kHz of Xsens
)
"""A name of what is not a sample, whichever sensor it names beside: gyro_device_id, delta_angle_dt."""

_DRIVER = re.compile(r"temp|deg_?c|baro|press|humid|volt|battery|heater|темпер|давлен|напряж|温度|压力|气压|湿度|电压")
# in English, German, French, Spanish, Italian, Portuguese, Russian, Chinese, Japanese and Korean
_BY_NAME = {
    "gyro": re.compile(
        r"gyr|^[gwω][_ ]?[xyz]$|omega|ang(ul|ol)ar|angulaire|rot(ation)?_?rate|turn_?rate|rate_of_turn|^fog|^d_?theta"
        r"|(delta_?|(^|[^a-z])d(el)?_?)(ang|theta)|drehrate|drehgeschw|winkelgeschw|kreisel|vitesse_de_rot"
        r"|gir[oó](s|m|_?[xyz]$)|гиро|^дус|угл.{0,40}скорост|陀螺|角速|ジャイロ|자이로|각속도"
    ),
    "accelerometer": re.compile(
        r"acc(?!ura|ess)|^[af][_ ]?[xyz]$|d(el|elta)_?v|(^|[^a-z])d_?v(el)?_?[xyz]?$|vel_?inc|aceler|(?<!winkel)beschl"
        r"|specific_?force|spezifische_kraft|(force|fuerza|forza|força)_(sp[eé]c|espec)"
        r"|аксел|(?<!угловое_)ускорен|удельн.{0,3}_сил|(?<![角각])(加速度|가속도)|加表|加计|比力|비력"
    ),
}
_FULL_WIDTH = str.maketrans("（）［］：，／　", "()[]:,/ ")  # signs of Chinese texts, and the usual ones


def split(header: str) -> tuple[str, str]:
    """The name and the unit in a header; the unit is empty if there is none."""
    header = header.translate(_FULL_WIDTH).strip()
    if len(header) > LONGEST_HEADER:
        return header, ""
    name, unit = _bracketed(header)
    if unit is None:  # it may stand after a comma, as in Russian tables: ``Время, с``
        before, _, after = (part.strip() for part in header.rpartition(","))
        if before and not after.isdigit() and known(after) is not None:
            name, unit = before, after
    if unit is not None:
        if unit.lower() in _RAW and name:
            return name, ""
        if not (unit.isdigit() or unit.lower() in ("x", "y", "z")):
            return name or header, latin(unit)
    tokens = re.sub(r" \d+$", "", without_number(header)).lower().replace(".", "_").split("_")
    for count in range(min(4, len(tokens) - 1), 0, -1):
        unit = SUFFIXES.get("_".join(tokens[-count:]))
        if unit:
            return header, unit
    return header, ""


def without_number(header: str) -> str:
    """A header without a number, or a letter of an axis, in brackets at its end: ``difference [1]``."""
    return re.sub(r"\s*[\[(]\w*[\])]$", "", header)


def _bracketed(header: str) -> tuple[str, str | None]:
    """The text before the brackets at the end of a header and the text in them; None if there are none."""
    opening = (i for i, letter in enumerate(header) if letter in "[({") if header[-1:] in tuple("])}") else ()
    for at in opening:
        if _INSIDE.fullmatch(header, at + 1, len(header) - 1):
            return header[:at].strip(), header[at + 1 : -1].strip()
    return header, None


@lru_cache(maxsize=1024)  # a header is asked about many times, and an unknown unit costs a search for similar ones
def known(unit: str) -> Unit | None:
    """The unit; None if it is unknown or empty."""
    try:
        return unit_of(unit) if len(unit) <= LONGEST_HEADER else None
    except UnitError:
        return None


def signal_of(unit: str) -> Signal | None:
    """The signal with this unit, or whose time integral has it; None if there is none, or the unit is 1."""
    size = known(unit)
    if size is None:
        return None
    signal = signal_with(size.dimension) or signal_with(size.dimension, 1)
    return None if signal is None or signal.name == "dimensionless" else signal


def inertial(unit: str) -> Signal | None:
    """The sensor whose output, or its integral, has this unit; None if it is neither gyro nor accelerometer."""
    signal = signal_of(unit)
    return signal if signal is not None and signal.inertial else None


def is_time(unit: str) -> bool:
    """Whether this is a unit of time."""
    size = known(unit)
    return size is not None and size.dimension == _TIME


def clock_rank(name: str) -> int:
    """How certainly a name is that of a clock: 0 certainly, 1 perhaps, 2 not. A capital T may be a temperature."""
    lower = _bare(name)
    if lower in TIME_NAMES:
        return 1 if name.strip() == "T" else 0
    return 1 if re.search(r"time(?!out|fine|_fine)|stamp|elapsed|врем|时间|时刻", lower) else 2


def clock_unit(name: str) -> str:
    """The unit implied by the name of a clock, such as ``millis``."""
    return TIME_NAMES.get(_bare(name), "")


def is_other(name: str, unit: str = "") -> bool:
    """Whether a name is that of something other than an inertial signal: a temperature, a counter, a compass."""
    # A unit of an inertial sensor overrides it, as in ``yaw [deg/s]``, except for the compass, whose G is the gauss,
    # for temperatures, and for the length of a vector.
    bare = _bare(name)
    if _TEMPERATURE.search(bare) or _LENGTH.match(bare) or (identifies(name) and not inertial(unit)):
        return True
    if bare.startswith("m"):
        return bool(_OTHER.match(bare))
    if inertial(unit) or re.search(r"rate|gyr|acc", bare):
        return False
    return bool(_OTHER.match(bare)) or name.strip() == "T"


def is_driver(name: str, unit: str = "") -> bool:
    """Whether a name or unit is that of a possible influence on a sensor: a temperature, a pressure, a supply."""
    signal = signal_of(unit)
    if signal is not None:
        return signal.name in ("temperature", "voltage", "current", "pressure")
    bare = _bare(name)
    return is_other(name, unit) and bool(_DRIVER.search(bare) or name.strip() == "T")


def identifies(name: str) -> bool:
    """Whether a name is that of an identifier, a state or a count, not of samples."""
    return bool(_IDENTIFIER.search(_bare(re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name))))


def is_raw(header: str) -> bool:
    """Whether a header says that the numbers are counts: ``gx [LSB]``."""
    return bool(_COUNTS.search(header.lower()))


def is_increment(name: str) -> bool:
    """Whether a name is that of increments of an angle or a velocity: ``deltaThetaX``, ``delta_velocity_x``."""
    return bool(_INCREMENT.search(_bare(name)))


def sensor_by_name(name: str) -> str:
    """The sensor that a name suggests; empty if none, both, or an identifier."""
    if identifies(name):
        return ""
    suggested = [sensor for sensor, pattern in _BY_NAME.items() if pattern.search(_bare(name))]
    return suggested[0] if len(suggested) == 1 else ""


def _bare(name: str) -> str:
    return name.strip().lower().replace(" ", "_")
