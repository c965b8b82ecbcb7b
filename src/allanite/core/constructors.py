"""The functions that make terms, such as ``N(0.01, "deg/sqrt(h)")``: one for each row of `TERMS`."""

from inspect import Parameter, Signature
from typing import Protocol

from allanite.terms import TERMS

from .aliases import public
from .model import Term, term
from .units import SIGNALS


class Constructor(Protocol):
    """A function that makes the term of one symbol from a coefficient, its unit, and the parameters by name."""

    def __call__(self, value: float, unit: str, **shape: float) -> Term: ...  # noqa: D102


def constructor(symbol: str) -> Constructor:
    """The function that makes a term of this symbol, from the term's row of `TERMS`.

    Examples
    --------
    >>> print(constructor("GM")(0.1, "deg/h", time_constant=20.0))
    GM = 0.1 deg/h with time constant 20 s
    """
    row, usual = TERMS[symbol], (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
    named = [Parameter(name, usual[0], annotation=kind) for name, kind in (("value", float), ("unit", str))]
    named += [
        Parameter(p.name, usual[1], annotation=float, default=Parameter.empty if p.default is None else p.default)
        for p in row.parameters
    ]
    signature = Signature(named, return_annotation=Term)

    def build(value: float, unit: str, **shape: float) -> Term:
        given = signature.bind(value, unit, **shape)
        given.apply_defaults()
        return term(symbol, value, unit, tuple(given.arguments[p.name] for p in row.parameters))

    sheet = SIGNALS[0].sheet[row.power]
    example = "".join(f", {p.name}={p.typical:g}" for p in row.parameters if p.default is None)
    units = "".join(f"; {p.name} in {p.unit}" for p in row.parameters if p.unit)
    build.__name__ = build.__qualname__ = symbol
    build.__doc__ = (
        f"{row.title.capitalize()}: {row.meaning}.\n\n"
        f"For example ``{symbol}({row.typical:g}, {sheet!r}{example})``{units}."
    )
    build.__signature__ = signature  # type: ignore[attr-defined]
    build.__annotations__ = {name: one.annotation for name, one in signature.parameters.items()}
    return public(build)


Q, N, B, K = (constructor(symbol) for symbol in ("Q", "N", "B", "K"))
R, GM, Sine = (constructor(symbol) for symbol in ("R", "GM", "Sine"))
F, GMA, GM2, GML, W = (constructor(symbol) for symbol in ("F", "GMA", "GM2", "GML", "W"))
