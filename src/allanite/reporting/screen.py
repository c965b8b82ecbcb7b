"""The first screen as text: at most 20 lines of at most 100 columns."""

import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from rich.cells import cell_len, set_cell_size
from rich.console import Console
from rich.text import Text

from allanite.phrases.phrase import join, say, say_count

from .digits import in_ascii, printable, printed_heading, printed_unit, with_units
from .first import Answer, Axes, First, Remark, Section, shown
from .language import tr
from .sheet import Table
from .text import wrapped

LINES, COLUMNS = 20, 100
"""The size of a first screen."""

FEWEST = 2
"""Lines of remarks for which rows of limits give way."""

SHORTEST = 12
"""Columns to which titles may be cut before they are left out."""


def render(first: First, *, width: int = COLUMNS, color: bool = False, ascii: bool = False) -> str:  # noqa: A002 - as in repr
    """The first screen for a terminal of `width` columns; with `ascii`, no signs."""
    return _printed(_Screen(min(width, COLUMNS), ascii=ascii).lines(first), color=color)


def render_brief(first: First, *, ascii: bool = False) -> str:  # noqa: A002 - as in repr
    """A line for each channel."""
    screen = _Screen(COLUMNS, ascii=ascii)
    return _printed(((screen.text(line), "") for line in first.brief()), color=False)


def _printed(lines: Iterable[tuple[str, str]], *, color: bool) -> str:
    out = io.StringIO()
    console = Console(file=out, width=10_000, force_terminal=color, color_system="standard" if color else None)
    for line, style in lines:
        console.print(Text(line.rstrip(), style=style), soft_wrap=True, highlight=False)
    return out.getvalue()


def _found(axes: Axes) -> Axes:
    """Without the rows of little weight."""
    return replace(axes, rows=[row for row in axes.rows if row.rank < 1])


class _Screen:
    """Lays out for a width, in lines with their styles."""

    def __init__(self, width: int, *, ascii: bool) -> None:  # noqa: A002 - as in repr
        self.width, self.ascii = width, ascii
        self.left = list[str]()

    def text(self, text: str) -> str:
        """As it is shown, in the language and with the signs of the terminal."""
        said = printable(tr(text))
        return in_ascii(said) if self.ascii else said

    def prose(self, text: str) -> str:
        """A sentence as it is shown, with its units."""
        return self.text(printed_unit(printable(tr(text))))

    def lines(self, first: First) -> list[tuple[str, str]]:
        """All lines: the answer, and as many remarks as there is room for."""
        head = [(line, "bold") for line in self.head(first)]
        foot = self.foot(first)
        grave, every = sum(remark.grave for remark in first.remarks), len(first.remarks)
        wanted = max(min(every, FEWEST), min(grave, 6) + (every > min(grave, 6)))  # and how many more there are
        room = LINES - len(head) - len(foot)
        answer = [(line, "") for line in self.answer(first.answer, room - wanted)]
        used = [(sign, why) for sign, why in first.legend if any(re.search(sign, line) for line, _ in answer)]
        first = replace(first, legend=used)
        remarks = [(line, "red" if i < grave else "") for i, line in enumerate(self.remarks(first, room - len(answer)))]
        parts = [part for part in (answer, remarks, [(line, "dim") for line in self.foot(first)]) if part]
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
        left = [say("Not found: {symbols}.", symbols=", ".join(self.left))] if self.left else []
        meanings = [*left, *(meaning for _, meaning in first.legend)]
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
            left = len(parts) - count
            more = [say_count(left, "{count} more note: --details", "{count} more notes: --details")] if left else []
            line = self.prose(join("; ", [*parts[:count], *more]))
            if cell_len(line) <= self.width:
                return line
        return self.cut(parts[0])

    def remarks(self, first: First, room: int) -> list[str]:
        """The remarks, a line each, and how many there are beside those."""
        told = list(first.remarks)
        if len(told) <= room:
            return [self.remark(remark) for remark in told]
        kept = max(room - 1, 0)
        left = len(told) - kept
        more = say_count(left, "and {count} more note: --details", "and {count} more notes: --details")
        return [*(self.remark(remark) for remark in told[:kept]), *([self.text(more)] if room > 0 else [])]

    def remark(self, remark: Remark) -> str:
        """On one line: clauses are left out at the end, and at last the rest of the first one."""
        for count in range(len(remark.clauses), 0, -1):
            line = self.prose(shown(remark, count))
            if cell_len(line) <= self.width:
                return line
        command = self.text(say(". Try {command}", command=remark.command)) if remark.command else ""
        bare = Remark(remark.about, remark.clauses[:1])
        about = cell_len(self.prose(remark.about)) + 2  # and the colon
        return self.cut(self.prose(shown(bare)), self.width - cell_len(command), about) + command

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
        if sections:
            return self.sections(sections, room)
        made = list[str]()
        for rank in (3, 2, 1):
            self.left = []
            made = [line for part in parts for line in self.part(part, rank)]
            if len(made) <= room:
                return made
        return list(self.shortened(parts, room))

    def sections(self, sections: Sequence[Section], room: int) -> list[str]:
        """All sections with equal shares of the room; if that is too little, the first ones."""
        kept = sections[: room // 2] if 2 * len(sections) > room else sections
        left, made = len(sections) - len(kept), list[str]()
        room -= 1 if left else 0
        for i, section in enumerate(kept):
            made += self.section(section, (room - len(made)) // (len(kept) - i))
        more = say_count(left, "and {count} more channel: --details", "and {count} more channels: --details")
        return [*made, *([self.text(more)] if left else [])]

    def section(self, section: Section, room: int) -> list[str]:
        """Its sentences, then as much of its table as there is room for."""
        name, said = self.text(section.name), list(section.said)
        lead, tables = f"{name}  " if name else "", [self.table(table) for table in section.tables]
        if not said and tables and name and tables[0][0].startswith(" " * (cell_len(name) + 1)):
            tables[0][0], name = name + tables[0][0][cell_len(name) :], ""  # in the empty heading of the first column
        wanted = min(sum(map(len, tables)), max(room // 2, 3))
        lines = wrapped(self.prose(said.pop(0)), self.width, lead, "  ") if said else [name] if name else []
        for text in said:
            lines += wrapped(self.prose(text), self.width, "  ", "    ")
        if len(lines) > room - wanted:
            kept = max(room - wanted, 1)
            lines = [*lines[: kept - 1], self.cut(f"{lines[kept - 1]} {self.text('…')}")]
        rows = [line for table in tables for line in table][: room - len(lines)]
        return [*lines, *rows]

    def shortened(self, parts: Sequence[Answer], room: int) -> Iterator[str]:
        """Each channel on a line, and how many there are beside those shown."""
        tables: list[Answer] = [_found(part).listed() if isinstance(part, Axes) else part for part in parts]
        lines = [line for part in tables for line in self.part(part, 1)]
        if len(lines) <= room:
            yield from lines
            return
        yield from lines[: room - 1]
        left = len(lines) - room + 1
        yield self.text(say_count(left, "and {count} more line: --details", "and {count} more lines: --details"))

    def part(self, part: Answer, rank: int) -> list[str]:
        """The lines of a part, with rows below this rank."""
        if isinstance(part, Axes):
            return self.axes(part, rank)
        if isinstance(part, Section):
            return self.section(part, LINES)
        return self.table(part) if isinstance(part, Table) else wrapped(self.prose(part), self.width, "", "  ")

    def axes(self, axes: Axes, rank: int) -> list[str]:
        """Channels side by side, with titles as long as there is room for; or a row for each where they do not fit."""
        rows = [row for row in axes.rows if row.rank < rank]
        self.left += [row.label for row in axes.rows if row not in rows and row.label not in self.left]
        longest = max((cell_len(self.text(row.title)) for row in rows), default=0)
        excess = max(self.wide(replace(axes, rows=rows).table()) - self.width, 0)
        if longest - excess >= SHORTEST:
            cut = [replace(row, title=self.cut(row.title, longest - excess)) for row in rows]
            return self.table(replace(axes, rows=cut).table())
        short = replace(axes, rows=rows).table(titles=False)
        return self.table(short if self.wide(short) <= self.width else replace(axes, rows=rows).listed())

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
                    row[j] = parts[0] + " " * (wide - cell_len(parts[0])) + sign + parts[1]
        return rows

    def table(self, table: Table) -> list[str]:
        """Columns with two blanks between; those aside, and at last those at the end, where all are too wide."""
        kept = [i for i, column in enumerate(table.columns) if not column.aside]
        if self.wide(table) > self.width and len(kept) < len(table.columns):
            return self.table(table.only(kept))
        if self.wide(table) > self.width and len(kept) > 2:
            return self.table(table.only(kept[:-1]))
        cells, widths = self.cells(table), self.widths(table)
        numbers = [column.kind == "number" for column in table.columns]
        lines = []
        for row in cells:
            line = "  ".join(
                " " * (wide - cell_len(cell)) + cell if right else cell + " " * (wide - cell_len(cell))
                for cell, wide, right in zip(row, widths, numbers, strict=True)
            )
            lines.append(line.rstrip())
        lines = lines[1:] if not lines[0].strip() else lines
        return [line if cell_len(line) <= self.width else set_cell_size(line, self.width).rstrip() for line in lines]
