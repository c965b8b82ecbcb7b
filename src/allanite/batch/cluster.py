"""Executor for the workers of a Dask scheduler, on this machine or on others."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module

from allanite.core.errors import UsageError
from allanite.core.extras import demand_extra

from .executor import Done, Plain, Task, described

PATIENCE = 10
"""Seconds in which a scheduler must answer."""


@dataclass(frozen=True)
class Dask:
    """The workers of a Dask scheduler, which see the files by the same paths and have the same version of allanite.

    A worker that is lost is replaced by another one; a file that has cost several workers is reported as failed.

    Attributes
    ----------
    address : str
        Of the scheduler: ``tcp://10.0.0.5:8786``.
    """

    address: str

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item in the order in which they are finished; see `Executor`.

        Raises
        ------
        UsageError
            dask is not installed, or the scheduler does not answer.
        """
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
            given = {client.submit(task, item, pure=False): item for item in items}
            for future in distributed.as_completed(given):
                item = given.pop(future)  # a result that nobody holds is forgotten by the workers, too
                problem = future.exception()
                if problem is None:
                    yield Done(item, future.result())
                elif type(problem).__name__ == "KilledWorker":
                    yield Done(item, error="every worker that analyzed it was lost; is there enough memory for so many "
                               "workers?")  # fmt: skip
                else:
                    yield Done(item, error=described(problem))
