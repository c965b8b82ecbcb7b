"""The tutorial is run, and its figures are those that it writes."""

import contextlib
import io
import os
import re
import shutil
import tempfile
from pathlib import Path

SAMPLE = Path("examples", "tactical_gyro.csv")


def beside(docs: Path, name: Path) -> Path:
    """A file of the project that the documentation lies in."""
    return next(parent / name for parent in docs.resolve().parents if (parent / name).is_file())


def run_tutorial(docs: Path, folder: Path) -> None:
    """Run the Python of the tutorial in a folder that has the sample, and keep the figures that it writes."""
    blocks = re.findall(r"^```python\n(.*?)^```", (docs / "tutorial.md").read_text("utf-8"), re.DOTALL | re.MULTILINE)
    sample = beside(docs, SAMPLE)
    with tempfile.TemporaryDirectory() as place:
        desk = Path(place)
        (desk / "examples").mkdir()
        shutil.copy(sample, desk / SAMPLE)
        before = Path.cwd()
        os.chdir(desk)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                exec("".join(blocks), {})  # noqa: S102 - our own page
        finally:
            os.chdir(before)
        for figure in (*desk.glob("*.svg"), *desk.glob("*.png")):
            shutil.copy(figure, folder)
