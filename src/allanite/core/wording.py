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
