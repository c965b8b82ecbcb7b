"""The figure of the README, light and dark: ``python docs/generate/hero.py`` writes it from the sample."""

import inspect
import sys
from pathlib import Path
from typing import Any

import allanite as al

ROOT = Path(__file__).parents[2]
SAMPLE, FOLDER = ROOT / "examples" / "tactical_gyro.csv", ROOT / "docs" / "figures"


def main() -> None:
    """The third channel of the sample, in the package's own figure."""
    record = al.read(SAMPLE)["gz"]
    fit = al.identify(record)
    curve = al.deviation(record, "oadev", taus="log", noise=fit)
    for name, dark in (("hero.svg", False), ("hero-dark.svg", True)):
        al.plot(curve, fit, path=FOLDER / name, force=True, **_look(dark=dark))


def _look(*, dark: bool) -> dict[str, Any]:
    """The dark look, where figures have one; else both files are light, on a white ground."""
    return {"dark": dark} if "dark" in inspect.signature(al.plot).parameters else {}


if __name__ == "__main__":
    sys.exit(main())
