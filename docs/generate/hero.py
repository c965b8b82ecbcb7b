"""The figure of the README, light and dark: ``python -P docs/generate/hero.py`` writes it from the sample."""

import re
import sys
from pathlib import Path

import allanite as al
from allanite.reporting.style import DARK

ROOT = Path(__file__).parents[2]
SAMPLE, FOLDER = ROOT / "examples" / "tactical_gyro.csv", ROOT / "docs" / "figures"


def main() -> None:
    """The third channel of the sample, in the package's own figure, and in its colours on a dark ground."""
    record = al.read(SAMPLE)["gz"]
    fit = al.identify(record)
    light = FOLDER / "hero.svg"
    al.plot(al.deviation(record, "oadev", taus="log", noise=fit), fit, path=light, force=True)
    dark = re.sub(r"#[0-9a-f]{6}\b", lambda color: DARK.get(color[0], color[0]), light.read_text(encoding="utf-8"))
    (FOLDER / "hero-dark.svg").write_text(dark, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
