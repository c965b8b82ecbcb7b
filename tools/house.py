"""Measure the source: lines, chains of imports, names that exist twice, functions used once, context variables.

python tools/house.py            one table for the package
python tools/house.py ROOM ...   the functions used once and the most complex ones of these packages
"""

import ast
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

SRC = Path(__file__).parents[1] / "src"
PACKAGE = "allanite"

Function = ast.FunctionDef | ast.AsyncFunctionDef


@cache
def modules() -> dict[str, ast.Module]:
    """The syntax tree of each module, by its dotted name."""
    found = {}
    for path in sorted((SRC / PACKAGE).rglob("*.py")):
        parts = path.relative_to(SRC).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


def lines() -> int:
    """Lines of the package."""
    return sum(path.read_bytes().count(b"\n") for path in (SRC / PACKAGE).rglob("*.py"))


def _top(tree: ast.Module) -> Iterator[ast.stmt]:
    """Statements that run at import; those for type checkers do not."""
    for node in tree.body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node


def imports() -> dict[str, set[str]]:
    """The modules of the package that each module imports at once."""
    known, result = modules(), {}
    for name, tree in known.items():
        base = SRC.joinpath(*name.split("."))
        package = name if base.is_dir() else name.rpartition(".")[0]
        met: set[str] = set()
        for node in _top(tree):
            if isinstance(node, ast.Import):
                met |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                up = package.split(".")
                root = ".".join(up[: len(up) - node.level + 1]) if node.level else ""
                stem = ".".join(filter(None, (root, node.module or "")))
                inner = {f"{stem}.{alias.name}" for alias in node.names}
                met |= {one if one in known else stem for one in inner}
        result[name] = {one for one in met if one in known} - {name}
    return result


def longest_chain() -> list[str]:
    """The longest chain of imports."""
    graph = imports()

    @cache
    def chain(name: str) -> tuple[str, ...]:
        return (name, *max((chain(one) for one in graph[name]), key=len, default=()))

    return list(max(map(chain, graph), key=len))


def functions() -> list[tuple[str, Function]]:
    """Each function with the name of its module."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    return [(name, node) for name, tree in modules().items() for node in ast.walk(tree) if isinstance(node, kinds)]


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
    return [
        ("lines", lines()),
        ("modules", len(modules())),
        ("longest chain of imports", len(longest_chain())),
        ("private functions", private),
        ("of these used once, %", round(100 * len(once) / private, 1)),
        ("class names that exist twice", len(classes_twice())),
        ("module names that exist twice", len(modules_twice())),
        ("context variables", len(context_variables())),
        ("largest complexity", f"{complexity(most[1])} ({most[0]}.{most[1].name})"),
    ]


def main(rooms: list[str]) -> None:
    """Print the table, or what is behind it in some packages."""
    if not rooms:
        for name, value in table():
            print(f"{name:32} {value}")
        return
    once, _ = used_once()
    for room in rooms:
        inside = f"{PACKAGE}.{room}"
        some = [(module, name) for module, name in once if module.startswith(inside)]
        private = sum(_private(node.name) for module, node in functions() if module.startswith(inside))
        print(f"{room}: {len(some)} of {private} private functions are used once")
        for module, name in some:
            print(f"  {module.removeprefix(PACKAGE + '.')}.{name}")
        hard = [(complexity(node), module, node.name) for module, node in functions() if module.startswith(inside)]
        for many, module, name in sorted(hard, reverse=True)[:5]:
            print(f"  complexity {many}: {module.removeprefix(PACKAGE + '.')}.{name}")


if __name__ == "__main__":
    main(sys.argv[1:])
