"""The pages of units and of the command line's options."""

import click

from allanite.cli import VERBS, main
from allanite.core.units import ATOMS, SIGNALS, SPELLINGS, WORDS, convert
from allanite.terms import TERMS
from generate.markdown import shown, table


def units_page() -> list[str]:
    """The table of units, and the units of every coefficient."""
    sizes = [(f"`{name}`", shown(size), _dimension(dimension)) for name, (size, dimension) in ATOMS.items()]
    also = [(f"`{word}`", f"`{meaning}`") for word, meaning in (SPELLINGS | WORDS).items()]
    sheets = [
        (symbol, signal.name, f"`{signal.sheet[row.power]}`", f"`{signal.si[row.power]}`",
         shown(convert(1.0, signal.sheet[row.power], signal.si[row.power])))
        for symbol, row in TERMS.items() for signal in SIGNALS[:2]
    ]  # fmt: skip
    same = [
        ("deg/sqrt(h)", "deg/h/sqrt(Hz)"), ("deg/sqrt(h)", "deg/s/sqrt(Hz)"), ("deg/sqrt(h)", "rad/sqrt(s)"),
        ("ug/sqrt(Hz)", "m/s/sqrt(h)"), ("ug/sqrt(Hz)", "m/s^2/sqrt(Hz)"), ("deg/h/sqrt(h)", "rad/s^2/sqrt(Hz)"),
        ("deg/h", "rad/s"), ("ug", "m/s^2"),
    ]  # fmt: skip
    return [
        "# Units", "",
        "Internally everything is SI: rad, rad/s, m/s, m/s², s, A, V, K, T, Pa. A unit is a string made of the names "
        "below with `*`, `/`, `^`, `sqrt()` and brackets: `deg/s`, `deg/h/sqrt(Hz)`, `rad s^-1`, `°/√h`, `µg/√Hz`. "
        'Results are converted with `.to("deg/h")`.', "",
        "## Units of the coefficients", "", *table(("", "sensor", "data sheet", "SI", "1 in SI"), sheets),
        "## Frequent conversions", "",
        *table(("1", "is", ""), [(f"`{a}`", shown(convert(1.0, a, b)), f"`{b}`") for a, b in same]),
        "`rad/sqrt(s)` and `rad/s/sqrt(Hz)` are the same unit, as are `rad/s^1.5` and `rad/s^2/sqrt(Hz)`. A noise "
        "density defined as RMS noise over the square root of a bandwidth is one-sided: divide it by √2 to get N.", "",
        "## Names", "", *table(("name", "value in SI", "dimension"), sizes),
        "## Other spellings", "", *table(("spelling", "is"), also),
    ]  # fmt: skip


def _dimension(powers: tuple[float, ...]) -> str:
    names = ("rad", "m", "s", "A", "V", "K", "T", "Pa")
    return " ".join(f"{n}^{p:g}" if p != 1 else n for n, p in zip(names, powers, strict=True) if p) or "1"


def help_pages() -> list[str]:
    """What ``--help`` prints, of every verb."""
    lines = []
    for name in VERBS:
        with click.Context(main, info_name="allanite") as above:
            verb = main.get_command(above, name)
            assert verb is not None  # noqa: S101 - it is in the table
            context = click.Context(verb, info_name=name, parent=above, terminal_width=88, max_content_width=88)
            lines += [f"## {name}", "", "```text", verb.get_help(context), "```", ""]
    return lines
