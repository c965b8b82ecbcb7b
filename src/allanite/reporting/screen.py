"""The first screen as text: at most 20 lines of at most 100 columns."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

from rich.cells import cell_len, set_cell_size
from rich.text import Text

from allanite.phrases.phrase import join, say, say_count

from .digits import in_ascii, printable, printed_heading, printed_unit, with_units
from .first import Answer, Channels, First, Remark, Section, shown
from .language import tr
from .sheet import Column, Table
from .text import pad, printed_lines, wrapped

LINES, COLUMNS = 20, 100  # the size of a first screen
MIN_REMARK_LINES = 2  # lines of remarks for which rows of limits give way
MAX_GRAVE_LINES = 6  # lines of grave remarks for which any row of the answer gives way

_END = re.compile(r"[;；。]|(?<=[^.\s]{3})\.(?=\s+[A-ZА-Я](?![:,]| \())| (?=\([^()]*\)(?:$|[:;；。]|\.\s))")
"""Where a clause ends, or an aside begins that ends it."""

MIN_TITLE_COLUMNS = 12  # columns to which titles may be cut before they are left out


def render(first: First, *, width: int = COLUMNS, color: bool = False, ascii: bool = False) -> str:  # noqa: A002 - as in repr
    """The first screen for a terminal of `width` columns; with `ascii`, no signs."""
    lines = _Screen(min(width, COLUMNS), ascii=ascii).lines(first)
    return printed_lines((Text(line.rstrip(), style=style) for line, style in lines), color=color)


def render_brief(first: First, *, ascii: bool = False) -> str:  # noqa: A002 - as in repr
    """A line for each channel."""
    screen = _Screen(COLUMNS, ascii=ascii)
    return printed_lines(Text(screen.text(line).rstrip()) for line in first.brief())


def _wanted(told: "Sequence[tuple[list[str], str]]") -> int:
    """Lines of remarks for which rows of the answer give way: those that are grave, and a count of the others."""
    every = sum(len(lines) for lines, _ in told)
    grave = min(sum(len(lines) for lines, style in told if style), MAX_GRAVE_LINES)
    return max(min(every, MIN_REMARK_LINES), grave + (every > grave))


def _ends(text: str) -> list[int]:
    """Where a text may end, the last place first: behind a clause, or before an aside in brackets."""
    places = (end.start() for end in _END.finditer(text))
    return [len(text), *(i for i in reversed([*places]) if text.count("(", 0, i) == text.count(")", 0, i))]


@dataclass(frozen=True)
class _Told:
    """A sentence, what its lines begin with, and their width."""

    text: str
    first: str
    rest: str
    width: int

    @property
    def lines(self) -> list[str]:
        """The whole sentence."""
        return wrapped(self.text, self.width, self.first, self.rest)

    def within(self, room: int, cut: Callable[[str], str]) -> list[str]:
        """As many whole clauses as fit; of the first one, if need be, the beginning."""
        lines = list[str]()
        for end in _ends(self.text):
            lines = replace(self, text=self.text[:end]).lines
            if len(lines) <= room:
                return lines
        return [*lines[: room - 1], cut(" ".join((lines[room - 1], lines[room].strip())))]


@dataclass(frozen=True)
class _Part:
    """A section that is laid out: sentences, the heading of its table, and the rows."""

    sentences: Sequence[_Told]
    head: Sequence[str]
    rows: Sequence[str]

    @property
    def lines(self) -> list[str]:
        """All of it."""
        return [*(line for text in self.sentences for line in text.lines), *self.head, *self.rows]


def _main(table: Table) -> Table:
    """Without the columns aside."""
    return table.only([i for i, column in enumerate(table.columns) if not column.aside])


class _Screen:
    """Lays out for a width, in lines with their styles."""

    def __init__(self, width: int, *, ascii: bool) -> None:  # noqa: A002 - as in repr
        self.width, self.ascii = width, ascii
        self.omitted = list[str]()

    def text(self, text: str) -> str:
        """As it is shown, in the language and with the signs of the terminal."""
        line = printable(tr(text))
        return in_ascii(line) if self.ascii else line

    def prose(self, text: str) -> str:
        """A sentence as it is shown, with its units."""
        return self.text(printed_unit(printable(tr(text))))

    def lines(self, first: First) -> list[tuple[str, str]]:
        """All lines: the answer, and as many remarks as there is room for."""
        head = [(line, "bold") for line in self.head(first)]
        told = [(self.remark(remark), "red" if remark.grave else "") for remark in first.remarks]
        limits = any(row.rank for part in first.answer if isinstance(part, Channels) for row in part.rows)
        below = len(self.foot(replace(first, legend=()))) + bool(first.legend or limits)
        answer = [(line, "") for line in self.answer(first.answer, LINES - len(head) - below - _wanted(told))]
        used = first.key(line for line, _ in answer)
        foot = [(line, "dim") for line in self.foot(replace(first, legend=[("", why) for why in used]))]
        remarks = self.remarks(told, LINES - len(head) - len(foot) - len(answer))
        parts = [part for part in (answer, remarks, foot) if part]
        blanks = LINES - len(head) - sum(map(len, parts))
        made = head
        for part in parts:
            made, blanks = [*made, *([("", "")] if blanks > 0 and made else []), *part], blanks - 1
        return made

    def head(self, first: First) -> list[str]:
        """Title and verdict on a line, or on two."""
        title, verdict = self.text(first.title), self.text(first.verdict)
        if not verdict:
            return [self.cut(title)] if title else []
        if cell_len(title) + 3 + cell_len(verdict) <= self.width:
            return [f"{title}   {verdict}"]
        return [self.cut(title), self.cut(verdict)]

    def foot(self, first: First) -> list[str]:
        """The signs, how the file was read, and what next."""
        omitted = [say("Not found: {symbols}.", symbols=", ".join(self.omitted))] if self.omitted else []
        meanings = [*omitted, *(meaning for _, meaning in first.legend)]
        lines = [self.legend(meanings)] if meanings else []
        if first.read:
            lines.append(self.clauses(first.read))
        if first.after:
            lines += self.filled([f"{command} ({self.text(why)})" for command, why in first.after])
        return lines

    def legend(self, parts: Sequence[str]) -> str:
        """What the signs mean, the most important first; as many as fit."""
        lines = (self.text(join(" ", parts[:count])) for count in range(len(parts), 0, -1))
        return next((line for line in lines if cell_len(line) <= self.width), "")

    def filled(self, parts: Sequence[str]) -> list[str]:
        """What next, in as few lines as hold it."""
        lead = self.text(say("next:")) + " "
        lines = [lead + parts[0]]
        for part in parts[1:]:
            if cell_len(lines[-1]) + 3 + cell_len(part) <= self.width:
                lines[-1] += f"   {part}"
            else:
                lines.append(" " * cell_len(lead) + part)
        return [self.cut(line) for line in lines]

    def clauses(self, parts: Sequence[str]) -> str:
        """As many of the parts as fit, and the number of those left out."""
        for count in range(len(parts), 0, -1):
            others = len(parts) - count
            more = say_count(others, "{count} more note: --details", "{count} more notes: --details")
            line = self.prose(join("; ", [*parts[:count], *([more] if others else [])]))
            if cell_len(line) <= self.width:
                return line
        rest = self.prose(join("", ["; ", more])) if others else ""
        return self.cut(self.prose(parts[0]), self.width - cell_len(rest)) + rest

    def remarks(self, told: "Sequence[tuple[list[str], str]]", room: int) -> list[tuple[str, str]]:
        """The remarks in their styles, and how many there are beside those."""
        if sum(len(lines) for lines, _ in told) <= room:
            return [(line, style) for lines, style in told for line in lines]
        kept = sum(taken < room for taken in accumulate(len(lines) for lines, _ in told))  # and a line that counts
        more = say_count(len(told) - kept, "and {count} more note: --details", "and {count} more notes: --details")
        shown = [(line, style) for lines, style in told[:kept] for line in lines]
        return [*shown, (self.text(more), "")] if room > 0 else []

    def remark(self, remark: Remark) -> list[str]:
        """On one line, for which clauses are left out at the end; the first clause is whole, on several if need be."""
        text = tr(join("; ", remark.clauses))
        made = ""
        for end in _ends(text):
            stop = "." if end < len(text) and not remark.command else ""
            made = self.prose(shown(replace(remark, clauses=[text[:end] + stop])))
            if cell_len(made) <= self.width:
                return [made]
        return wrapped(made, self.width, "", "  ")

    def cut(self, text: str, width: int | None = None, least: int = 0) -> str:
        """The text up to the last sign or word that fits; more than `least` cells of it, if they fit."""
        width = self.width if width is None else width
        line = self.text(text)
        if cell_len(line) <= width:
            return line
        dots = ".." if self.ascii else "…"
        kept = set_cell_size(line, width - cell_len(dots))
        at = max(kept.rfind(sign) for sign in (" (", ": ", "; ", ", "))
        if at < max(width / 2, least):
            at = kept.rfind(" ")
        return (kept[:at] if at > max(width / 3, least) else kept).rstrip(" ,;:") + dots

    def answer(self, parts: Sequence[Answer], room: int) -> list[str]:
        """The parts of the answer, of which rows of little weight are left out where there are too many."""
        sections = [part for part in parts if isinstance(part, Section)]
        if len(sections) == len(parts):
            return self.sections(sections, room)
        for rank in (3, 2, 1):
            self.omitted = []
            made = [line for part in parts for line in self.part(part, rank)]
            if len(made) <= room:
                return made
        tables = (  # without the rows of little weight
            self.listed(replace(part, rows=[row for row in part.rows if row.rank < 1]))
            if isinstance(part, Channels) else part for part in parts
        )  # fmt: skip
        made = [line for part in tables for line in self.part(part, 1)]
        return made if len(made) <= room else self.counted(made[: max(room - 1, 0)], len(made), 0)

    def counted(self, lines: list[str], every: int, channels: int) -> list[str]:
        """The lines, and how many of every one are left out, with whole channels."""
        rest = every - len(lines)
        more = say_count(rest, "and {count} more line: --details", "and {count} more lines: --details")
        if channels:
            more = say_count(
                channels, "and {lines} more lines, among them {count} whole channel: --details",
                "and {lines} more lines, among them {count} whole channels: --details", lines=rest,
            )  # fmt: skip
        return [*lines, self.text(more)]

    def sections(self, sections: Sequence[Section], room: int) -> list[str]:
        """All sections, or equal shares of them; if the room is too little for that, those of the first ones."""
        parts = [self.section(section) for section in sections]
        every = sum(len(part.lines) for part in parts)
        if every <= room:
            return [line for part in parts for line in part.lines]
        joint = self.joint(sections)
        made = list(joint[0].head) if joint else []
        parts = [replace(part, head=[]) for part in joint] or parts
        every = len(made) + sum(len(part.lines) for part in parts)
        if every <= room:
            return [*made, *(line for part in parts for line in part.lines)]
        room -= 1  # of the count
        least = [min(len(part.lines), 1 if part.sentences else 1 + len(part.head)) for part in parts]
        kept = sum(taken <= room - len(made) for taken in accumulate(least))
        for i in range(kept):
            spare = room - len(made) - sum(least[i:kept])
            made += self.beginning(parts[i], least[i] + spare // (kept - i))
        return self.counted(made, every, len(parts) - kept)

    def joint(self, sections: Sequence[Section]) -> "list[_Part]":
        """Sections that are tables with the same columns as one, whose first column has their names."""
        tables = [table for section in sections for table in section.tables]
        alike = {tuple(tr(column.heading) for column in table.columns[1:]) for table in tables}
        if len(alike) != 1 or len(tables) != len(sections) or any(section.sentences for section in sections):
            return []
        rows = [[section.name if not i else "", *row] for section, table in zip(sections, tables, strict=True)
                for i, row in enumerate(table.rows)]  # fmt: skip
        table = replace(tables[0], columns=[Column("", "name"), *tables[0].columns], rows=rows, marks=())
        head, *lines = self.table(table)
        ends = list(accumulate(len(table.rows) for table in tables))
        return [_Part([], [head], lines[end - len(table.rows) : end]) for end, table in zip(ends, tables, strict=True)]

    def section(self, section: Section) -> "_Part":
        """Its sentences, then its tables."""
        name, sentences = self.text(section.name), [self.prose(text) for text in section.sentences]
        head, *rows = [line for table in section.tables for line in self.table(table)] or [""]
        if sentences:
            lead = f"{name}  " if name else ""
            texts = [(sentences[0], lead, "  "), *((text, "  ", "    ") for text in sentences[1:])]
        elif name and head.startswith(" " * (cell_len(name) + 1)):
            texts, head = [], name + head[cell_len(name) :]  # in the empty heading of the first column
        else:
            texts = [(name, "", "  ")] if name else []
        return _Part([_Told(*text, self.width) for text in texts], [head] if head else [], rows)

    def beginning(self, part: "_Part", room: int) -> list[str]:
        """Its sentences as far as there is room, with a share for its table; a heading never alone."""
        share = min(len(part.head) + len(part.rows), max(room // 2, 3))
        made = list[str]()
        for text in part.sentences:
            rest = max(room - share, 1) - len(made)
            if rest > 0:
                made += text.within(rest, self.cut)
        table = [*part.head, *part.rows][: room - len(made)]
        return [*made, *(table if len(table) > len(part.head) or not part.rows else [])]

    def part(self, part: Answer, rank: int) -> list[str]:
        """The lines of a part, with rows below this rank."""
        if isinstance(part, Channels):
            return self.channels(part, rank)
        if isinstance(part, Section):
            return self.section(part).lines
        return self.table(part) if isinstance(part, Table) else wrapped(self.prose(part), self.width, "", "  ")

    def channels(self, channels: Channels, rank: int) -> list[str]:
        """Channels side by side, with titles as long as there is room for; or a row for each where they do not fit."""
        rows = [row for row in channels.rows if row.rank < rank]
        self.omitted += [row.label for row in channels.rows if row not in rows and row.label not in self.omitted]
        longest = max((cell_len(self.text(row.title)) for row in rows), default=0)
        excess = max(self.wide(replace(channels, rows=rows).table()) - self.width, 0)
        least = max(MIN_TITLE_COLUMNS, cell_len(self.text(channels.sensor)))  # the heading of the titles is not cut
        if not excess or (longest - excess >= least and not channels.whole):
            cut = [replace(row, title=self.cut(row.title, longest - excess)) for row in rows]
            return self.table(replace(channels, rows=cut).table())
        channels = replace(channels, rows=rows)
        short, listed = channels.table(titles=False), self.listed(channels)
        if self.wide(short) <= self.width or len(channels.names) < 2:
            return self.table(short)
        if self.wide(_main(listed)) <= self.width:
            return self.table(listed)
        half = (len(channels.names) + 1) // 2
        halves = channels.only(slice(half)), channels.only(slice(half, None))
        return [line for part in halves for line in self.channels(part, rank)]

    def listed(self, channels: Channels) -> Table:
        """A row for each channel, with narrow cells where that is too wide."""
        table = channels.listed()
        return table if self.wide(table) <= self.width else channels.listed(narrow=True)

    def wide(self, table: Table) -> int:
        """Cells that the whole table takes."""
        return sum(self.widths(table)) + 2 * len(table.columns) - 2

    def widths(self, table: Table) -> list[int]:
        """Cells that each column takes."""
        return [max(map(cell_len, column)) for column in zip(*self.cells(table), strict=True)]

    def cells(self, table: Table) -> list[list[str]]:
        """Heading and rows as shown; in a column the signs of the intervals stand below each other."""
        rows = [[self.text(printed_heading(tr(column.heading))) for column in table.columns]]
        kinds = [column.kind for column in table.columns]
        for row in table.rows:
            shown = (tr(cell).replace("+-", "±") for cell in row)
            rows.append([self.text(with_units(cell, kind)) for cell, kind in zip(shown, kinds, strict=True)])
        sign = " +- " if self.ascii else " ± "
        for j in range(len(table.columns)):
            split = [row[j].split(sign) if sign in row[j] else None for row in rows]
            wide = max((cell_len(parts[0]) for parts in split if parts), default=0)
            for row, parts in zip(rows, split, strict=True):
                if parts:
                    row[j] = pad(parts[0], wide) + sign + parts[1]
        return rows

    def table(self, table: Table) -> list[str]:
        """Columns with two blanks between; those aside, and at last those at the end, where all are too wide."""
        kept, every = _main(table), len(table.columns)
        if self.wide(table) <= self.width:
            kept = table
        while self.wide(kept) > self.width - 2 and len(kept.columns) > 2 and kept is not table:
            kept = kept.only(range(len(kept.columns) - 1))
        table = kept
        cells, widths = self.cells(table), self.widths(table)
        numbers = [column.kind == "number" for column in table.columns]
        padded = ([pad(*cell) for cell in zip(row, widths, numbers, strict=True)] for row in cells)
        lines = ["  ".join(row).rstrip() for row in padded]
        lines = lines[1:] if not lines[0].strip() else lines
        if len(table.columns) < every:
            lines[0] += " …"
        return [self.cut(line) for line in lines]
