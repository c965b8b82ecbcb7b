"""What the README says is run."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.fixture
def desk(tmp_path):
    """A folder with the sample, as somebody who follows the README has it."""
    (tmp_path / "examples").mkdir()
    shutil.copy(ROOT / "examples" / "tactical_gyro.csv", tmp_path / "examples")
    return tmp_path


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_python_blocks_run_and_print_what_they_say(desk, block):
    done = subprocess.run([sys.executable, "-c", block], cwd=desk, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for said in re.findall(r"print\(.*\)\s*# (.*)", block):
        if not said.startswith("interval"):
            assert said in done.stdout


def test_the_excerpt_is_what_the_demo_prints(desk):
    command = [str(Path(sys.executable).with_name("allanite")), "analyze", "examples/tactical_gyro.csv"]
    done = subprocess.run(command, cwd=desk, capture_output=True, text=True, check=True)
    excerpt = re.search(r"```text\n(.*?)```", README, re.DOTALL)[1]
    for line in excerpt.splitlines():
        assert " ".join(line.split()) in " ".join(done.stdout.split())


def test_both_commands_stand_on_the_first_screen():
    first = "\n".join(README.splitlines()[:16])
    for words in ("make demo", "make test", "pip install .", "allanite analyze FILE --rate 100 --unit deg/s"):
        assert words in first


def test_the_sample_is_what_its_script_makes():
    sys.path.insert(0, str(ROOT / "examples"))
    try:
        from make_sample import sample
    finally:
        sys.path.pop(0)
    kept = (ROOT / "examples" / "tactical_gyro.csv").read_text(encoding="utf-8").splitlines()
    made = sample().splitlines()
    assert made[:5] == kept[:5]
    # the transform's last digit is the library's: a hundredth of a deg/h may round the other way
    for a, b in zip(made[5:], kept[5:], strict=True):
        assert [float(v) for v in a.split(",")] == pytest.approx([float(v) for v in b.split(",")], abs=0.0101)
