"""Tasks that other processes import."""

import os
import signal
import time
from pathlib import Path


def doubled(item):
    if item["x"] == 3:
        raise RuntimeError("three")
    return {"y": 2 * item["x"]}


def deadly(item):
    """Kills its own process: always, or the first time."""
    if item["x"] == "always" or (item["x"] == "once" and not Path(item["mark"]).exists()):
        Path(item["mark"]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"pid": os.getpid()}


def out_of_memory(item):
    raise MemoryError


def waiting(item):
    time.sleep(item["x"])
    return {"x": item["x"]}
