"""Files that do not fit into memory: the numbers of the same file in memory, and what is refused by name."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings, strategies as st
from pyarrow import csv
from tests import ALL, examples
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.reporting import page, table
from allanite.study.recipe import Recipe
from allanite.study.survey import Densities, Deviations, Windows, survey

N = 200_000
HOW = {"rate": 100.0, "unit": "deg/h"}
PARTS = Recipe(**HOW, memory="100kB")
WHOLE = Recipe(**HOW)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Three channels: white noise with a random walk and two outliers, a gap, and one that is quiet."""
    rng = np.random.default_rng(4)
    values = 10 * rng.normal(size=(N, 3))
    values[:, 0] += np.cumsum(0.02 * rng.normal(size=N))
    values[[500, 150_000], 0] += (900.0, -700.0)
    values[40_000:40_500, 1] = np.nan
    path = tmp_path_factory.mktemp("large") / "three.npy"
    np.save(path, values)
    return path


@pytest.fixture(autouse=True)
def short_parts(monkeypatch):
    monkeypatch.setattr("allanite.readers.formats.numpy_file.HEAD_ROWS", 20_000)
    monkeypatch.setattr("allanite.readers.parts.AT_ONCE", 90_000)


def by_m(curve):
    return dict(zip(curve.m.tolist(), curve.variance.tolist(), strict=True))


@pytest.mark.slow("seconds of analyses")
@rows("statistic", ["oadev", "ohdev", "tdev"] if not ALL else ["oadev", "ohdev", "mdev", "tdev", "haar"])
def test_curves_are_those_of_the_whole_where_windows_start_at_every_sample(file, statistic):
    settings_ = Deviations((statistic,), taus="octave", intervals=False)
    mine, whole = (survey(file, settings_, recipe).values for recipe in (PARTS, WHOLE))
    # windows with gaps are omitted
    gapped = al.statistics.deviation(al.read(file, **HOW)[1], statistic, gaps="complete", noise=None)
    for one, other in zip(mine, (whole[0], gapped.to(mine[1].unit), whole[2]), strict=True):
        exact, known = by_m(other), by_m(one)
        # a stream of mdev and tdev begins a window later after a gap than the whole
        rel = 1e-4 if other.name == "column 2" and statistic in ("mdev", "tdev") else 1e-9
        for m in (1, 2, 4, 8):
            assert known[m] == pytest.approx(exact[m], rel=rel)
        far = [m for m in known if m > 15 and m < N / 20]
        assert [known[m] / exact[m] for m in far] == pytest.approx([1.0] * len(far), rel=0.1)


@rows("choices", [{"outliers": "mark"}, {"outliers": "keep"}, {"start": 100.0, "until": 1500.0, "outliers": "keep"}])
def test_outliers_are_marked_or_kept_and_a_window_is_cut(file, choices):
    job = Deviations(m=(1, 2, 8), intervals=False)
    mine, whole = (survey(file, job, Recipe(**HOW, **choices, memory=memory)) for memory in ("100kB", None))
    for one, other in zip(mine, whole, strict=True):
        assert one.record.size == other.record.size == (140_000 if "start" in choices else N)
        assert one.record.start == pytest.approx(choices.get("start"))
    for i in (0, 2):
        assert mine.values[i].variance == pytest.approx(whole.values[i].variance, rel=1e-9)


def test_spectra_are_those_of_the_whole(file):
    mine, whole = (survey(file, Densities(segment=50.0), recipe).values for recipe in (PARTS, WHOLE))
    for one, other in zip(mine, whole, strict=True):
        np.testing.assert_allclose(one.density, other.density, rtol=1e-9)
        np.testing.assert_allclose(one.dof, other.dof, rtol=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_the_study_has_the_coefficients_of_the_whole_and_nothing_is_done_in_silence(file):
    mine, whole = (al.analyze(file, recipe) for recipe in (PARTS, WHOLE))
    for one, other in zip(mine, whole, strict=True):
        assert one.fit["N"].value == pytest.approx(other.fit["N"].value, rel=0.01)
        assert one.record.size == other.record.size
    assert mine["column 1"].fit["K"].value == pytest.approx(whole["column 1"].fit["K"].value, rel=0.3)
    assert [channel.quality.names for channel in mine] == [("outliers",), ("gaps",), ()]
    assert mine.provenance["sha256"] == whole.provenance["sha256"]
    said = " ".join(table(mine).split())
    for words in (
        "the file was read in parts: as a whole the record may take 17.6 MB of memory, of which 100 kB may be used",
        "from those that start every 2^k samples",
        "every sample was checked for gaps, outliers, stuck and clipped values",
        "not done, since it needs all samples at once: removal of sinusoids, tests of the residuals",
    ):
        assert words in said
    assert al.from_dict(mine.to_dict()).to_dict() == mine.to_dict()
    assert "read in parts" in page(mine)


@pytest.mark.slow("takes more than half a second")
def test_channels_are_analyzed_one_after_the_other_where_memory_is_short(file):
    mine, whole = (al.analyze(file, Recipe(**HOW, memory=memory)).to_dict() for memory in ("18MB", None))
    for name in ("recipe", "provenance"):
        mine.pop(name), whole.pop(name)
    (note,) = [note for note in mine["notes"] if note not in whole["notes"]]
    mine["notes"].remove(note)
    assert mine == whole
    assert "one after the other: at once they may take 43.2 MB of memory, of which 18 MB may be used" in note


@pytest.mark.slow("takes more than half a second")
def test_a_coefficient_that_the_curve_contradicts_is_no_result_in_parts(tmp_path, monkeypatch):
    """Pulses of the bias are K by the likelihood of the octaves, but the curve falls again."""
    monkeypatch.setattr("allanite.identification.checks.contradiction.FALSE", 0.5)  # K exceeds the curve by little
    values = np.random.default_rng(1).normal(size=N)
    for begin in (N // 8, 3 * N // 8, 5 * N // 8):
        values[begin : begin + N // 10] += 0.6
    np.save(tmp_path / "pulses.npy", values)
    mine = al.analyze(tmp_path / "pulses.npy", replace(PARTS, terms="N,B,K"))[0]
    assert mine.fit["K"].status == "not valid"
    assert mine.fit.scope.until < 10.0


@pytest.mark.slow("takes more than half a second")
def test_nothing_is_claimed_by_a_model_that_does_not_explain_a_record_in_parts(tmp_path):
    """Vibration that is swept from 1 to 5 Hz."""
    t = np.arange(N) / 100
    values = np.random.default_rng(1).normal(size=N) + 3 * np.sin(2 * np.pi * t * (1 + 0.001 * t))
    np.save(tmp_path / "swings.npy", values)
    mine = al.analyze(tmp_path / "swings.npy", PARTS)[0]
    assert not mine.explained
    assert {e.status for e in mine.fit} == {"not valid"}


@settings(max_examples=examples(12), deadline=None)
@given(st.integers(3, 60_000))
def test_the_length_of_the_parts_does_not_matter(file, samples):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("allanite.readers.parts.AT_ONCE", max(samples, 1000))
        job = Deviations(m=(1, 3, 15, 128, 8192), intervals=False)
        mine = survey(file, job, Recipe(**HOW, channels=("3",), memory="100kB", outliers="keep")).values[0]
    stream = al.Accumulator(100.0, "deg/h")
    stream.push(np.load(file)[:, 2])
    exact = by_m(stream.curve())
    unit = mine.to("rad/s")
    assert unit.variance.tolist() == pytest.approx([exact[m] for m in unit.m.tolist()], rel=1e-9)


def finding_named(name, channel):
    return next(finding for finding in channel.quality.findings if finding.name == name)


@pytest.mark.slow("takes more than half a second")
def test_defects_are_found_wherever_they_are(tmp_path, monkeypatch):
    rng = np.random.default_rng(7)
    values = rng.normal(size=(N, 3))
    values[170_000:170_400, 0] = values[170_000, 0]
    values[:, 1] = np.clip(values[:, 1], -2.5, 2.5)
    values[:, 2] = 1.25
    np.save(tmp_path / "bad.npy", values)
    study = al.analyze(tmp_path / "bad.npy", PARTS)
    assert "stuck" in study[0].quality.names
    assert "clipped" in study[1].quality.names
    assert "constant" in study[2].quality.names
    stuck = "the output is stuck in 1 place, the first from 1700 s"
    assert stuck in str(finding_named("stuck", study[0]))
    monkeypatch.setattr("allanite.prepare.inspector.BLOCK", 30_000)
    blocks = finding_named("stuck", al.analyze(tmp_path / "bad.npy", PARTS)[0])
    assert f"in 1 of 7 blocks of 30000 samples that were inspected, first: {stuck}" in str(blocks)
    np.save(tmp_path / "worse.npy", values[:, 2:])
    refused(al.DataError, "always 1", lambda: al.analyze(tmp_path / "worse.npy", PARTS))


@rows(("recipe", "words"), [
    ({"ranges": {"N": (0.1, 1.0)}, "method": "piecewise"},
     "no method 'piecewise': only 'whittle', or allow more memory with memory="),
    ({"quiet_window": 100.0}, "no quiet_window: omit it"),
    ({"method": "gls"}, "no method 'gls': only 'whittle'"),
    ({"statistic": "theo1"}, "no 'theo1': choose one of oadev, mdev, tdev, ohdev, haar"),
    ({"taus": "all"}, "the averaging times of taus= log or octave"),
    ({"taus": (1.0, 10.0)}, "no averaging time 1 s; .* the nearest 0.96 s and 1.04 s"),
])  # fmt: skip
def test_what_needs_the_whole_is_refused_by_name(file, recipe, words):
    refused(al.UsageError, words, lambda: al.analyze(file, Recipe(**HOW, memory="100kB", **recipe)))
    al.analyze(file, Recipe(**HOW, memory="1GB", channels=("3",), until=150.0, **recipe))  # the cure


@rows("job, words", [
    (Deviations(("adev",)), "no 'adev'"),
    (Deviations(m=(100,)), "no averaging factor 100; .* the nearest 96 and 104"),
    (Deviations(edf="published"), "no edf 'published': only 'exact'"),
    (Deviations(power_law=True), "no power_law: omit it"),
    (Densities("multitaper"), "no estimator 'multitaper': choose welch"), (Windows(), "no sliding windows"),
])  # fmt: skip
def test_jobs_that_need_the_whole_are_refused_by_name(file, job, words):
    refused(al.UsageError, words, lambda: survey(file, job, PARTS))


def test_segments_are_bounded(file, monkeypatch):
    monkeypatch.setattr("allanite.statistics.spectra.estimators.MAX_SEGMENT", 4096)
    refused(al.UsageError, r"up to 40.96 s", lambda: survey(file, Densities(segment=50.0), PARTS))
    assert survey(file, Densities(segment=40.96), PARTS).values[0].resolution > 0


@pytest.mark.slow("a process that reads in parts")
def test_the_command_line_takes_the_option(file, tmp_path):
    how = (file, "--rate", "100", "--unit", "deg/h", "--memory")
    ends(run("analyze", *how, "100kB", "--channels", "3", "--json", tmp_path / "s.json"), 0, "may be used (--memory)")
    assert json.loads((tmp_path / "s.json").read_text())["recipe"]["memory"] == "100kB"
    said = "choose one of oadev, mdev, tdev, ohdev, haar, or allow more memory with --memory"
    ends(run("deviation", *how, "100kB", "--statistic", "hdev"), 2, said)
    refusal = run("rate", *how, "100kB")
    ends(refusal, 2, "the record may take 17.6 MB of memory, of which 100 kB may be used")
    more = " ".join(refusal.stderr.split()).partition("allow more with --memory ")[2].split()[0]
    assert run("rate", *how, more).exit_code in (0, 3)


def printed(program, *words):
    """The integers that a program prints in a process of its own."""
    command = [sys.executable, "-c", program, *map(str, words)]
    return [int(word) for word in subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()]


PEAK = """
import sys, allanite as al, numpy as np
from allanite.study.recipe import Recipe
def peak():
    return next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")) // 1024
al.analyze(np.random.default_rng(1).normal(size=20_000), Recipe(rate=100.0, unit="deg/h"))
base = peak()
study = al.analyze(sys.argv[1], Recipe(rate=100.0, unit="deg/h", memory=sys.argv[2]))
print(peak() - base, sum("one after the other" in note for note in study.notes))
"""


@pytest.mark.nightly("memory of processes of their own")
@rows("suffix, memory", [(".npy", 340), (".csv", 450)])
def test_six_channels_fit_where_one_of_them_does(suffix, memory, tmp_path):
    path, values = tmp_path / f"six{suffix}", np.random.default_rng(1).normal(size=(3_000_000, 6))
    if suffix == ".npy":
        np.save(path, values)
    else:
        csv.write_csv(pa.table(dict(zip("abcdef", np.rint(values.T * 1e5) / 1e5, strict=True))), path)
    peak, alone = printed(PEAK, path, f"{memory}MB")
    assert alone
    assert peak < memory + 200  # MB; what pyarrow parses at a time does not grow with the file


LIMITED = """
import resource, sys
import numpy, allanite as al
from allanite.study.recipe import Recipe
al.analyze(sys.argv[1], Recipe(rate=100.0, unit="deg/h", memory="1MB"))  # compiled code and libraries
base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
al.analyze(sys.argv[2], Recipe(rate=100.0, unit="deg/h", memory="1MB"))
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - base) // 1024)
"""


@pytest.mark.slow("memory of a process of its own")
def test_memory_does_not_grow_with_the_file(tmp_path):
    rng = np.random.default_rng(2)
    for name, size in (("small", 3_000_000), ("large", 12_000_000)):
        np.save(tmp_path / f"{name}.npy", rng.standard_normal(size, dtype=np.float32))
    (more,) = printed(LIMITED, tmp_path / "small.npy", tmp_path / "large.npy")
    assert more < 40  # MB more; the large file has 48 MB, and its samples as float64 96 MB
