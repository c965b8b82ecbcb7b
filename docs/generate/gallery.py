"""The gallery: short programs, run when the page is made, and the figures that they write."""

from pathlib import Path
from textwrap import dedent

from generate.tutorial import desk_with_sample

PREAMBLE = """\
import numpy as np
import allanite as al

recording = al.read("examples/tactical_gyro.csv")
record = recording["gz"]"""

PICTURES = {
    "Curve with the fitted model": ("curve", """\
        fit = al.identify(record)
        curve = al.deviation(record, "oadev", taus="log", noise=fit)
        al.plot(curve, fit, path="curve.svg")
        """),
    "Several statistics of one channel": ("statistics", """\
        curves = [al.deviation(record, name, noise=fit) for name in ("oadev", "ohdev", "mdev", "theoh")]
        al.plot(curves, path="statistics.svg")
        """),
    "Channels side by side": ("channels", """\
        al.plot([al.deviation(each, taus="log") for each in recording], path="channels.svg")
        """),
    "Power spectral density": ("spectrum", """\
        al.plot(al.spectrum(record, bins=20), fit, path="spectrum.svg")
        """),
    "Residuals": ("residuals", """\
        al.plot(al.residuals(record, fit), path="residuals.svg")
        """),
    "Two records compared": ("comparison", """\
        al.plot(al.compare(recording["gx"], recording["gy"]), path="comparison.svg")
        """),
    "Accuracy against record length": ("plan", """\
        al.plot(al.plan(al.sensor("fog"), rate=100.0), path="plan.svg")
        """),
    "States of a Kalman filter against the model": ("filter", """\
        al.plot(al.state_space(al.sensor("fog"), 100.0, tau=(1.0, 1000.0)), path="filter.svg")
        """),
    "Ways to measure a constant rate": ("ranking", """\
        settings = al.constant_rate.ExperimentSettings(interval=60.0)
        ranking = al.constant_rate.experiment(recording["gx"], fit, settings)
        al.plot(ranking, path="ranking.svg")
        """),
    "Where to calibrate the angle sensors of a gimbal": ("scan", """\
        settings = al.angle.AngleSettings(latitude=np.radians(60), duration=3600.0, interval=10.0)
        al.plot(al.angle.scan(settings), path="scan.svg")
        """),
}  # fmt: skip
"""Title of a picture: name of its figure, and the program. They run one after the other in one namespace."""


def gallery_page(docs: Path, folder: Path) -> list[str]:
    """Run every program, keep its figure, and show both."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["# Gallery", "", "Every figure is made by the lines below it, after these:", "", *_code(PREAMBLE)]
    names: dict[str, object] = {}
    with desk_with_sample(docs) as desk:
        exec(PREAMBLE, names)  # noqa: S102 - our own programs
        for title, (name, program) in PICTURES.items():
            exec(dedent(program), names)  # noqa: S102
            (folder / f"{name}.svg").write_bytes((desk / f"{name}.svg").read_bytes())
            lines += [f"## {title}", "", f"![{title}](gallery/{name}.svg)", "", *_code(dedent(program).rstrip())]
    return lines


def _code(program: str) -> list[str]:
    return ["```python", program, "```", ""]
