"""The pages of units, of the command line's options, and of the Python names."""

from collections.abc import Iterable

import click

import allanite as al
from allanite.cli import VERBS, main
from allanite.core.units import ATOMS, SIGNALS, SPELLINGS, convert
from allanite.terms import TERMS
from generate.markdown import shown, table


def units_page() -> list[str]:
    """The table of units, and the units of every coefficient."""
    sizes = [(f"`{name}`", shown(size), _dimension(dimension)) for name, (size, dimension) in ATOMS.items()]
    also = [(f"`{word}`", f"`{meaning}`") for word, meaning in SPELLINGS.items()]
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
        "Inside, everything is SI: rad, rad/s, m/s, m/s², s, A, V, K, T. A unit is a text, made of the names below "
        "with `*`, `/`, `^`, `sqrt()` and brackets: `deg/s`, `deg/h/sqrt(Hz)`, `rad s^-1`, `°/√h`, `µg/√Hz`. Results "
        'are converted with `.to("deg/h")`.', "",
        "## Of the coefficients", "", *table(("", "sensor", "data sheet", "SI", "1 in SI"), sheets),
        "## Conversions often needed", "",
        *table(("1", "is", ""), [(f"`{a}`", shown(convert(1.0, a, b)), f"`{b}`") for a, b in same]),
        "`rad/sqrt(s)` and `rad/s/sqrt(Hz)` are one unit, as are `rad/s^1.5` and `rad/s^2/sqrt(Hz)`. A density that is "
        "defined as effective value over the square root of a bandwidth is one-sided: divide it by √2 to get N.", "",
        "## Names", "", *table(("name", "size in SI", "of"), sizes),
        "## Other spellings", "", *table(("word", "stands for"), also),
    ]  # fmt: skip


def _dimension(powers: tuple[float, ...]) -> str:
    names = ("rad", "m", "s", "A", "V", "K", "T")
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


def api_page() -> list[str]:
    """Every public name with its docstring."""
    names = [name for name in dir(al) if not name.startswith("_")]
    things = {name: getattr(al, name) for name in names}
    functions = [n for n in names if callable(things[n]) and not isinstance(things[n], type)]
    classes = [n for n in names if isinstance(things[n], type)]
    errors = [n for n in classes if issubclass(things[n], Exception)]
    order = {"functions": [n for n in functions if n not in TERMS], "terms": [n for n in functions if n in TERMS]}
    lines = [
        "# Python", "", "Values are frozen and go through plain functions; everything inside is SI. "
        "`import allanite as al` is meant below.", "",
    ]  # fmt: skip
    lines += ["## Functions", "", *_directives("autofunction", order["functions"])]
    lines += ["## Terms of a model", "", *_directives("autofunction", order["terms"])]
    lines += ["## Values", "", *_directives("autoclass", [n for n in classes if n not in errors], ":members:")]
    lines += ["## Errors", "", *_directives("autoclass", errors, ":show-inheritance:")]
    tables = ", ".join(f"`al.{name}`" for name in names if isinstance(things[name], dict))
    return [*lines, "## Tables", "", f"{tables}: what there is, by name; each row says what it is."]


def _directives(kind: str, names: Iterable[str], *options: str) -> list[str]:
    lines = ["```{eval-rst}"]
    for name in names:
        lines += [f".. {kind}:: allanite.{name}", *(f"   {option}" for option in options), ""]
    return [*lines, "```", ""]
