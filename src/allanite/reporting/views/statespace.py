"""How state spaces are shown: their states, matrices that can be pasted into a program, and what they leave out."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from allanite.core.curve import Curve
from allanite.core.fit import Fit
from allanite.phrases.phrase import join, say
from allanite.reporting import figures
from allanite.reporting.sheet import Code, Column, Drawing, Note, Part, Plot, Table
from allanite.statespace import StateSpace
from allanite.statespace.build import MEASUREMENTS
from allanite.study.modelled import Modelled, StateSpaces

from . import View
from .modelled import ModelledForm, job_rows

EQUATIONS = say("matrices in SI units: x' = Phi x + w, sample = H x + v")
KEY = say(
    "Phi is the transition over one interval, Qd the covariance of w, R the variance of v, P0 the covariance of the "
    "states at the start. The table shows the diagonals."
)
DRAWN = say("Allan deviation of the state space, of the model, and as measured; below, the state space over the model.")


@partial(
    ModelledForm,
    say("model"),
    say("State space of"),
    say("state space of an inertial sensor's noise"),
    KEY,
    lambda space: join("; ", (f"{space.rate:.8g} Hz", str(space.model))),
)
def space_form(space: StateSpace, channel: Modelled | None) -> Iterator[Part]:
    """What it leaves out, its states, and its matrices."""
    low, high = space.tau
    within = say(
        "Allan deviation within {ripple:.2g} % of the model's from {low:g} to {high:g} s",
        ripple=100 * space.ripple,
        low=low,
        high=high,
    )
    yield Note(join("; ", (within, MEASUREMENTS[space.measurement].meaning)))
    yield from (Note(note) for note in space.notes)
    scope = channel.fit.scope if channel is not None and channel.fit is not None else None
    if scope is not None and scope.filter is not None:
        yield Note(
            say(
                "the low-pass filter is not among the states: samples closer together than {time:.2g} s are correlated",
                time=1 / scope.filter.cutoff,
            )
        )
    headings, rows = space.rows()
    numbers = (Column(heading, form=".6g") for heading in headings[2:])
    heads = (Column(""), Column(say("state"), "name"), Column(say("unit"), "unit"), *numbers)
    yield Table(heads, [[i, *row] for i, row in enumerate(rows, 1)])
    label = say("Allan deviation of the state space and of the model")
    yield Drawing(lambda: _plot([channel or space], None, 0.95), label, DRAWN)
    matrices = {label: getattr(space, label) for label in ("Phi", "Qd", "H", "R", "P0")}
    yield Code("\n".join(_matrix(label, matrix) for label, matrix in matrices.items() if len(matrix)), EQUATIONS)


def _matrix(label: str, matrix: np.ndarray) -> str:
    """As Python, JSON and MATLAB-like programs read it, to the last digit."""
    cells = [[repr(float(v)) if v else "0" for v in row] for row in matrix]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    rows = (", ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in cells)
    return f"{label} = [[" + f"],\n{' ' * (len(label) + 4)}[".join(rows) + "]]"


def _plot(values: Sequence[Any], _: Fit | None, level: float) -> Plot:
    """A state space, perhaps with measured curves after it; or those of all channels, each with its own curve."""
    spaces: list[tuple[str, StateSpace, list[Curve]]] = []
    for value in values:
        if isinstance(value, Curve):
            spaces[-1][2].append(value)
        elif isinstance(value, StateSpaces | Modelled):
            channels = value.channels if isinstance(value, StateSpaces) else (value,)
            known = [(c.name, c.result, [c.curve] if c.curve else []) for c in channels]
            spaces += [(name, space, curves) for name, space, curves in known if isinstance(space, StateSpace)]
        else:
            spaces.append(("", value, []))
    return figures.plot_state_spaces(spaces, level=level)


SPACE = View(space_form.one_face, _plot, lambda space, _: space.rows())
SPACES = View(space_form.job_face, _plot, job_rows)
