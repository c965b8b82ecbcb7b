"""Harmonics or a plan as one HTML page that needs nothing else."""

import math
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from allanite.angle import Calibration, Scan
from allanite.core.version import __version__
from allanite.reporting import words
from allanite.reporting.html import svg
from allanite.reporting.sheet import printable

from . import figures
from .numbers import Result, lines, noise, others, parts, solution_of


def page(value: "Result | Scan", *, level: float = 0.95, provenance: dict[str, str] | None = None) -> str:
    """The page as text.

    Parameters
    ----------
    value : Harmonics, Calibration or Scan
    level : float
        Of intervals.
    provenance : dict, optional
        What it was made of, printed at the end: source, sha256, command ...
    """
    env = Environment(
        loader=PackageLoader("allanite", "reporting"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters["clean"], env.filters["minus"] = printable, _minus
    content = _scan(value) if isinstance(value, Scan) else _result(value, level)
    made = {"allanite": __version__, **(provenance or {})}
    template = env.get_template("angle/scan.html.j2" if isinstance(value, Scan) else "angle/harmonics.html.j2")
    return template.render(content | {"provenance": made, "level": words.percent(level)})


def _minus(number: str) -> str:
    """A number in print, with the sign of mathematics."""
    return number.replace("-", "−")


def _result(result: Result, level: float) -> dict[str, Any]:
    solution = solution_of(result)
    rows = list(lines(result, level))
    return {
        "verdict": _verdict(rows, bool(solution.warnings)),
        "doubt": bool(solution.warnings),
        "about": f"{solution.innovations.size} readings; {noise(solution)}; condition {solution.condition:.4g}"
        + _ranges(result),
        "warnings": solution.warnings,
        "passed": [str(check) for check in solution.checks if check.passed],
        "rows": rows,
        "others": list(others(solution)),
        "errors": svg(figures.plot_errors(result, level), "error", "error over the angle"),
        "history": svg(figures.plot_history(result, level), "history", "amplitudes on their way")
        if len(solution.history.count) > 1
        else "",
        "innovations": svg(figures.plot_innovations(solution), "left", "innovations and their autocorrelation"),
        "gimbal": len(parts(result)) > 1 or "offset" not in solution.names,
        "prior": solution.prior is not None,
    }


def _ranges(result: Result) -> str:
    if not isinstance(result, Calibration):
        return ""
    angles = {name: np.degrees(getattr(result.gimbals, name)) for name in result.angles}
    return "".join(
        f"; {name} from {_minus(f'{a.min():.2f}')} to {_minus(f'{a.max():.2f}')} deg" for name, a in angles.items()
    )


def _verdict(rows: list[Any], doubt: bool) -> str:
    found = [f"harmonic {x.order} of {x.angle}: {x.amplitude} arcsec" for x in rows if x.found]
    absent = [f"{x.order} of {x.angle}" for x in rows if not x.found]
    status = "Doubtful" if any(x.status == "doubtful" for x in rows) else "Found"
    first = f"{status} are {', '.join(found)}." if found else "No harmonic was found."
    rest = f" Not found: {', '.join(absent)}." if absent and found else ""
    return first + rest + (" Read the warnings before using the numbers." if doubt else "")


def _scan(scan: Scan) -> dict[str, Any]:
    best, setup = scan.best, scan.best.setup
    low, high = (math.degrees(v) for v in best.h)
    return {
        "verdict": f"The best window of {words.duration(setup.duration)} begins {words.duration(best.start)} after h = "
        f"0, h from {_minus(f'{low:.1f}')} to {high:.1f} deg: the expected standard deviations of the "
        f"{best.amplitudes} amplitudes add up to {best.total:.3g}.",
        "about": f"latitude {math.degrees(setup.latitude):.6g} deg; q by the {setup.q_law} law; a reading every "
        f"{setup.interval:g} s with noise {setup.sigma:g}; {_prior(setup.prior)}; condition {best.condition:.4g}"
        + (f"; {_sway(setup.sway)}" if setup.sway else ""),
        "warnings": [str(f) for f in best.findings],
        "deviations": [(name, f"{error:.4g}") for name, error in best.standard_deviations.items()],
        "figure": svg(figures.plot_scan(scan), "scan", "expected accuracy by the start of the interval"),
        "windows": [
            (f"{s / 60:.1f}", f"{math.degrees(a):.2f}", f"{math.degrees(b):.2f}", f"{t:.4g}", f"{c:.4g}")
            for s, a, b, t, c in scan.rows()[1]
        ],
    }


def _prior(prior: tuple[float, float] | None) -> str:
    return "nothing known before" if prior is None else f"known before to {prior[0]:g} (amplitudes) and {prior[1]:g}"


def _sway(sway: Any) -> str:
    roll, pitch = math.degrees(sway.roll), math.degrees(sway.pitch)
    return f"sway of {roll:.3g} deg in roll and {pitch:.3g} deg in pitch, period {sway.period:g} s"
