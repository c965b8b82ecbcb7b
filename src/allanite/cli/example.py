"""``allanite example``: the main table and figure of a paper, by the commands that anybody can type."""

import contextlib
import os
import shlex
import textwrap
from dataclasses import dataclass
from typing import Any

import click

from allanite.core.names import demand_name

from .options import SHOWN, options


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


STABILIZER = "N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s, R 0.5 arcsec/s"
FIBER = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h), R 5 deg/h^2"
BEFORE = "Q 0.963036 arcsec, N 2.525648 deg/sqrt(h), B 12.023988 deg/h, K 32.72457 deg/h/sqrt(h), R 38.789995 deg/h^2"
AFTER = "Q 0.916159 arcsec, N 2.365199 deg/sqrt(h), B 3.235266 deg/h, K 10.682979 deg/h/sqrt(h), R 23.970946 deg/h^2"
"""Noise of the sensors of 000, 001 and 004; the papers' records are not published."""

GIMBAL = "--latitude 60 --duration 3600 --q-law linear"
ERRORS = "--error h:128=3,-1.5 --error h:256=1,2 --error q:128=-2,1 --error q:256=1.5,1"
GL1 = "--constant '12.4392 deg/h' --rate 400 --duration '188 min'"

EXAMPLES: dict[str, Example] = {
    row.name: row
    for row in (
        Example(
            "000", "angle error of a gyro stabilizer",
            "I. R. Gazaryan, A. Yu. Tairov and V. K. Ponomarev, Izvestiya of Tula State University, Technical "
            "Sciences, 2019, 143-153",
            (
                "deviation --model 'Q 0.3 arcsec*s, N 3 arcsec*sqrt(s), B 1 arcsec, K 0.1 arcsec/sqrt(s), "
                "R 0.002 arcsec/s' --rate 40 --duration 10h --plot figure1.png",
                "deviation --model 'Sine 1 arcsec 0.5 Hz, GM 1 arcsec 5 s' --rate 40 --duration 1h --plot figure2.png",
                f"simulate run1.csv --model '{STABILIZER}' --rate 40 --duration 1h --unit arcsec --seed 1",
                f"simulate run2.csv --model '{STABILIZER}' --rate 40 --duration '30 min' --unit arcsec --seed 2",
                "deviation run1.csv --statistic adev,mdev,ohdev --taus log --plot figure3.png",
                "analyze run1.csv --device stabilizer --report run1.html",
                "compare run1.csv --part 1800",
                "compare run1.csv run2.csv",
            ),
        ),
        Example(
            "001", "TheoH of a fiber-optic gyro", "X. Tang, X. Cheng and J. Gao, Acta Armamentarii 36 (2015) 1688-1695",
            (
                "explain theo1 --samples 7200 --taus 7.5,75,540,750,1080,2700,4050,5400 --csv tables1and2.csv",
                "simulate white.csv --model 'N 0.02 deg/sqrt(h)' --rate 1 --samples 7200",
                "deviation white.csv --statistic adev,theo1 --taus log --plot figure5.png",
                "simulate varying.csv --model 'N 0.02 deg/sqrt(h)' --rate 1 --samples 7200 "
                "--noise-profile '0:1, 3000:1, 3600:3, 4200:1'",
                "deviation varying.csv --statistic adev,theo1 --taus log --plot figure7.png",
                f"simulate fog.npz --model '{FIBER}' --rate 100 --duration 2h",
                "deviation fog.npz --average 1 --statistic adev,theo1,theobr --bias plain --taus log "
                "--plot figure9.png",
                "deviation fog.npz --average 1 --statistic theoh --bias plain --taus log --plot figure10.png",
                "analyze fog.npz --average 1 --method nnls --statistic oadev --coefficients table3_allan.csv",
                "analyze fog.npz --average 1 --method nnls --statistic theoh --coefficients table3_theoh.csv",
                "analyze fog.npz --average 1 --method gls --statistic theoh --coefficients table3_gls.csv",
            ),
        ),
        Example(
            "002", "errors of the angle sensors of a gimbal",
            "the results of an algorithm to estimate the errors of the angle sensors of a gimballed inertial "
            "navigation system, allbest.ru 2018",
            (
                f"angle plan {GIMBAL} --start 0,3600,7200,10800,14400,18000 --csv table1.csv --plot ranges.png",
                f"angle simulate sway.csv {GIMBAL} --start 7200 {ERRORS} --sway 1,60 --plot figure2.png",
                f"angle simulate hour.csv {GIMBAL} --start 7200 {ERRORS} --plot figure3.png",
                "angle estimate hour.csv --difference difference --latitude 60 --rho rho --report hour.html",
            ),
        ),
        Example(
            "003", "rate of a laser gyro in two minutes",
            "V. N. Enin and I. V. Saneev, Science and Education of the Bauman MSTU 2017, no. 2, 52-69",
            (
                f"simulate gl1.npz --sensor gl1 {GL1}",
                "rate gl1.npz --latitude 55.7936 --bias -0.0948 --noise 'N 0.0002918 deg/sqrt(h), Q 0.2544 arcsec' "
                "--no-times --report gl1.html --plot figure10.png --readings table2.csv --closeup figures3to7.png",
                f"simulate smooth.npz --sensor gl1-smooth {GL1}",
                "rate smooth.npz --methods mean --durations 1,5,10,30 --noise 'Q 0.02367 arcsec, GMA 0.29 arcsec 15 s' "
                "--csv table1.csv",
            ),
        ),
        Example(
            "004", "current of a suspended gyro before and after compensation",
            "M. Geng et al., Journal of Beijing University of Aeronautics and Astronautics 47 (2021) 1697-1704",
            (
                f"simulate before.npz --model '{BEFORE}' --rate 1000 --duration 1h --seed 1",
                f"simulate after.npz --model '{AFTER}' --rate 1000 --duration 1h --seed 2",
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
    *SHOWN,
)  # fmt: skip
def example(paper: str | None, folder: str, commands: bool, **shared: Any) -> None:
    """Reproduce a table and figure of a paper.

    Writes simulated input, tables, figures and the page of PAPER into FOLDER, by commands that are printed and that can
    be repeated one by one. Without PAPER, lists the papers.
    """
    if paper is None:
        for row in EXAMPLES.values():
            source = textwrap.wrap(row.source, 95, initial_indent="     ", subsequent_indent="     ")
            click.echo("\n".join([f"{row.name}  {row.title}", *source]))
        return
    demand_name("paper", paper, EXAMPLES)
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
            from . import VERBS, main

            defaults = shared | dict.fromkeys(ANGLE, shared)
            with main.make_context("allanite", line, default_map=dict.fromkeys(VERBS, defaults)) as context:
                main.invoke(context)


ANGLE = ("calibrate", "estimate", "plan", "simulate")
"""Verbs of the group angle."""
