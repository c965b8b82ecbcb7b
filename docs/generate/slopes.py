"""The figure of the five slopes of IEEE Std 952."""

from pathlib import Path

import numpy as np

import allanite as al
from allanite.terms import TERMS

MODEL = (
    al.Q(1.1, "arcsec"),
    al.N(0.1, "deg/sqrt(h)"),
    al.B(0.9, "deg/h"),
    al.K(1.13, "deg/h/sqrt(h)"),
    al.R(0.176, "deg/h^2"),
)
"""Sizes for which each term dominates two decades or more of the curve."""


def slopes_figure(folder: Path) -> None:
    """The expected curve of five terms, each with its slope, where it is read off."""
    from allanite.reporting import printing, style

    tau = np.geomspace(1e-3, 1e7, 201)
    with printing.look():
        figure = printing.new_figure(7.6, 3.8)
        ax = figure.subplots()
        ax.set(xscale="log", yscale="log", xlabel="averaging time τ (s)", ylabel="Allan deviation (deg/h)")
        ax.plot(tau, _sigma(al.Model(tuple(MODEL)), tau), color=style.INK, lw=2.0, label="sum")
        for term in MODEL:
            _line(ax, term, tau)
        ax.set_ylim(0.1, 3000)
        style.grid(ax)
        style.plain_ticks(ax.xaxis, ax.yaxis)
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    (folder / "slopes.svg").write_bytes(printing.encode(figure, "svg"))


def _line(ax, term: al.Term, tau: np.ndarray) -> None:
    row = TERMS[term.symbol]
    slope = {-1: "−1", -0.5: "−1/2", 0: "0", 0.5: "+1/2", 1: "+1"}[row.slope]
    sigma = _sigma(term, tau)
    ax.plot(tau, sigma, "--", color=row.color, lw=1.1, label=f"{term.symbol}: {row.title}, slope {slope}")
    if row.slope:
        at = row.read_at
        ax.plot(at, np.interp(at, tau, sigma), "D", ms=4, color=row.color)


def _sigma(model: al.Model | al.Term, tau: np.ndarray) -> np.ndarray:
    """In deg/h."""
    return np.degrees(np.sqrt(al.expected(model, "oadev", tau, rate=1000.0))) * 3600
