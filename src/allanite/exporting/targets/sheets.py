"""Data sheets and state spaces."""

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.digits import digits
from allanite.core.errors import DataError
from allanite.core.model import Model
from allanite.core.readings import data_sheet
from allanite.core.syntax import CSV, KEYWORDS, LATEX, MARKDOWN, MATLAB, C, Syntax, escaped, identifiers
from allanite.exporting.content import Content, number
from allanite.exporting.target import Target
from allanite.phrases.phrase import say
from allanite.statespace import state_space

HEADINGS = ("channel", "quantity", "value", "low", "high", "unit", "tau, s", "remark")


def rows(content: Content) -> Iterator[tuple[str, ...]]:
    """The cells of the table; of a term that was not identified only the upper limit."""
    for axis in content.axes:
        for entry in data_sheet(axis.fit, axis.readings, axis.rate or 0.0, axis.level):
            tau = "" if entry.tau is None else f"{entry.tau:.4g}"
            cells = _numbers(entry.value, entry.low, entry.high)
            yield (axis.label, entry.quantity, *cells, entry.unit, tau, entry.remark)


def _numbers(*numbers: float | None) -> list[str]:
    """A value and its limits with six digits, or as many more as leave them the same when they are rounded again."""
    exact = digits(*(math.nan if v is None else v for v in numbers))
    for figures in range(6, 18):
        cells = ["" if v is None else f"{v:.{figures}g}" for v in numbers]
        if digits(*(float(cell or "nan") for cell in cells)) == exact:
            break
    return cells


def markdown(content: Content) -> str:
    """A table with the comments below it."""
    head, *cells = _cells(content, MARKDOWN)
    table = [f"| {' | '.join(line)} |" for line in (head, ("---",) * len(head), *cells)]
    return "\n".join([*table, "", *(f"- {MARKDOWN.cell(line.strip())}" for line in content.header)]) + "\n"


def comma_separated(content: Content) -> str:
    """Comments, headings and rows."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(_cells(content, CSV))
    return "".join(f"{part}\n" for line in content.header for part in CSV.comments(line)) + out.getvalue()


def latex(content: Content) -> str:
    """A tabular."""
    head, *cells = (" & ".join(row) + r" \\" for row in _cells(content, LATEX))
    comments = [part for line in content.header for part in LATEX.comments(line)]
    return "\n".join([*comments, r"\begin{tabular}{llrrrlrl}", rf"{head} \hline", *cells, r"\end{tabular}"]) + "\n"


def _cells(content: Content, syntax: Syntax) -> list[list[str]]:
    return [list(map(syntax.cell, row)) for row in (HEADINGS, *rows(content))]


DATASHEET = Target(
    name="datasheet", synonyms=("table",),
    title=say("table of the quantities that data sheets quote, each with its interval"), fields=(),
    forms={".md": markdown, ".csv": comma_separated, ".tex": latex}, source="the page Reading a data sheet",
    notes=(say("of a term that was not identified, high is the 95 % upper limit"),), inflatable=False,
)  # fmt: skip

MATRICES = ("Phi", "Qd", "H", "R", "P0")

LONGEST = 48  # letters of a name: MATLAB reads 63, and of two names that begin alike a number is behind


def spaces(content: Content) -> Iterator[tuple[str, dict[str, FloatArray], list[str]]]:
    """Name, matrices and remarks of each channel; of white noise only R."""
    called = [axis.name or f"axis{i}" for i, axis in enumerate(content.axes, 1)]
    for axis, name in zip(content.axes, identifiers(called, "axis", longest=LONGEST, taken=KEYWORDS), strict=True):
        noise = axis.fit.usable(unexplained=True).noise
        if noise is None:
            raise DataError(f"{axis.name}: no noise was identified")
        model = Model(tuple(replace(t, value=t.value * content.inflate) for t in noise))
        rate = content.rate or axis.rate
        assert rate is not None  # noqa: S101 - the target is rated
        whose = [] if axis.name in {"", name} else [f"channel {axis.name}"]
        if all(t.symbol == "N" for t in model):
            yield name, {"R": np.array([[model["N"].value ** 2 * rate]])}, [*whose, "white noise only: no states"]
            continue
        space = state_space(model, rate)
        remarks = [f"{i}: {state} ({unit})"
                   for i, (state, unit) in enumerate(zip(space.states, space.units, strict=True))]  # fmt: skip
        yield name, {label: getattr(space, label) for label in MATRICES}, [*whose, *remarks, *space.notes]


def numpy_file(content: Content) -> bytes:
    """An archive of arrays NAME_Phi, ..., and the comments as an array of text."""
    arrays: dict[str, FloatArray] = {}
    told = list(content.header)
    for name, matrices, remarks in spaces(content):
        arrays |= {f"{name}_{label}": matrix for label, matrix in matrices.items()}
        told += [f"{name}: {remark}" for remark in remarks]
    out = io.BytesIO()
    np.savez(out, allow_pickle=False, comment=np.array(list(map(escaped, told))), **arrays)
    return out.getvalue()


def matlab_file(content: Content) -> str:
    """A script that assigns NAME.Phi, ..."""
    lines = [part for line in content.header for part in MATLAB.comments(line)]
    for name, matrices, remarks in spaces(content):
        lines += [part for remark in remarks for part in MATLAB.comments(f"{name}: {remark}")]
        for label, matrix in matrices.items():
            rows = "; ".join(" ".join(map(number, row)) for row in matrix)
            lines.append(f"{name}.{label} = [{rows}];")
    return "\n".join(lines) + "\n"


def c_file(content: Content) -> str:
    """A header with constant arrays."""
    lines = ["#ifndef ALLANITE_NOISE_H", "#define ALLANITE_NOISE_H", ""]
    lines += [part for line in content.header for part in C.comments(line)]
    for name, matrices, remarks in spaces(content):
        lines += ["", *(part for remark in remarks for part in C.comments(f"{name}: {remark}"))]
        for label, matrix in matrices.items():
            rows = ", ".join("{" + ", ".join(map(number, row)) + "}" for row in matrix)
            lines.append(f"static const double {name}_{label}[{len(matrix)}][{matrix.shape[1]}] = {{{rows}}};")
    return "\n".join([*lines, "", "#endif"]) + "\n"


STATESPACE = Target(name="statespace", synonyms=("kalman",),
                    title=say("matrices of a Kalman filter in SI: x' = Phi x + w, sample = H x + v"), fields=(),
                    forms={".npz": numpy_file, ".m": matlab_file, ".h": c_file}, source="exact discretization at the "
                    "sampling rate; flicker as Gauss-Markov processes matched from 1 to 1000 s",
                    notes=(say("Qd is the covariance of w, R the variance of v, P0 the covariance of the states at the "
                               "start"),),
                    rated=True)  # fmt: skip
