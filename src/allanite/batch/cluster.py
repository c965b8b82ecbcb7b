"""Executor for the workers of a Dask scheduler, on this machine or on others."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from queue import Empty, SimpleQueue
from typing import Any

from allanite.core.errors import UsageError
from allanite.core.extras import demand_extra

from .executor import Done, Plain, Task, described

PATIENCE = 10
"""Seconds in which a scheduler must answer, and in which it must have a worker."""

SAME = ("python", "allanite", "numpy", "scipy", "numba")
"""What the numbers depend on: its version must be the same on all workers."""


@dataclass(frozen=True)
class Dask:
    """The workers of a Dask scheduler, which see the files by the same paths and have the same version of allanite.

    Another worker takes over from one that is lost; a file that has cost several workers is reported as failed.
    """

    address: str  # of the scheduler: ``tcp://10.0.0.5:8786``

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item in the order in which they are finished; see `Executor`."""
        demand_extra("dask", "distributed", what="a scheduler")
        distributed = import_module("distributed")
        try:
            client = distributed.Client(self.address, timeout=PATIENCE)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"the Dask scheduler {self.address!r} does not answer ({error}); start one with 'dask scheduler' and "
                f"workers with 'dask worker {self.address}', or check the address"
            ) from None
        with client:
            self._demand_workers(client)
            given, ended = {client.submit(task, item, pure=False): item for item in items}, SimpleQueue[Any]()
            for future in given:
                future.add_done_callback(ended.put)
            while given:
                try:
                    future = ended.get(timeout=PATIENCE)
                except Empty:  # a long record, or nobody works on it
                    self._demand_workers(client)
                else:  # a result that nobody holds is forgotten by the workers, too
                    yield self._done(future, given.pop(future))

    def _done(self, future: Any, item: Plain) -> Done:
        """What became of an item whose future has ended."""
        if future.cancelled():
            raise UsageError(
                f"the Dask scheduler {self.address!r} ended before the work was done; start it again and repeat the "
                "command: what is stored is not done again"
            )
        problem = future.exception()
        if problem is None:
            return Done(item, future.result())
        if type(problem).__name__ == "KilledWorker":
            return Done(item, error="every worker that analyzed it was lost; is there memory for so many workers?")
        return Done(item, error=described(problem))

    def _demand_workers(self, client: Any) -> None:
        """Refuse a scheduler without workers, and workers of other versions than those of this process."""
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise UsageError(
                f"the Dask scheduler {self.address!r} has no worker; start some with 'dask worker {self.address}' and "
                "repeat the command: what is stored is not done again"
            ) from None
        seen = client.get_versions(packages=SAME[1:])
        here, wrong = _versions(seen["client"]), []
        for worker, each in sorted(seen["workers"].items()):
            other = [
                f"{name} {has} instead of {here[name]}" for name, has in _versions(each).items() if has != here[name]
            ]
            wrong += [f"{worker} has {', '.join(other)}"] if other else []
        if wrong:
            more = f" (and {len(wrong) - 3} more)" if len(wrong) > 3 else ""
            raise UsageError(
                f"the Dask workers have other versions than this computer: {'; '.join(wrong[:3])}{more}; install the "
                "same versions everywhere and start the workers again"
            )


def _versions(seen: Any) -> dict[str, str]:
    """Versions of what must be the same; of Python the first two numbers."""
    packages = seen["packages"] | {"python": ".".join(seen["packages"]["python"].split(".")[:2])}
    return {name: packages[name] or "(missing)" for name in SAME}
