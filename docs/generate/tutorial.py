"""The tutorial is run, and its figures are those that it writes."""

import contextlib
import io
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

SAMPLE = Path("examples", "tactical_gyro.csv")


def beside(docs: Path, name: Path) -> Path:
    """A file of the project that the documentation lies in."""
    return next(parent / name for parent in docs.resolve().parents if (parent / name).is_file())


@contextlib.contextmanager
def desk_with_sample(docs: Path) -> Iterator[Path]:
    """The current folder for programs: one that has the sample; what they print is dropped."""
    sample = beside(docs, SAMPLE)
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place), contextlib.redirect_stdout(io.StringIO()):
        desk = Path(place)
        (desk / SAMPLE).parent.mkdir()
        shutil.copy(sample, desk / SAMPLE)
        yield desk


def run_tutorial(docs: Path, folder: Path) -> None:
    """Run the Python of the tutorial in a folder that has the sample, and keep the figures that it writes."""
    blocks = re.findall(r"^```python\n(.*?)^```", (docs / "tutorial.md").read_text("utf-8"), re.DOTALL | re.MULTILINE)
    with desk_with_sample(docs) as desk:
        exec("".join(blocks), {})  # noqa: S102 - our own page
        for figure in (*desk.glob("*.svg"), *desk.glob("*.png")):
            shutil.copy(figure, folder)
