"""Before the numbers: is the record fit for the job, and cutting it to what is."""

from .quality import inspect as inspect
from .trim import trim as trim
