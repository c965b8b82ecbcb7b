"""``allanite example``: the main table and figure of a paper, by the commands that anybody can type."""

import contextlib
import os
import shlex
from dataclasses import dataclass
from typing import Any

import click

from allanite.core.errors import UsageError

from .options import options


@dataclass(frozen=True)
class Example:
    """A row of `EXAMPLES`.

    Attributes
    ----------
    name, title, source : str
        Name on the command line, what it is about, and the paper.
    commands : tuple of str
        Commands without the word allanite, which write their files into the current folder.
    """

    name: str
    title: str
    source: str
    commands: tuple[str, ...]


EXAMPLES: dict[str, Example] = {
    row.name: row
    for row in (
        Example(
            "002", "errors of the angle sensors of a gimbal",
            "the results of an algorithm to estimate the errors of the angle sensors of a gimballed inertial "
            "navigation system, allbest.ru 2018",
            (
                "angle plan --latitude 60 --duration 3600 --q-law linear --start 0,3600,7200,10800,14400,18000 "
                "--csv table1.csv --plot ranges.png",
                "angle simulate hour.csv --latitude 60 --duration 3600 --q-law linear --start 7200 "
                "--error h:128=3,-1.5 --error h:256=1,2 --error q:128=-2,1 --error q:256=1.5,1",
                "angle estimate hour.csv --difference difference --latitude 60 --rho rho --report hour.html "
                "--plot figure2.png",
            ),
        ),
        Example(
            "003", "rate of a laser gyro in two minutes",
            "V. N. Enin and I. V. Saneev, Science and Education of the Bauman MSTU 2017, no. 2, 52-69",
            (
                "simulate gl1.npz --sensor gl1 --constant '12.4392 deg/h' --rate 400 --duration '188 min'",
                "rate gl1.npz --latitude 55.7936 --bias -0.0948 --report gl1.html --plot figure10.png --csv table2.csv",
            ),
        ),
        Example(
            "004", "current of a suspended gyro before and after compensation",
            "M. Geng et al., Journal of Beijing University of Aeronautics and Astronautics 47 (2021) 1697-1704",
            (
                "simulate before.npz --model 'Q 0.963036 arcsec, N 2.525648 deg/sqrt(h), B 12.023988 deg/h, "
                "K 32.72457 deg/h/sqrt(h), R 38.789995 deg/h^2' --rate 1000 --duration 1h --seed 1",
                "simulate after.npz --model 'Q 0.916159 arcsec, N 2.365199 deg/sqrt(h), B 3.235266 deg/h, "
                "K 10.682979 deg/h/sqrt(h), R 23.970946 deg/h^2' --rate 1000 --duration 1h --seed 2",
                "analyze before.npz --method ls --coefficients table2.csv",
                "analyze after.npz --method ls --coefficients table3.csv",
                "compare before.npz after.npz --report comparison.html --plot figure6.png",
            ),
        ),
    )
}  # fmt: skip


@click.command()
@options(
    click.argument("paper", required=False),
    click.argument("folder", required=False, default=".", type=click.Path(file_okay=False)),
    click.option("--commands", is_flag=True, help="Print the commands only."),
    "lang", "force", "quiet",
)  # fmt: skip
def example(paper: str | None, folder: str, commands: bool, **shared: Any) -> None:
    """Reproduce the main table and figure of a paper.

    Writes simulated input, tables, figures and the page of PAPER into FOLDER, by commands that are printed and that can
    be repeated one by one. Without PAPER, lists the papers.
    """
    if paper is None:
        for row in EXAMPLES.values():
            click.echo(f"{row.name}  {row.title}\n     {row.source}")
        return
    if paper not in EXAMPLES:
        raise UsageError(f"unknown paper {paper!r}; examples: {', '.join(EXAMPLES)}")
    lines = [shlex.split(command) for command in EXAMPLES[paper].commands]
    shown = [shlex.join(["allanite", *line]) for line in lines]
    if commands:
        click.echo("\n".join(shown))
        return
    os.makedirs(folder, exist_ok=True)
    with contextlib.chdir(folder):
        for line, text in zip(lines, shown, strict=True):
            if not shared["quiet"]:
                click.echo(f"\n$ {text}")
            _run(line, shared)


def _run(line: list[str], shared: dict[str, Any]) -> None:
    """Run one command as if it were typed; `shared` are the defaults of those of its options that it has."""
    from . import VERBS, main

    defaults = shared | dict.fromkeys(ANGLE, shared)
    with main.make_context("allanite", line, default_map=dict.fromkeys(VERBS, defaults)) as context:
        main.invoke(context)


ANGLE = ("calibrate", "estimate", "plan", "simulate")
"""Verbs of the group angle."""
