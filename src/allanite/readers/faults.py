"""What can be wrong with a clock: names, what each does to the numbers, what to do, and what forbids a rate."""

from allanite.finding import Finding

ROWS = "pass rate=... (--rate) to take the rows as evenly spaced in the order of the file"

FAULTS: dict[str, tuple[str, str]] = {
    "lost samples": (
        "they are marked as gaps, nothing is put in their place",
        "choose a window without them (--from, --until), or time='none' with rate=... (--time none --rate) to close them",
    ),
    "jitter": (
        "if the sensor itself was sampled so unevenly, the shortest averaging times are not right; if only the stamps "
        "were late, nothing is wrong",
        "take the clock of the sensor (--time) if the file has it",
    ),
    "bursty stamps": (
        "they tell when readings arrived and not when they were taken: only their mean rate is used, and a lost sample "
        "does not show",
        "take the clock of the sensor (--time) if the file has it",
    ),
    "coarse stamps": (
        "the rate is counted from the first change of stamp to the last, and samples lost in ones and twos do not show",
        "log finer stamps, or the counter of the sensor",
    ),
    "duplicate stamps": ("", "check the logger: a reading that is written twice looks quieter than it is"),
    "reversed stamps": ("", "check the logger, and sort the file by its stamps"),
    "constant stamps": ("the clock says nothing, and lost samples do not show", "take another clock (--time)"),
    "clock drift": (
        "averaging times are right to that part only",
        "let the sensor and logger warm up, or take another clock (--time)",
    ),
}
"""Name, consequence and remedy of each finding about stamps."""


def finding(
    name: str, what: str, place: tuple[float, float] | None = None, *, consequence: str = "", remedy: str = ""
) -> Finding:
    """A finding of the table; words of its own case go over those of the table."""
    usual, advice = FAULTS[name]
    return Finding(name, what, consequence or usual, remedy or advice, place)
