"""The contents of a PX4 log, read with pyulog; started by `worker`.

Source of the format: PX4 Guide, ULog File Format (PX4 development team, version 1 of the file).
"""

import contextlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from pyulog import ULog


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The topics with their instances and fields, and a function that sends fields of one; see `worker.main`."""
    with contextlib.redirect_stdout(sys.stderr):  # where pyulog prints what it finds damaged
        log = ULog(path)
    topics = {f"{topic.name}/{topic.multi_id}": topic.data for topic in log.data_list if "timestamp" in topic.data}
    datasets = []
    for name, topic in topics.items():
        stamps = topic["timestamp"]
        kinds = [[field, values.dtype.str, ()] for field, values in topic.items() if values.dtype.kind in "iufb"]
        span = int(stamps[-1]) - int(stamps[0])  # us
        datasets.append({"path": name, "shape": [len(stamps)], "fields": kinds, "span": span})
    drops = [drop.duration for drop in log.dropouts]
    contents = {"datasets": datasets, "damaged": log.file_corruption, "dropouts": drops}

    def load(where: str, fields: list[str]) -> tuple[int, list[Any]]:
        rows = np.empty(len(topics[where][fields[0]]), [(name, topics[where][name].dtype) for name in fields])
        for name in fields:
            rows[name] = topics[where][name]
        return rows.nbytes, [rows.view(np.uint8).data]

    return contents, load
