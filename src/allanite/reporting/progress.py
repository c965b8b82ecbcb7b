"""A bar on stderr for what takes longer than a second."""

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from allanite.reporting.digits import printable

DELAY_S = 1.0  # seconds before the bar appears: what is over by then needs none


@contextmanager
def bar(shown: bool) -> Iterator[Callable[[str, float], None]]:
    """Give a function to be called with the current step and the completed fraction; in forks it does nothing."""
    if not shown:
        yield lambda what, fraction: None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    progress = Progress(
        TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=Console(stderr=True), transient=True
    )
    task = progress.add_task("", total=1.0)
    own = os.getpid()

    def tell(what: str, fraction: float) -> None:
        if os.getpid() == own:  # a fork must not wait for a lock that the bar's thread held
            progress.update(task, description=escape(printable(what)), completed=fraction)

    timer = threading.Timer(DELAY_S, progress.start)
    timer.daemon = True
    timer.start()
    try:
        yield tell
    finally:
        timer.cancel()
        # a bar that is just starting must have started before it can be stopped
        timer.join()
        progress.stop()
