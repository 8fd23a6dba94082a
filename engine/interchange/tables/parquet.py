"""Parquet through pyarrow, which only the extra brings: imported when asked for, and missed with a cure."""

import json
from collections.abc import Mapping, Sequence
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from engine.extras import installing
from engine.interchange.errors import InterchangeError

EGO, NAMES = b"host_vehicle_idx", b"cortexc_names"
"""Metadata: omega-prime's own key for the ego, and ours for names, a JSON list by idx."""
LONGEST_NAMES = 1_000_000


def parquet_bytes(table: Mapping[str, np.ndarray], names: Sequence[str]) -> bytes:
    """A Parquet file of columns; `names` by idx, the ego's first.

    Raises:
        InterchangeError: pyarrow is not installed.
    """
    arrow, parquet = _pyarrow("pyarrow"), _pyarrow("pyarrow.parquet")
    metadata = {EGO: b"0", NAMES: json.dumps(list(names), ensure_ascii=False).encode()}
    out = BytesIO()
    parquet.write_table(arrow.table(dict(table)).replace_schema_metadata(metadata), out)
    return out.getvalue()


class ParquetFile:
    """An open file: its names and size are known before anything is read."""

    def __init__(self, path: Path) -> None:
        """Raises InterchangeError: pyarrow is not installed, or this is no Parquet."""
        parquet = _pyarrow("pyarrow.parquet")
        self.file = path.name
        try:
            self._file: Any = parquet.ParquetFile(path)
        except (OSError, ValueError) as error:  # pyarrow's own errors are both
            raise _broken(path.name, error) from None
        self.header: list[str] = list(self._file.schema_arrow.names)
        self.rows = int(self._file.metadata.num_rows)
        self.metadata: Mapping[bytes, bytes] = self._file.schema_arrow.metadata or {}

    def column(self, name: str) -> np.ndarray:
        """One column: numbers, or texts as objects.

        Raises:
            InterchangeError: it has empty cells, or the file is damaged.
        """
        try:
            column = self._file.read(columns=[name]).column(name)
            values = column.to_numpy(zero_copy_only=False)
        except (OSError, ValueError) as error:
            raise _broken(self.file, error) from None
        if column.null_count:
            place = f"{self.file}, column `{name}`"
            raise InterchangeError(
                f"{column.null_count:,} cells are empty", "fill them, or leave their rows out", place
            )
        return values

    def names(self) -> Sequence[str]:
        """Names by idx, where the file tells them."""
        try:
            found = json.loads(self.metadata.get(NAMES, b"[]")[:LONGEST_NAMES])
        except ValueError:
            return ()
        return tuple(map(str, found)) if isinstance(found, list) else ()


def _broken(file: str, error: Exception) -> InterchangeError:
    reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
    return InterchangeError(f"this is no Parquet that can be read: {reason}", "write it again, or name another", file)


def _pyarrow(module: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        cure = f"{installing('export')}, or take CSV"
        raise InterchangeError("Parquet needs the package `pyarrow`, which is not installed", cure) from None
