"""What can be planted into a file: small changes of four kinds, on their line, that are Python."""

import ast

import pytest

from planted import KINDS, drawn, found, rooms

SOURCE = '''"""Docstring - 2 * 3."""
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import a

__all__ = ["x" * 2]
LIMIT: "2 + 3" = 4.0 * (1 - 2)


def f(x: "a - b", y=-3):
    """No - fault."""
    if (
        x > 2
        or y
    ):
        raise ValueError(f"{x - 1}" + "no")
    demand_size(
        x,
        y,
    )
    x += 0.5
    return g(x, y, *y) + max(x, y) ** 2  # a + b
'''
CHANGES = {
    ("sign", "1 - 2", "1 + 2"), ("sign", "y=-3", "y=3"), ("sign", "x += 0.5", "x -= 0.5"),
    ("sign", "*y) + max", "*y) - max"), ("factor", "4.0 * (", "8.0 * ("), ("factor", "- 2)", "- 4)"),
    ("factor", "+= 0.5", "+= 1.0"), ("factor", "** 2 ", "** 4 "),
    ("arguments", "x,\n        y,\n", "y,\n        x,\n"), ("arguments", "g(x, y,", "g(y, x,"),
    ("check", "x > 2\n        or y\n", "False \\\n\n"),
    ("check", "demand_size(\n        x,\n        y,\n    )\n", "pass \\\n \\\n \\\n\n"),
}  # fmt: skip


@pytest.fixture
def planted(tmp_path):
    path = tmp_path / "room" / "module.py"
    path.parent.mkdir()
    path.write_text(SOURCE, encoding="utf-8")
    return [(fault, fault.planted(SOURCE.encode()).decode()) for fault in found(path, tmp_path)]


def test_every_place_is_found_and_no_other(planted):
    wanted = {(kind, SOURCE.replace(old, new)) for kind, old, new in CHANGES}
    assert {(fault.kind, text) for fault, text in planted} == wanted


def test_lines_stay_where_they_are(planted):
    for fault, text in planted:
        ast.parse(text)
        assert text.count("\n") == SOURCE.count("\n")
        before, after = SOURCE.splitlines(), text.splitlines()
        changed = [i for i, pair in enumerate(zip(before, after, strict=True), 1) if pair[0] != pair[1]]
        assert set(changed) <= set(fault.lines)


def test_only_what_is_in_a_function_runs_when_it_is_called(planted):
    assert {fault.lines.start for fault, _ in planted if not fault.scope} == {8, 11}
    assert {fault.scope for fault, _ in planted} == {0, 11}


@pytest.mark.slow("takes more than half a second")
def test_rooms_and_kinds_take_turns():
    first, again = (list(drawn(4, 1)) for _ in range(2))
    assert first == again
    assert [fault.room for fault in first] == rooms()[:4]
    assert [fault.kind for fault in first] == list(KINDS)
