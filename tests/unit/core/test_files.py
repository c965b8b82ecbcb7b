"""Files are never overwritten unasked, and never half written."""

import os

import pytest
from tests.rows import refused, rows

from allanite.core.errors import UsageError
from allanite.core.files import demand_writable, write


def test_an_existing_file_is_kept_unless_it_is_to_be_replaced(tmp_path):
    path = tmp_path / "page.html"
    path.write_bytes(b"old")
    refused(UsageError, r"already exists.*force=True", lambda: write(path, b"new"))
    assert path.read_bytes() == b"old"
    write(path, b"new", force=True)
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["page.html"]


def test_folders_that_cannot_hold_the_file_are_named(tmp_path, monkeypatch):
    with pytest.raises(UsageError, match=r"'.*missing' of 'page.html' does not exist"):
        demand_writable(tmp_path / "missing" / "page.html")
    refused(UsageError, r"is a folder", lambda: demand_writable(tmp_path, force=True))
    # the system is stood in for: root may write everywhere
    monkeypatch.setattr("allanite.core.files.os.access", lambda *_: False)
    refused(UsageError, f"the folder '{tmp_path}' is not writable", lambda: demand_writable(tmp_path / "page.html"))


@rows("step, error", [("replace", OSError(28, "No space left on device")), ("fsync", OSError(5, "Input/output error"))])
def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch, step, error):
    path = tmp_path / "page.html"
    path.write_bytes(b"old")

    def fail(*_):
        raise error

    monkeypatch.setattr(os, step, fail)
    refused(UsageError, f"cannot be written .{error.strerror[:13]}", lambda: write(path, b"new", force=True))
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["page.html"]


def test_the_data_is_on_the_disk_before_the_name(tmp_path, monkeypatch):
    done, flush, replace = [], os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda fd: done.append(os.fstat(fd).st_size) or flush(fd))
    monkeypatch.setattr(os, "replace", lambda part, target: done.append("replace") or replace(part, target))
    write(tmp_path / "page.html", b"new")
    assert done == [3, "replace"]


def test_a_link_stays_a_link_and_a_new_file_has_ordinary_permissions(tmp_path):
    target, link = tmp_path / "target.html", tmp_path / "link.html"
    target.write_bytes(b"old")
    link.symlink_to(target)
    write(link, b"new", force=True)
    assert link.is_symlink()
    assert target.read_bytes() == b"new"
    umask = os.umask(0o022)
    try:
        write(tmp_path / "page.html", b"new")
    finally:
        os.umask(umask)
    assert (tmp_path / "page.html").stat().st_mode & 0o777 == 0o644


@pytest.mark.skipif(not os.path.exists("/dev/null"), reason="needs a device")
def test_a_device_is_written_into_not_replaced():
    write("/dev/null", b"gone")
    assert not os.path.isfile("/dev/null")
