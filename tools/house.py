"""Measure the source: lines, circles and chains of imports, names that say little, functions used once.

python tools/house.py            one table for the package
python tools/house.py ROOM ...   what is behind it in these packages
"""

import ast
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

SRC = Path(__file__).parents[1] / "src"
PACKAGE = "allanite"

VAGUE = frozenset({"found", "seen", "left", "there", "one", "said"})  # names of values that do not say what they hold
LARGE = 400  # lines above which a file holds more than one idea

Function = ast.FunctionDef | ast.AsyncFunctionDef
Graph = dict[str, set[str]]


@cache
def modules() -> dict[str, ast.Module]:
    """The syntax tree of each module, by its dotted name."""
    trees = {}
    for path in sorted((SRC / PACKAGE).rglob("*.py")):
        parts = path.relative_to(SRC).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        trees[name] = ast.parse(path.read_text(encoding="utf-8"))
    return trees


def file_of(name: str) -> Path:
    """The file of a module."""
    place = SRC.joinpath(*name.split("."))
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


@cache
def lines() -> dict[str, int]:
    """Lines of each module."""
    return {name: file_of(name).read_bytes().count(b"\n") for name in modules()}


def _is_for_checkers(node: ast.AST) -> bool:
    """Whether a statement is for type checkers alone."""
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)


def _statements(tree: ast.AST, *, inside: bool) -> Iterator[ast.AST]:
    """Statements that run at import, and with `inside` those of functions; never those for type checkers."""
    for node in ast.iter_child_nodes(tree):
        holds = isinstance(node, ast.stmt | ast.ExceptHandler | ast.match_case)
        if holds and not _is_for_checkers(node) and (inside or not isinstance(node, Function)):
            yield node
            yield from _statements(node, inside=inside)


def _imported(name: str, node: ast.AST) -> set[str]:
    """The modules of the package that a statement of a module imports."""
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names} & modules().keys()
    if not isinstance(node, ast.ImportFrom):
        return set()
    package = name if file_of(name).name == "__init__.py" else name.rpartition(".")[0]
    up = package.split(".")
    root = ".".join(up[: len(up) - node.level + 1]) if node.level else ""
    stem = ".".join(filter(None, (root, node.module or "")))
    inner = (f"{stem}.{alias.name}" for alias in node.names)
    return {full if full in modules() else stem for full in inner} & modules().keys()


def imports(*, inside: bool = False) -> Graph:
    """The modules of the package that each module imports at once, and with `inside` also when a function runs."""
    graph = {}
    for name, tree in modules().items():
        named = (_imported(name, node) for node in _statements(tree, inside=inside))
        graph[name] = set[str]().union(*named) - {name}
    return graph


def circles(graph: Graph) -> list[list[str]]:
    """The strongly connected components of more than one module, by Tarjan's algorithm."""
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    path: list[str] = []
    parts: list[list[str]] = []

    def visit(name: str) -> None:
        order[name] = lowest[name] = len(order)
        path.append(name)
        for other in sorted(graph[name]):
            if other not in order:
                visit(other)
            if other in path:
                lowest[name] = min(lowest[name], lowest[other])
        if lowest[name] == order[name]:
            at = path.index(name)
            parts.append(sorted(path[at:]))
            del path[at:]

    for name in graph:
        if name not in order:
            visit(name)
    return [part for part in parts if len(part) > 1]


def longest_chain() -> list[str]:
    """The longest chain of imports."""
    graph = imports()

    @cache
    def chain(name: str) -> tuple[str, ...]:
        return (name, *max((chain(other) for other in graph[name]), key=len, default=()))

    return list(max(map(chain, graph), key=len))


def _targets(node: ast.AST) -> Iterable[ast.expr]:
    """What a statement or an expression binds."""
    match node:
        case ast.Assign():
            return node.targets
        case ast.AnnAssign() | ast.AugAssign() | ast.NamedExpr() | ast.For() | ast.AsyncFor() | ast.comprehension():
            return [node.target]
        case ast.With() | ast.AsyncWith():
            return [item.optional_vars for item in node.items if item.optional_vars]
    return ()


def vague_names() -> list[tuple[str, int, str]]:
    """Module, line and name of each value whose name says little."""
    bound = (
        (module, name.lineno, name.id)
        for module, tree in modules().items()
        for node in ast.walk(tree)
        for target in _targets(node)
        for name in ast.walk(target)
        if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
    )
    return [place for place in bound if place[2] in VAGUE]


def functions() -> list[tuple[str, Function]]:
    """Each function with the name of its module."""
    return [(name, node) for name, tree in modules().items() for node in ast.walk(tree) if isinstance(node, Function)]


def _private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def _names(tree: ast.AST) -> Counter[str]:
    """How often each name is read."""
    nodes = list(ast.walk(tree))
    plain = Counter(node.id for node in nodes if isinstance(node, ast.Name))
    return plain + Counter(node.attr for node in nodes if isinstance(node, ast.Attribute))


def used_once() -> tuple[list[tuple[str, str]], int]:
    """Private functions that their module uses once, and the number of all private ones."""
    used = {name: _names(tree) for name, tree in modules().items()}
    private = [(module, node.name) for module, node in functions() if _private(node.name)]
    return [(module, name) for module, name in private if used[module][name] == 1], len(private)


def classes_twice() -> dict[str, list[str]]:
    """Class names that exist in several modules."""
    where: dict[str, list[str]] = defaultdict(list)
    for name, tree in modules().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                where[node.name].append(name)
    return {name: places for name, places in where.items() if len(places) > 1}


def modules_twice() -> Counter[str]:
    """Names of modules that occur twice or more."""
    stems = Counter(name.rpartition(".")[2] for name in modules())
    return Counter({name: count for name, count in stems.items() if count > 1})


def context_variables() -> list[str]:
    """Modules that hold a context variable, one entry for each."""
    calls = ((name, node) for name, tree in modules().items() for node in ast.walk(tree) if isinstance(node, ast.Call))
    return [name for name, node in calls if ast.unparse(node.func) == "ContextVar"]


def complexity(function: Function) -> int:
    """McCabe's cyclomatic complexity, as ruff counts it, with branches of expressions."""
    total = 1
    for node in ast.walk(function):
        if node is function:
            continue
        match node:
            case ast.If() | ast.For() | ast.AsyncFor() | ast.While() | ast.ExceptHandler():
                total += 1
            case ast.IfExp() | ast.comprehension() | ast.Assert():
                total += 1
            case ast.BoolOp():
                total += len(node.values) - 1
            case ast.Match():
                total += len(node.cases)
    return total


def table() -> list[tuple[str, Any]]:
    """The measures and their values."""
    once, private = used_once()
    most = max(functions(), key=lambda each: complexity(each[1]))
    words = Counter(name for *_, name in vague_names())
    return [
        ("lines", sum(lines().values())),
        ("modules", len(modules())),
        (f"files above {LARGE} lines", sum(count > LARGE for count in lines().values())),
        ("circles of imports, at once", len(circles(imports()))),
        ("circles with those of functions", len(circles(imports(inside=True)))),
        ("longest chain of imports", len(longest_chain())),
        ("names that say little", f"{words.total()} ({', '.join(f'{k} {v}' for k, v in words.most_common())})"),
        ("private functions", private),
        ("of these used once, %", round(100 * len(once) / private, 1)),
        ("class names that exist twice", len(classes_twice())),
        ("module names that exist twice", len(modules_twice())),
        ("context variables", len(context_variables())),
        ("largest complexity", f"{complexity(most[1])} ({most[0]}.{most[1].name})"),
    ]


def behind(room: str) -> Iterator[str]:
    """What is behind the table in a package, a line each."""

    def inside(module: str) -> bool:
        return f"{module}.".startswith(f"{PACKAGE}.{room}.")

    def shown(module: str) -> str:
        return module.removeprefix(f"{PACKAGE}.")

    once = [(module, name) for module, name in used_once()[0] if inside(module)]
    private = sum(_private(node.name) for module, node in functions() if inside(module))
    yield f"{room}: {len(once)} of {private} private functions are used once"
    yield from (f"  {shown(module)}.{name}" for module, name in once)
    yield from (f"  {shown(module)}:{line}: {name}" for module, line, name in vague_names() if inside(module))
    parts = (part for part in circles(imports(inside=True)) if any(map(inside, part)))
    yield from (f"  circle: {', '.join(map(shown, part))}" for part in parts)
    large = ((module, count) for module, count in lines().items() if inside(module) and count > LARGE)
    yield from (f"  {count} lines: {shown(module)}" for module, count in large)
    hard = [(complexity(node), module, node.name) for module, node in functions() if inside(module)]
    yield from (f"  complexity {many}: {shown(module)}.{name}" for many, module, name in sorted(hard, reverse=True)[:5])


def main(rooms: list[str]) -> None:
    """Print the table, or what is behind it in some packages."""
    for room in rooms:
        print(*behind(room), sep="\n")
    for name, value in [] if rooms else table():
        print(f"{name:32} {value}")


if __name__ == "__main__":
    main(sys.argv[1:])
