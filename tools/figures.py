"""Numbers on pages that were measured: each is that of a committed table, and each table is cited with its date.

    python tools/figures.py [--check]

Renews the numbers of every sentence of `SENTENCES`, the rows of docs/known.md (tools/promises.py), and the date and
commit behind each link to a table. What no table has yet is shown as such. What cannot be renewed ends with exit code
1, with --check also what would be renewed: a sentence that a page does not have, a table that a page quotes without a
link to it, a row or a cell that no table has, a measured number that is not tied to a table.
"""

# ruff: noqa: D103  what a helper of the table below reads stands in its name and its one line

import cells
from cells import (  # first: it sets the number of threads
    READ,
    RESULTS,
    ROOT,
    NotMadeError,
    Page,
    figures,
    read,
    single,
    span,
    stated,
)

import re
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

from scipy.special import chdtri

import promises
from allanite.exporting.exports import EXPORTS
from consistency import OUTAGES
from stale import stamp


def theoh(column, statistic, method="gls"):
    return single("theoh_paper.md", "Coefficients", column, method=[method], statistic=[statistic])


def held(term, statistic):
    return single("theoh_paper.md", "95 % limits", term, statistic=[statistic])


def gained(term, statistic):
    return 100 * (1 - theoh(term, statistic) / theoh(term, "oadev"))


def efficiency(method):
    """Least and most error over the bound of well determined terms, where the bound is at most 12 %."""
    rows = cells.rows("methods.md", "Each method", "rmse")
    return span([float(r["rmse"]) for r in rows if r["method"] == method and float(r["bound %"]) <= 12])


def exact(method):
    return single("rate.md", "The paper's experiment", "exact covariance", method=[method])


ADIS = [f"adis_16405_imu{k}.rda" for k in (1, 2, 3)]
ACCELEROMETER = [f"mpu6050_static10min/mpu6050_{name}.mat" for name in ("gyroscope", "accelerometer")]


def n_off(files, channels):
    """Largest difference of N from the deviation at 1 s, percent."""
    ratios = figures("recordings.md", "Channels", "N over deviation at 1 s", file=files, channel=channels)
    return max(abs(100 * (ratio - 1)) for ratio in ratios)


def corners():
    """Of the low-passes of the x and y axes of the ADIS16405."""
    rows = [row for row in cells.rows("recordings.md", "Channels", "read") if row["file"] in ADIS]
    read_of = [row["read"] for row in rows if row["channel"] in ("Gyro. X", "Gyro. Y")]
    return span([float(re.search(r"-3 dB at ([\d.]+)", text)[1]) for text in read_of])


def compensated(column, noise=("table 2",), regressor=("temp",)):
    return span(figures("compensation.md", "", column, noise=noise, regressor=regressor))


def filters(what, cover, until, *targets):
    """Errors of filters over those predicted, or of the best: least and largest of all sensors, by outage."""
    rows = read("consistency.md").rows(f"{what}, aid to 0.1 deg")
    kept = [row for row in rows if row["cover"] == cover and set(targets) & set(row["targets"].split(", "))]
    return [float(number) for row in kept for t in OUTAGES if t <= until for number in row[f"{t} s"].split(" .. ")]


def closed(what, column="here"):
    return single("vertical.md", "Closed forms", column, what=[what])


def flicker(column, seconds):
    return single("vertical.md", "Flicker and random walk", column, **{"T [s]": [seconds]})


def loss(gyro, accelerometer, column="loss"):
    return single("vertical.md", "Loss", column, gyro=[gyro], accelerometer=[accelerometer])


def beside(sensor, *quantities):
    """What was measured over what the data sheet says, least and most, in channels of a sensor."""
    channels = [f"{sensor}. {axis}" for axis in "XYZ"]
    return span(figures("recordings.md", "Data sheets", "ratio", channel=channels, quantity=quantities))


WALK, STABLE = ("Angular Random Walk", "Velocity Random Walk"), ("In-Run Bias Stability",)
SPEED, LISTED = "speed.md", "N 0.3 deg/sqrt(h), B 10 deg/h, K 20 deg/h/sqrt(h)"
METHODS = "src/allanite/identification/methods.py"
FITS = {
    "whittle": "pending", "gls": "gls", "joint": "joint", "nnls": "nnls", "piecewise": "piecewise",
    "ls": "least_squares", "curve": "whole", "slopes": "slopes",
}  # fmt: skip
"""Function of each method, before its efficiency."""


SENTENCES = [
    ("README.md", "hold the truth in {:.0f} to {:.0f} % of records, by term", lambda: span(
        figures("grid.md", "Terms", "interval or limit holds %"))),
    ("README.md", "a claimed K alone in {:.0f} %", lambda: figures("grid.md", "Terms", "covers %", term=["K"])),
    ("README.md", "is claimed in at most {:.1f} % of records", lambda: [
        max(figures("grid.md", "Terms", "claimed where absent %"))]),
    ("README.md", "Allan deviation in {:g} ms", lambda: stated(SPEED, r"the job (\d+) ms")),
    ("README.md", "analysis in {:.1f} s, with one", lambda: [stated(SPEED, r"analysis (\d+) ms")[0] / 1000]),
    ("README.md", "of {} in all", lambda: [len(EXPORTS) - 2]),  # data sheet and matrices are no filter and no simulator
    ("README.md", "| {} targets |", lambda: [len(EXPORTS) - 2]),
    ("docs/data_sheet.md", "{:.2f} to {:.2f} times the angular random walk", lambda: beside("Gyro", *WALK)),
    ("docs/data_sheet.md", "the accelerometers {:.2f} to {:.2f} times", lambda: beside("Accel", *WALK)),
    ("docs/data_sheet.md", "the in-run stabilities are {:.2f} to {:.2f} and", lambda: beside("Gyro", *STABLE)),
    ("docs/data_sheet.md", "and {:.2f} to {:.2f} times the printed ones", lambda: beside("Accel", *STABLE)),
    ("docs/recordings.md", "is {:.2f} to {:.2f} times what it states", lambda: beside("Gyro", *WALK)),
    ("docs/stream.md", "of about {:.0f} kB", lambda: [stated("streams.md", r"holds (\d+) bytes")[0] / 1000]),
    ("docs/stream.md", "are {:.2f} to {:.2f} times", lambda: span(figures("streams.md", "Coeff", "stream / bound"))),
    ("docs/compare.md", "between {:.2f} and {:.0f} times the one seen (95 %)", lambda: [
        chdtri(1, tail) ** -0.5 for tail in (0.025, 0.975)]),
    ("docs/compare.md", "calls {:.2f} to {:.2f} % of {:g} pairs", lambda: [
        *span(figures("comparison.md", "Equal", "called different %", test=["verdict"])),
        *stated("comparison.md", r"(\d+) pairs a cell")]),
    ("docs/check.md", "{:g} of {:g} defects are found in every recording of 1 h, and the cause of {:g} is named",
        lambda: stated("check.md", r"found in every record: (\d+) of (\d+) defects; .*: (\d+) of \d+")),
    ("docs/check.md", "Without a defect, {:g} of {:g} recordings are contradicted", lambda: stated(
        "check.md", r"false alarms: (\d+) of (\d+) right")),
    ("docs/compensation.md", "temperature in {:.0f} to {:.0f} % of", lambda: compensated("ordinary %")),
    ("docs/compensation.md", "is found in {:.0f} to {:.0f} % of 400", lambda: compensated(
        "false %", regressor=("temp", "d temp/dt"))),
    ("docs/compensation.md", "squares: {:.0f} to {:.0f} %)", lambda: compensated("ordinary %")),
    ("docs/compensation.md", "effect in {:.0f} to {:.0f} %, and", lambda: compensated(
        "within 95 % limits", regressor=("temp", "d temp/dt"))),
    ("docs/compensation.md", "its interval, in {:.0f} to {:.0f} %", lambda: compensated("gain met %")),
    ("docs/compensation.md", "truth in {:.0f} to {:.0f} % of records", lambda: compensated(
        "within 95 % limits", ("white",), ("temp", "d temp/dt"))),
    ("docs/theoh_paper.md", "K and R are {:.0f} and {:.0f} % better", lambda: [gained(s, "theoh") for s in "KR"]),
    ("docs/theoh_paper.md", "alone gains {:.0f} % of R", lambda: [gained("R", "theo1")]),
    ("docs/theoh_paper.md", "zero, K {:g} beside {:g} and R {:g} beside {:g},", lambda: [
        theoh(column, statistic) for term in "KR" for column, statistic in
        ((term, "theo1"), (f"{term}, 0 if not claimed", "oadev"))]),
    ("docs/theoh_paper.md", "in {:.0f} % of 240 records and those of R in {:.0f} %", lambda:
        [held(s, "oadev") for s in "KR"]),
    ("docs/theoh_paper.md", "in {:.0f} and {:.0f} % by TheoH", lambda: [held(s, "theoh") for s in "KR"]),
    *((METHODS, f" {fit}, efficiency=times({{:.3g}}, {{:.3g}})", partial(efficiency, name))
      for name, fit in FITS.items()),
    ("docs/vertical.md", "{:.3f} s and {:.1f} arcsec. A", lambda: [
        closed("best time constant, s"), closed("error there, arcsec")]),
    ("docs/vertical.md", "shorter: {:.2f} s", lambda: [closed("with a bias of 10 deg/h: s, arcsec")]),
    ("docs/vertical.md", "is {:.2f} s ({:.1f} arcsec) for 10", lambda: [
        flicker(c, "600") for c in ("time constant [s]", "predicted [arcsec]")]),
    ("docs/vertical.md", "and {:.2f} s ({:.1f} arcsec) for an", lambda: [
        flicker(c, "3600") for c in ("time constant [s]", "predicted [arcsec]")]),
    ("docs/vertical.md", "of the {:.1f} arcsec", lambda:
        [loss(LISTED, "N 100 ug/sqrt(Hz), B 50 ug", "first order")]),
    ("docs/vertical.md", "is {:.0f} % for the sensors", lambda: [loss(LISTED, "N 100 ug/sqrt(Hz), B 50 ug")]),
    ("docs/vertical.md", "and {:.0f} % with K = 500", lambda: [
        loss("N 0.3 deg/sqrt(h), K 500 deg/h/sqrt(h)", "N 100 ug/sqrt(Hz)")]),
    ("docs/recordings.md", "(-3 dB at {:g} to {:g} Hz)", corners),
    ("docs/recordings.md", "at 1 s within {:.1f} %; the", lambda: [n_off(ADIS, ["Gyro. X", "Gyro. Y"])]),
    ("docs/recordings.md", "at 1 s within {:.1f} %; narrow", lambda: [
        n_off(ACCELEROMETER, [f"{kind}Buffer {k}" for kind in ("gyro", "accel") for k in (2, 3, 4)])]),
    ("docs/log_to_filter.md", "are up to {:.2f} times what it predicts. With", lambda: [
        max(filters("Consistency", "no", 1000, "kalibr"))]),
    ("docs/log_to_filter.md", "are {:.2f} to {:.2f} times that after 1 to 60 s", lambda: span(
        filters("Consistency", "default", 60, "kalibr"))),
    ("docs/log_to_filter.md", "correlation time, {:.2f} to {:.2f} times after 1 to 1000 s", lambda: span(
        filters("Consistency", "default", 1000, "navego"))),
    ("docs/log_to_filter.md", "`--cover 1,1000` they are {:.2f} to {:.2f} and {:.2f} to {:.2f} times.", lambda: [
        *span(filters("Consistency", "1,1000", 1000, "kalibr")),
        *span(filters("Consistency", "1,1000", 1000, "navego"))]),
    ("docs/log_to_filter.md", "{:.0f} % above those of the best filter with the default cover, and {:.0f} %",
        lambda: [
            100 * max(filters("Accuracy", cover, 10, "kalibr", "navego")) - 100 for cover in ("default", "1,1000")]),
    ("docs/rate_paper.md", "regression is {:.2f} times better", lambda: [exact("mean") / exact("regression")]),
    ("docs/rate_paper.md", "loses {:.1f} %, Hamming {:.1f} %", lambda: [
        100 * (figures("rate.md", "When", name)[0] - 1) for name in ("regression", "hamming")]),
    ("docs/angle_paper.md", "at least {:.1f} % lie", lambda: [
        min(figures("angle.md", "", "within 3 sigma %", base=["still"])) // 0.1 / 10]),
    ("docs/angle_paper.md", "in {:g} to {:g} %;", lambda: span(figures("angle.md", "", "95 % cover", base=["still"]))),
    ("docs/angle_paper.md", "then hold {:.0f} to {:.0f} %", lambda: span(
        figures("angle.md", "", "95 % cover", base=["still, random walk"]))),
    ("docs/angle_paper.md", "sum is {:.1f}, {:.1f} times", lambda: [
        stated("angle.md", r"30 min, linear law: .* deviations ([\d.]+)")[0],
        stated("angle.md", r"30 min, linear law: .* deviations ([\d.]+)")[0]
        / stated("angle.md", r"60 min, linear law: .* deviations ([\d.]+)")[0]]),
]  # fmt: skip
"""Page, sentence, and the numbers of its braces from the tables."""

SENTENCES += [(promises.PAGE, sentence, numbers) for sentence, numbers in promises.NUMBERS]


ROWS = [
    ("docs/theoh_paper.md", "theoh_paper.md", "Coefficients"),
    ("docs/theoh_paper.md", "theoh_paper.md", "Noise that changes"),
    ("docs/theoh_paper.md", "theoh_paper.md", "Expected TheoBR"),
    ("docs/theoh_paper.md", "theoh_paper.md", "Unweighted fit"),
]
"""Page, and the section whose rows it shows as they are."""


CELLS = [
    ("docs/rate_paper.md", "Comparison", "rate.md", "The paper's experiment"),
    ("docs/rate_paper.md", "Why the staircase", "rate.md", "Noise that fits"),
    ("docs/rate_paper.md", "The paper's descent", "rate.md", "The paper's descent"),
    ("docs/rate_paper.md", "Searching for the minimum", "rate.md", "The search for the staircase"),
    ("docs/angle_paper.md", "Table of accuracy", "angle.md", ""),
    ("docs/vertical.md", "No filter is the best", "vertical.md", "Scenarios"),
]
"""Page, its section, and the table whose numbers the rows there show, rounded; a row of the paper quotes it."""


def as_printed(number, cell):
    """Whether a cell rounds a number of a table, which is rounded itself: a tie may go either way."""
    return abs(number - float(cell)) <= 0.5 * 10.0 ** -len(cell.partition(".")[2]) * (1 + 1e-9)


MEASURED = re.compile(r"\d[\d.]* (?:%|times|ms\b|kB\b|s of)(?! intervals?\b| level)")
"""A number that somebody may have measured."""

TIED = ("README.md", "docs/compensation.md", "docs/theoh_paper.md", "docs/compare.md")
"""Pages on which each such number belongs to a sentence above, but for those of definitions."""

DEFINED = re.compile(
    r"95 % (?:intervals?|confidence|band)|68 % interval|level of \d+ %|bound is (?:below|at most) \d+ %"
    r"|below 12 % \||the truth \||within 4 %|accuracy of 10 %|up to 4 %|more than 50 % of a ramp"
)


LINK = re.compile(
    r"\[([^\]]*?)(?:, (?:\w+ )?\d{4}-\d\d-\d\d\W* ?\w* [0-9a-f]{7})?\]"
    r"\(((?:(?:\.\./)?generated/benchmarks|(?:\S*/)?benchmarks/results)/(\w+)\.md)\)"
)
"""A link to a table, with what `noted` writes into it."""

NOTES = {"_ru": "{date}, {commit}", "_zh": "{date}, {commit}"}  # what stands behind a link on pages in other languages


def pages() -> list[str]:
    """The pages at the top, and those of the documentation that are written by hand."""
    written = (*(ROOT / "docs").glob("*.md"), *(ROOT / "docs").glob("translations/*.md"))
    return ["README.md", "SECURITY.md", *sorted(path.relative_to(ROOT).as_posix() for path in written)]


def noted(page: str, text: str) -> str:
    """A page that says at each link to a table of what commit and day it is."""

    def link(found: re.Match[str]) -> str:
        path = RESULTS / f"{found[3]}.md"
        if not path.exists():  # the index of all
            return found[0]
        commit, date = stamp(Page(path.read_text("utf-8")))
        how = NOTES.get(Path(page).stem[-3:], "measured {date} at {commit}")
        said = how.format(date=date, commit=commit).replace("at before", "before")
        return f"[{found[1]}, {said}]({found[2]})"

    return LINK.sub(link, text)


UNKNOWN = "…"
"""In the place of a number whose table has not been made."""


def pattern(sentence: str) -> re.Pattern[str]:
    """A sentence with any numbers in its braces, however its lines are broken."""
    parts = [r"\s+".join(map(re.escape, part.split(" "))) for part in re.split(r"\{[^}]*\}", sentence)]
    kinds = (
        r"[^|]+?" if kind == "{:s}" else rf"(?:[-+\d.e]*\d|{UNKNOWN})" for kind in re.findall(r"\{[^}]*\}", sentence)
    )
    return re.compile("".join(part + kind for part, kind in zip(parts, (*kinds, ""), strict=True)))


def filled(sentence: str, numbers: Callable[[], Iterable[float]]) -> str:
    """A sentence with its numbers, or without those of a table that has not been made."""
    try:
        return sentence.format(*numbers())
    except NotMadeError:
        return re.sub(r"\{[^}]*\}", UNKNOWN, sentence)


def counted(page: str, text: str, problems: list[str]) -> str:
    """A page with the numbers of its sentences."""
    for where, sentence, numbers in SENTENCES:
        if where != page:
            continue
        READ.clear()
        new = filled(sentence, numbers)
        if UNKNOWN in new and page.startswith("src/"):  # the source keeps the number that it has
            continue
        link = r"benchmarks/(?:results/)?{0}.md|known\.md|\[{0}, not made yet"
        stems = {name.removesuffix(".md"): name for name in READ}
        lacking = [name for stem, name in stems.items() if not re.search(link.format(stem), text)]
        if not page.startswith("src/"):
            problems += [f"{page}: {sentence[:40]!r} quotes {name} without a link to it" for name in lacking]
        found = list(pattern(sentence).finditer(text))
        if len(found) != 1:
            problems.append(f"{page}: {len(found)} times {sentence!r}, once was expected")
        elif " ".join(found[0][0].split()) != new:
            text = text[: found[0].start()] + new + text[found[0].end() :]
    return text


def lost_rows() -> Iterator[str]:
    """Rows of tables that pages do not show as they are."""
    for page, file, section in ROWS:
        shown = (ROOT / page).read_text("utf-8")
        rows = (f"| {' | '.join(row.values())} |" for row in read(file).rows(section))
        yield from (f"{page} lacks a row of {file}: {row}" for row in rows if row not in shown)


def lost_cells() -> Iterator[str]:
    """Numbers in rows of pages that no cell of their table rounds to."""
    for page, part, file, section in CELLS:
        rows = Page((ROOT / page).read_text("utf-8")).rows(part)
        own = (row for row in rows if "paper," not in row.get("range of h, deg", ""))
        shown = [cell.strip("*") for row in own for cell in list(row.values())[1:]]
        measured = {cell.split()[0] for row in read(file).rows(section) for cell in list(row.values())[1:] if cell}
        numbers = [float(cell) for cell in measured if re.fullmatch(r"[\d.]+", cell)]
        for cell in shown:
            if re.fullmatch(r"[\d.]+", cell) and not any(as_printed(number, cell) for number in numbers):
                yield f"{page}, {part}: {cell} is no number of {file}"


def untied() -> Iterator[str]:
    """Measured numbers on pages that belong to no sentence."""
    for page in TIED:
        written = (ROOT / page).read_text("utf-8")
        left = " ".join(re.sub(r"```.*?```", "", written, flags=re.DOTALL).split())
        for where, sentence, _ in SENTENCES:
            left = pattern(sentence).sub("", left) if where == page else left
        yield from (f"{page}: {number!r} is of no table" for number in MEASURED.findall(DEFINED.sub("", left)))


def renewed() -> tuple[dict[str, str], list[str]]:
    """Texts of pages that are not up to date, and what cannot be renewed."""
    problems, texts = [], {}
    for page in dict.fromkeys((*pages(), *(page for page, _, _ in SENTENCES))):
        text = (ROOT / page).read_text("utf-8")
        new = counted(page, noted(page, promises.arrived(text) if page == promises.PAGE else text), problems)
        if new != text:
            texts[page] = new
    return texts, [*problems, *lost_rows(), *lost_cells(), *untied(), *promises.broken()]


def main(words: list[str]) -> None:
    """Renew or check."""
    texts, problems = renewed()
    if "--check" in words:
        problems += [f"{page} is not up to date: run python tools/figures.py" for page in texts]
    else:
        for page, text in texts.items():
            (ROOT / page).write_text(text, "utf-8")
            print(f"{page}: renewed")
        print(*promises.waiting(), sep="\n")
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main(sys.argv[1:])
