"""Tables of rows that a test goes through inside one case.

A row that fails is named by a subtest, and the rows after it still run.
"""

import functools
import inspect
from itertools import cycle, islice

import pytest

WHERE = inspect.Parameter.POSITIONAL_OR_KEYWORD


def rows(names, values, *, ids=None):
    """Run a test for each row inside one case.

    Used as `pytest.mark.parametrize` is, whose ids it takes. Each row has an empty folder in place of `tmp_path` and a
    `monkeypatch` of its own. Rows cannot carry marks, and no fixture can take a value of a row.
    """
    names = tuple(name.strip() for name in names.split(",")) if isinstance(names, str) else tuple(names)
    table = list(_named(names, list(values), ids))

    def decorate(test):
        signature = inspect.signature(test)
        taken = [p for p in signature.parameters.values() if p.name not in names]
        own = "subtests" in signature.parameters

        @functools.wraps(test)
        def each(**fixtures):
            subtests = fixtures["subtests"] if own else fixtures.pop("subtests")
            for k, (label, row) in enumerate(table):
                with subtests.test(msg=label), pytest.MonkeyPatch.context() as patch:
                    test(**dict(zip(names, row, strict=True)), **_fresh(fixtures, k, patch))

        del each.__wrapped__  # pytest reads the signature below
        more = [] if own else [inspect.Parameter("subtests", WHERE)]
        each.__signature__ = signature.replace(parameters=[*taken, *more])
        each.row_count = len(table) * getattr(test, "row_count", 1)
        if "is_hypothesis_test" in vars(each):  # each row is one; their loop is none, and may have any fixtures
            for name in [name for name in vars(each) if "hypothesis" in name]:
                delattr(each, name)
            return pytest.mark.hypothesis(each)
        return each

    return decorate


def paired(*axes):
    """Each value of each axis at least once, in as many rows as the longest axis has: instead of their product."""
    length = max(map(len, axes))
    shifted = (_turned(axis, length) for axis in axes)
    return list(zip(*shifted, strict=True))


def _turned(axis, length):
    """A short axis repeated, each time begun one place further on, so that it meets a like axis differently."""
    axis = list(axis)
    turns = (axis[k % len(axis) :] + axis[: k % len(axis)] for k in range(length))
    return islice((value for turn in turns for value in turn), length) if len(axis) > 1 else islice(cycle(axis), length)


def _named(names, values, ids):
    for k, value in enumerate(values):
        if getattr(value, "marks", ()):
            raise ValueError(f"row {k} carries marks: rows of one case run together")
        row = getattr(value, "values", None) if isinstance(value, type(pytest.param())) else None
        label = getattr(value, "id", None) if row is not None else None
        row = row if row is not None else (value,) if len(names) == 1 else tuple(value)
        if label is None and ids is not None:
            label = ids[k] if not callable(ids) else "-".join(str(ids(part)) for part in row)
        yield label or ", ".join(str(part)[:60] for part in row), row


def _fresh(fixtures, k, patch):
    fresh = dict(fixtures)
    if "monkeypatch" in fresh:
        fresh["monkeypatch"] = patch
    if "tmp_path" in fresh:
        fresh["tmp_path"] = fresh["tmp_path"] / f"row{k}"
        fresh["tmp_path"].mkdir()
    for name in ("capsys", "capfd"):
        if name in fresh:
            fresh[name].readouterr()
    return fresh


def refused(error, match, call):
    """Check that a call is refused with an error whose message matches."""
    with pytest.raises(error, match=match):
        call()
