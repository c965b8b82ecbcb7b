"""Numbers in sentences."""


def plural(count: int, noun: str) -> str:
    """A number and its noun.

    Examples
    --------
    >>> plural(1, "gap"), plural(7, "reading")
    ('1 gap', '7 readings')
    """
    return f"{count} {noun}{'s' * (count != 1)}"


def percent(share: float) -> str:
    """A share with two digits, and all digits before the point.

    Examples
    --------
    >>> percent(0.00123), percent(0.345), percent(1.0), percent(12.3)
    ('0.12 %', '34 %', '100 %', '1230 %')
    """
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def duration(seconds: float) -> str:
    """A length of time.

    Examples
    --------
    >>> duration(42), duration(5400), duration(200_000)
    ('42 s', '1.5 h', '2.31 d')
    """
    for size, unit, least in ((86400.0, "d", 172800.0), (3600.0, "h", 3600.0), (60.0, "min", 120.0), (1.0, "s", 0.0)):
        if seconds >= least:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
