"""Faults that are planted into the package: each changes a few characters of one file, and no line moves.

Four kinds: a binary + or - that becomes the other or a unary minus that is lost (sign), a number in arithmetic times
two (factor), two neighbouring arguments swapped (arguments), and a refusal or a call of demand_* or check_* that is
lost (check). Not in f-strings, annotations, blocks for type checkers and lists of exported names; arguments are not
swapped where their order does not matter, nor those of isinstance.
"""

import ast
import hashlib
import io
import re
import tokenize
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "src" / "allanite"
KINDS = ("sign", "factor", "arguments", "check")

AROUND, LONGEST = 24, 64  # characters that are shown on either side of a change, and of it

UNORDERED = {"min", "max", "hypot", "minimum", "maximum", "fmin", "fmax", "add", "multiply", "logaddexp", "gcd", "lcm"}
UNORDERED |= {"isinstance", "issubclass"}

ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)


@dataclass(frozen=True)
class Fault:
    """A change of one place: bytes of a file from `begin` to `end` become `new`."""

    file: str
    place: str
    kind: str
    begin: int
    end: int
    new: bytes
    lines: range
    scope: int
    """Line of the innermost function around it; 0 where it runs once, when the module is imported."""

    old: str = ""
    after: str = ""
    again: int = 1
    """Which one it is of those that look the same."""

    @property
    def room(self) -> str:
        """The package it is in."""
        return self.file.partition("/")[0]

    @property
    def key(self) -> str:
        """What names it, wherever its line is."""
        more = f" ({self.again})" if self.again > 1 else ""
        return f"{self.file} {self.place}: {self.old} → {self.after}{more}"

    def planted(self, text: bytes) -> bytes:
        """The file with the fault."""
        return text[: self.begin] + self.new + text[self.end :]


def _short(text: str) -> str:
    text = re.sub(r"\s+", " ", text)
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]}…{text[-LONGEST // 2 :]}"


def _shown(fault: Fault, text: bytes) -> Fault:
    """The fault with what stands there before and after it, and some characters on either side."""
    left = text[text.rfind(b"\n", 0, fault.begin) + 1 : fault.begin].decode().lstrip()
    right = text[fault.end :].partition(b"\n")[0].decode()
    left = left if len(left) <= AROUND else "…" + left[-AROUND:]
    right = right if len(right) <= AROUND else right[:AROUND] + "…"
    old, new = (_short(part.decode()) for part in (text[fault.begin : fault.end], fault.new.rstrip(b"\\\n ")))
    return replace(fault, old=f"{left}{old}{right}", after=f"{left}{new}{right}")


class _Finder(ast.NodeVisitor):
    """Every place of one file where a fault can be planted."""

    def __init__(self, file: str, text: bytes) -> None:
        self.file, self.text, self.found = file, text, list[Fault]()
        self.names, self.scope = list[str](), 0
        lengths = [0, *(len(line) for line in text.splitlines(keepends=True))]
        self.starts = [sum(lengths[: i + 1]) for i in range(len(lengths))]

    def place(self, node: ast.AST) -> tuple[int, int]:
        """Where a node begins and ends."""
        begin, end = self.starts[node.lineno - 1], self.starts[node.end_lineno - 1]
        return begin + node.col_offset, end + node.end_col_offset

    def source(self, node: ast.AST) -> bytes:
        begin, end = self.place(node)
        return self.text[begin:end]

    def add(self, kind: str, node: ast.AST, place: tuple[int, int], new: bytes) -> None:
        lines = range(node.lineno, node.end_lineno + 1)
        fault = Fault(self.file, ".".join(self.names) or "module", kind, *place, new, lines, self.scope)
        self.found.append(_shown(fault, self.text))

    def visit_all(self, nodes: Iterable[ast.AST | None]) -> None:
        for node in nodes:
            if node is not None:
                self.visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        self.visit_all([*node.decorator_list, *node.args.defaults, *node.args.kw_defaults])
        before, self.scope = self.scope, node.lineno
        self.names.append(node.name)
        self.visit_all(node.body)
        self.names.pop()
        self.scope = before

    visit_AsyncFunctionDef = visit_FunctionDef  # noqa: N815  named by ast

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.names.append(node.name)
        self.visit_all([*node.decorator_list, *node.body])
        self.names.pop()

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        self.visit_all([node.target, node.value])

    def visit_Assign(self, node: ast.Assign) -> None:
        if not any(isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets):
            self.generic_visit(node)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Positions within f-strings are exact from Python 3.12 on only."""

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if len(node.body) == 1 and isinstance(node.body[0], ast.Raise):
            rest = self.source(node.test).count(b"\n")
            self.add("check", node.test, self.place(node.test), b"False" + b" \\\n" * rest)
        self.generic_visit(node)

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            name = _name(node.value.func)
            if re.match(r"_?(demand|check)", name):
                self.add("check", node, self.place(node), b"pass" + b" \\\n" * self.source(node).count(b"\n"))
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if isinstance(node.op, ARITHMETIC):
            self.sign(node, node.op, (node.left, node.right))
            self.factor(node.left)
            self.factor(node.right)
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.op, ARITHMETIC):
            self.sign(node, node.op, (node.target, node.value))
            self.factor(node.value)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.USub):
            begin, _ = self.place(node)
            self.add("sign", node, (begin, begin + 1), b"")
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        if _name(node.func) not in UNORDERED:
            for one, other in zip(node.args, node.args[1:], strict=False):
                if not isinstance(one, ast.Starred) and not isinstance(other, ast.Starred):
                    self.swap(one, other)
        self.generic_visit(node)

    def sign(self, node: ast.AST, operator: ast.operator, sides: tuple[ast.expr, ast.expr]) -> None:
        if isinstance(operator, ast.Add | ast.Sub) and not any(map(_textual, sides)):
            begin, end = self.place(sides[0])[1], self.place(sides[1])[0]
            at = begin + _operator(self.text[begin:end])
            self.add("sign", node, (at, at + 1), b"+" if isinstance(operator, ast.Sub) else b"-")

    def factor(self, node: ast.expr) -> None:
        if isinstance(node, ast.UnaryOp):
            node = node.operand
        if isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.value not in (0, 1):
            self.add("factor", node, self.place(node), repr(2 * node.value).encode())

    def swap(self, one: ast.expr, other: ast.expr) -> None:
        first, second = self.source(one), self.source(other)
        if first != second:
            (begin, middle), (last, end) = self.place(one), self.place(other)
            lines = ast.Pass(lineno=one.lineno, end_lineno=other.end_lineno)
            self.add("arguments", lines, (begin, end), second + self.text[middle:last] + first)


def _name(function: ast.expr) -> str:
    """The last name of what is called."""
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _textual(node: ast.expr) -> bool:
    """Whether it is plainly no number."""
    listed = isinstance(node, ast.JoinedStr | ast.List | ast.Tuple | ast.ListComp | ast.Set | ast.Dict)
    return listed or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))


def _operator(between: bytes) -> int:
    """Where + or - stands between two operands, beside brackets and comments."""
    readable = tokenize.tokenize(io.BytesIO(b"(" * 9 + between).readline)
    try:
        for token in readable:
            if token.type == tokenize.OP and token.string in ("+", "-", "+=", "-="):
                lines = between.splitlines(keepends=True)
                row, column = token.start
                return sum(map(len, lines[: row - 1])) + column - (9 if row == 1 else 0)
    except tokenize.TokenError:
        pass
    raise ValueError(between)


def found(path: Path, package: Path = PACKAGE) -> list[Fault]:
    """The faults that can be planted into a file."""
    text = path.read_bytes()
    finder = _Finder(path.relative_to(package).as_posix(), text)
    finder.visit(ast.parse(text))
    counted, named = Counter[str](), []
    for fault in finder.found:
        counted[fault.key] += 1
        named.append(replace(fault, again=counted[fault.key]))
    return named


def rooms(package: Path = PACKAGE) -> list[str]:
    """Packages directly below the package."""
    return sorted(path.parent.name for path in package.glob("*/__init__.py"))


def order(faults: Iterable[Fault], seed: int) -> list[Fault]:
    """In the order of the digests of the seed and the key: a change elsewhere leaves it as it is."""
    return sorted(faults, key=lambda fault: hashlib.sha256(f"{seed} {fault.key}".encode()).digest())


def drawn(count: int, seed: int) -> Iterator[Fault]:
    """So many faults: rooms and kinds take turns; a room without a fault of the kind has one of the next kind."""
    every, pools = rooms(), dict[tuple[str, str], list[Fault]]()
    for i in range(count):
        room = every[i % len(every)]
        if (room, "sign") not in pools:
            faults = [fault for path in sorted((PACKAGE / room).rglob("*.py")) for fault in found(path)]
            pools |= {(room, kind): order((f for f in faults if f.kind == kind), seed) for kind in KINDS}
        turns = (pools[room, KINDS[(i + k) % len(KINDS)]] for k in range(len(KINDS)))
        pool = next((pool for pool in turns if pool), None)
        if pool is None:
            raise ValueError(f"no fault is left in {room}")
        yield pool.pop(0)
