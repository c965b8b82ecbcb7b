"""PyArrow: its modules are imported when one of their names is used."""

from typing import Any

from allanite.kernels import Later

pa: Any = Later("pyarrow")
pc: Any = Later("pyarrow.compute")  # which takes as long as the rest
csv: Any = Later("pyarrow.csv")
parquet: Any = Later("pyarrow.parquet")
