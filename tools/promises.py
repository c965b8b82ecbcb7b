"""Numbers of the page "How well is it known", and the promises of README and documentation that it lists.

A row of docs/known.md has a promise in the words of the page that makes it, its result with a link to the table or the
test that shows it, and what falls short. tools/figures.py writes the numbers below into its rows.
"""

# ruff: noqa: D103  what a helper of the table below reads stands in its name

from cells import RESULTS, ROOT, NotMadeError, figures, mean, number, read, rows, single, span, stated

import math
import re
from collections.abc import Iterator

PAGE = "docs/known.md"
CELLS = 12 * 16 * 3  # of the grid


def grid(column):
    return single("grid.md", "Overall", column, samples=["all"])


def terms(column):
    return span(figures("grid.md", "Terms", column))


def extreme(section, column, pick):
    """The first cell of the row of the grid where a column is least or largest, and that number."""
    kept = [row for row in rows("grid.md", section, column) if row[column] != "-"]
    row = pick(kept, key=lambda row: number(row[column]))
    return next(iter(row.values())), number(row[column])


def worst_cells():
    """How many cells of the grid are named, of how many records each, the first of them, and that most often wrong."""
    named = [row for each in read("grid.md").tables("Worst cells") for row in each]
    words = [f"{len(named)}, of {grid('records') / CELLS:.0f} records each"]
    if named:
        cell = "{sensor}, {disturbance}, {samples} samples, "
        words.append(f"the worst: {cell}wrong {{wrong %}} %, false {{false %}} %".format_map(named[0]))
        wrong = max(named, key=lambda row: number(row["wrong %"]))
        words.append(f"most often wrong: {cell}{{wrong %}} %".format_map(wrong))
    return ["; ".join(words)]


def behind(*disturbances):
    """How often the answer is wrong or claims a false term in the rows of some disturbances of the grid."""
    kept = rows("grid.md", "By disturbance", "disturbance", "wrong %", "false %")
    shares = [number(r["wrong %"]) + number(r["false %"]) for r in kept if r["disturbance"].startswith(disturbances)]
    if not shares:
        raise NotMadeError(f"grid.md, By disturbance: {disturbances}")
    return span(round(share, 1) for share in shares)


def over_bound(method, least=0.0, most=12.0):
    """Errors of a method over the bound, of the terms whose bound is between two percentages."""
    kept = [row for row in rows("methods.md", "", "bound %", "method", "rmse") if row["method"] == method]
    return span(number(row["rmse"]) for row in kept if least <= number(row["bound %"]) < most)


def cover(statistic_column):
    return span(figures("curves.md", "Coverage", statistic_column))


def drifted():
    """Largest difference of simulation and closed form on the flat earth, percent."""
    kept = (" ".join(row.values()) for row in rows("drift.md", "Strapdown", "noise"))
    return max(abs(float(value)) for row in kept for value in re.findall(r"\(([-+][\d.]+) %\)", row))


def headings(place):
    """Shares of records whose interval (0) or upper limit (1) of the heading holds the truth, percent."""
    kept = [list(row.values())[2:] for row in rows("drift.md", "Intervals of the heading", "records")]
    return span(float(cell.split(",")[place]) for row in kept for cell in row)


def filters(cover, until):
    """Errors over those predicted, of filters whose bias is a random walk, without aid up to a time."""
    columns = [f"{seconds} s" for seconds in (1, 10, 60, 300, 600, 1000) if seconds <= until]
    kept = rows("consistency.md", "Consistency, aid to 0.1 deg", "cover", "targets", *columns)
    kept = [row for row in kept if row["cover"] == cover and "kalibr" in row["targets"]]
    cells = [row[column].split("(")[0] for row in kept if "ADIS" not in row.get("sensor", "") for column in columns]
    return span(float(value) for cell in cells for value in re.findall(r"\d+\.\d+", cell))


def missed(file):
    """How many targets of a table are missed, and how many there are."""
    verdicts = [row[""] for row in rows(file, "", "wanted", "")]
    return verdicts.count("MISSED"), len(verdicts)


def totals(file, *columns):
    return [sum(figures(file, "", column)) for column in columns]


def environments():
    tests = [row["tests"] for row in rows("environments.md", "", "tests")]
    return [len(tests), sum("failed" in each for each in tests)]


def graded(column, word):
    """How many channels of recordings have a grade or a verdict."""
    return sum(row[column].partition(":")[0] == word for row in rows("recordings.md", "", column))


def n_off():
    """Largest difference of N from the deviation at 1 s in recordings that the model explains, percent."""
    column = "N over deviation at 1 s"
    kept = [row for row in rows("recordings.md", "", "grade", column) if row["grade"].startswith("explained")]
    return max(abs(100 * (number(row[column]) - 1)) for row in kept if row[column] not in ("", "-", "nan"))


def held(statistic):
    """How often 95 % limits of K and R hold the truth, by generalized least squares of a curve, percent."""
    return [single("theoh_paper.md", "95 % limits", term, statistic=[statistic]) for term in "KR"]


def predicted(method):
    return single("rate.md", "The paper's exp", "exact covariance", method=[method])


NUMBERS = [
    ("95 % intervals or limits hold the truth in {:g} to {:g} % of records", lambda: terms(
        "interval or limit holds %")),
    ("intervals of what is claimed alone in {:g} to {:g} %", lambda: terms("covers %")),
    ("least for {:s}: {:g} %", lambda: extreme("Terms", "covers %", min)),
    ("95 % upper limits hold in {:g} to {:g} % of records", lambda: terms("upper limit holds %")),
    ("a term that is absent is claimed in {:g} to {:g} %", lambda: terms("claimed where absent %")),
    ("claimed most often: {:s}, {:g} %", lambda: extreme("Terms", "claimed where absent %", max)),
    ("right {:g} %, refused {:g} %, wrong {:g} %, false {:g} %", lambda: [
        grid(f"{verdict} %") for verdict in ("right", "refused", "wrong", "false")]),
    ("cells above 6 %: {:s}; all", worst_cells),
    ("misleading {:g} % of records", lambda: [grid("misleading %")]),
    ("most often with {:s}: {:g} %", lambda: extreme("By disturbance", "misleading %", max)),
    ("in {:g} to {:g} % behind filters and with a resonance", lambda: behind(
        "RC low-pass", "Butterworth", "mean of", "resonance")),
    ("in {:g} to {:g} % with lines and waves", lambda: behind("line", "hum", "slow wave")),
    ("in {:g} to {:g} % with a step, a warm-up or popcorn noise", lambda: behind("step", "warm-up", "popcorn")),
    ("in {:g} % with gaps", lambda: behind("gaps")[:1]),
    ("in {:g} % with heavy tails", lambda: behind("heavy tails")[:1]),
    ("in {:g} to {:g} % with rounded samples", lambda: behind("rounded")),
    ("in {:g} % with repeated samples", lambda: behind("each sample")[:1]),
    ("| {:g} to {:g} times the bound where that is below 12 %", lambda: over_bound("whittle")),
    ("where it is larger, {:g} to {:g} times", lambda: over_bound("whittle", 12.0, math.inf)),
    ("`gls`: {:g} to {:g} times the bound where that is below 12 %", lambda: over_bound("gls")),
    ("the bound within {:.1f} % of full matrices", lambda: [
        100 * value for value in stated("methods.md", r"argest deviation of a ratio from 1(?: is|:) (\d+\.\d+)")]),
    ("gains its price in at most {:g} % of records", lambda: [max(figures("prices.md", "Gains", "above %"))]),
    ("{:.0f} of {:.0f} means beyond 3 standard errors", lambda: stated(
        "simulation.md", r"standard errors: (\d+) of (\d+) cells")),
    ("95 % limits hold in {:g} to {:g} % of records; with the noise known in {:g} to {:g} %", lambda: [
        *cover("noise identified %"), *cover("noise known %")]),
    ("with gaps the limits hold in {:g} to {:g} %", lambda: cover("with gaps %")),
    ("allantools' limits hold in {:g} to {:g} %", lambda: cover("allantools %")),
    ("degrees of freedom within {:g} % of sums over all windows", lambda: [
        max(max(figures("moments.md", "", column)) for column in ("single", "pairs", "random", "sensors"))]),
    ("the mean is {:g} to {:g} times the expectation", lambda: span(
        figures("moments.md", "", "mean / expected", bias=["model"]))),
    ("the power law is right in {:.0f} % of records on average", lambda: [mean(figures("moments.md", "", "found %"))]),
    ("{:g} to {:g} % of pairs of equal devices at a level of 5 %", lambda: span(
        figures("comparison.md", "Equal", "called different %", test=["verdict"]))),
    ("{:g} to {:g} % of ratios at a level of 5 %", lambda: span(figures("comparison.md", "Ratio", "size %"))),
    ("{:.0f} of {:.0f} right recordings are contradicted", lambda: stated(
        "check.md", r"false alarms: (\d+) of (\d+) right")),
    ("{:.0f} of {:.0f} defects are found in every recording, the cause of {:.0f} is named", lambda: stated(
        "check.md", r"every record: (\d+) of (\d+) defects; cause named in more than half of the records: (\d+)")),
    ("{:.0f} of {:.0f} records contradict their own cut-off", lambda: stated(
        "check.md", r"cut-off: (\d+) of (\d+) records")),
    ("errors {:g} to {:g} times those predicted up to 60 s without aid, {:g} to {:g} times without a cover", lambda: [
        *filters("default", 60), *filters("no", 60)]),
    ("up to 1000 s {:g} to {:g} times", lambda: filters("default", 1000)),
    ("95 % intervals hold in {:g} to {:g} %, by method", lambda: span(
        figures("rate.md", "Predictions", "cover of 95 %"))),
    ("in {:g} to {:g} % with white noise", lambda: span(figures("angle.md", "", "95 % cover", base=["still"]))),
    ("in {:g} to {:g} % with a random walk", lambda: span(
        figures("angle.md", "", "95 % cover", base=["still, random walk"]))),
    ("simulated errors {:+g} to {:+g} % beside the predicted ones", lambda: span(
        figures("vertical.md", "Predicted", "difference"))),
    ("false effects in {:g} to {:g} % of records", lambda: span(figures("compensation.md", "", "false %"))),
    ("by ordinary least squares in {:g} to {:g} %", lambda: span(figures("compensation.md", "", "ordinary %"))),
    ("hold a true effect in {:g} to {:g} % of records", lambda: span(
        figures("compensation.md", "", "within 95 % limits"))),
    ("simulated drift within {:g} %", lambda: [drifted()]),
    ("intervals of the heading hold in {:g} to {:g} %, upper limits in {:g} to {:g} %", lambda: [
        *headings(0), *headings(1)]),
    ("{:.0f} logs read right, {:.0f} wrong, {:.0f} without an answer", lambda: [
        single("logs.md", "", column, of=["all"]) for column in ("right", "wrong", "unanswered")]),
    ("failures: {:.0f} in {:.0f} cases", lambda: totals("fuzz.md", "failures", "cases")),
    ("a million messages in {:g} to {:g} s", lambda: span(figures("logs.md", "", "allanite s"))),
    ("100 averaging times in {:g} ms, the whole analysis in {:g} ms", lambda: [
        *stated("speed.md", r"the job (\d+) ms"), *stated("speed.md", r"analysis (\d+) ms")]),
    ("{:.0f} of {:.0f} targets are missed", lambda: missed("speed.md")),
    ("the first analysis takes {:g} s, the second {:g} s", lambda: figures(
        "speed.md", "First run", "median", run=["first", "second"])),
    ("sums of {:.0f} bytes", lambda: stated("streams.md", r"holds (\d+) bytes")),
    ("coefficients {:g} to {:g} times the bound", lambda: span(figures("streams.md", "Coeff", "stream / bound"))),
    ("{:g} MB at most with `--memory 500MB`", lambda: [max(figures("streams.md", "", "peak MB"))]),
    ("failures: {:.0f} in {:.0f} runs", lambda: totals("kills.md", "failures", "runs")),
    ("answered within {:g} s", lambda: [max(figures("kills.md", "", "slowest s"))]),
    ("{:.0f} environments, tests fail in {:.0f}", environments),
    ("{:.0f} channels explained, {:.0f} with a reservation, {:.0f} not explained", lambda: [
        graded("grade", grade) for grade in ("explained", "approximate", "unexplained")]),
    ("an expert contradicts {:.0f}, leaves {:.0f} open", lambda: [graded("verdict", v) for v in ("wrong", "open")]),
    ("within {:.1f} % where the channel is explained", lambda: [n_off()]),
    ("K {:g} %, R {:g} % of records; by the Allan deviation {:g} and {:g} %", lambda: [*held("theoh"), *held("oadev")]),
    ("regression {:.2f} times better than averaging", lambda: [predicted("mean") / predicted("regression")]),
]  # fmt: skip
"""Parts of results, and the numbers of their braces; {:s} is a word or several."""


def plain(text: str) -> str:
    """A text in one line, without emphasis."""
    return " ".join(text.replace("*", "").split())


def arrived(text: str) -> str:
    """The page with links to the tables that have been made; in the place of others one to the index of all."""
    index = "not made yet](generated/benchmarks/index.md)"

    def link(match: re.Match[str]) -> str:
        made = (RESULTS / f"{match[1]}.md").exists()
        return (
            (match[0] if match[2] else f"[{match[1]}](generated/benchmarks/{match[1]}.md)")
            if made
            else f"[{match[1]}, {index}"
        )

    text = re.sub(rf"\[(\w+), {re.escape(index)}()", link, text)
    return re.sub(r"\[(\w+)[^]]*\]\((generated/benchmarks)/\1\.md\)", link, text)


def waiting() -> list[str]:
    """Rows with a number whose table has not been made, a line each."""
    rows = re.findall(r"^\| (.*?) \|.*…", (ROOT / PAGE).read_text("utf-8"), re.MULTILINE)
    return [f"{PAGE}: {promise}: not made yet" for promise in rows]


def broken() -> Iterator[str]:
    """Promises of the page that no other page makes, and tests that do not exist."""
    text = (ROOT / PAGE).read_text("utf-8")
    for words, where in re.findall(r"^\| (.*?) \((README|\[[\w ]+\]\(\w+\.md\))\) \|", text, re.MULTILINE):
        path = "README.md" if where == "README" else f"docs/{re.findall(r'[(](.*)[)]', where)[0]}"
        if plain(words).lower() not in plain((ROOT / path).read_text("utf-8")).lower():
            yield f"{path} does not say {words!r}, which {PAGE} lists"
    for test in re.findall(r"blob/main/(tests/[\w/]+\.py)", text):
        if not (ROOT / test).exists():
            yield f"{PAGE}: {test} does not exist"
