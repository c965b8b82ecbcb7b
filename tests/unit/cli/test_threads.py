"""The number of processors changes the time only."""

import numpy as np
import pytest
from tests.commands import run
from tests.rows import rows


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "gyro.csv"
    data = np.column_stack([np.arange(3000) / 10, np.random.default_rng(8).standard_normal((3000, 3))])
    np.savetxt(path, data, delimiter=",", fmt="%.9g", header="time [s],x [deg/h],y [deg/h],z [deg/h]", comments="")
    return str(path)


def output(*arguments):
    result = run(*arguments, code=0)
    return result.stdout


@rows("verb", ["deviation", "spectrum"])
@pytest.mark.slow("three processes each")
def test_json_is_the_same(verb, file):
    found = {output(verb, file, "--json", "-", *threads) for threads in ([], ["--threads", 1], ["--threads", 3])}
    assert len(found) == 1


@pytest.mark.slow("takes more than half a second")
def test_a_recipe_may_hold_it(file, tmp_path):
    (tmp_path / "two.toml").write_text("threads = 2\n", encoding="utf-8")
    assert output("analyze", file, "--recipe", tmp_path / "two.toml") == output("analyze", file)
