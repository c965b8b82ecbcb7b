"""Units of a quantity times time to a power, as the coefficients of noise have them."""

import re


class Units(dict[float, str]):
    """The units of a signal times time to a power, by the power: those that are named, others as they are written.

    Examples
    --------
    >>> units = Units("deg/h", "h", {1: "arcsec"})
    >>> units[1], units[0.5], units[0], units[-1.5]
    ('arcsec', 'deg/sqrt(h)', 'deg/h', 'deg/h^2.5')
    """

    def __init__(self, unit: str, second: str = "s", named: dict[float, str] | None = None) -> None:
        super().__init__(named or {})
        self.unit, self.second = unit, second

    def __missing__(self, power: float) -> str:
        return times(self.unit, power, self.second)


def times(unit: str, power: float, second: str = "s") -> str:
    """A unit times time to a power; `second` is the unit of the time.

    Examples
    --------
    >>> times("rad/s", -1.5), times("m/s^2", 1), times("V", 0.5), times("1", 1), times("s", -0.5), times("ug", -1, "h")
    ('rad/s^2.5', 'm/s', 'V*sqrt(s)', 's', 'sqrt(s)', 'ug/h')
    """
    per = re.fullmatch(rf"(.+?)/{second}(?:\^([\d.]+))?", unit)
    head, before = (per[1], -float(per[2] or 1)) if per else ("1", 1.0) if unit == second else (unit, 0.0)
    size = abs(before + power)
    time = {0.0: "", 0.5: f"sqrt({second})", 1.0: second}.get(size, f"{second}^{size:g}")
    if not time:
        return head
    if before + power < 0:
        return f"{head}/{time}"
    return time if head == "1" else f"{head}*{time}"
