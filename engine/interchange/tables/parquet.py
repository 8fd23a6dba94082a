"""Parquet through pyarrow, which only the extra brings: imported when used; without it, an error with a cure."""

import json
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, cast

import numpy as np

from engine.errors import InterchangeError
from engine.extras import MissingExtraError, needed
from engine.strict_json import json_text

EGO, NAMES = b"host_vehicle_idx", b"cortexc_names"
"""Metadata: omega-prime's own key for the ego, and cortexc's for names, a JSON list by idx."""
ROAD, ROAD_NAME = b"xodr", b"xodr_name"
"""Metadata by omega-prime's own keys: the road as OpenDRIVE, and its name."""
LONGEST_NAMES = 1_000_000
LARGEST_COLUMN = 300_000_000
"""Maximum size of one unpacked column [bytes]; a million rows of twenty digits take a fifteenth of it."""
LONGEST_IDX = 19
"""Digits."""
TEXT_TYPES = ("string", "large_string", "string_view")
"""Types that hold texts, as pyarrow calls them."""


def parquet_bytes(table: Mapping[str, np.ndarray], names: Sequence[str], road: tuple[str, str] | None = None) -> bytes:
    """Return a Parquet file of columns; `names` by idx, the ego's first; `road`: name and OpenDRIVE of the road.

    Raises:
        InterchangeError: pyarrow is not installed.
    """
    arrow, parquet = _pyarrow("pyarrow"), _pyarrow("pyarrow.parquet")
    metadata = {EGO: b"0", NAMES: json_text(names).encode()}
    if road is not None:
        metadata |= dict(zip((ROAD_NAME, ROAD), (text.encode() for text in road), strict=True))
    out = BytesIO()
    parquet.write_table(arrow.table(dict(table)).replace_schema_metadata(metadata), out)
    return out.getvalue()


def embedded_road(path: Path) -> tuple[str, bytes] | None:
    """Return name and OpenDRIVE of the road in a Parquet file; None without a road.

    Raises:
        InterchangeError: pyarrow is not installed, or the file is not Parquet.
    """
    said = ParquetFile(path).metadata
    if not said.get(ROAD):
        return None
    return said.get(ROAD_NAME, b"").decode("utf-8", "replace"), said[ROAD]


class ParquetFile:
    """An open file: its names and size are known before its columns are read."""

    def __init__(self, path: Path) -> None:
        """Open a file.

        Raises:
            InterchangeError: pyarrow is not installed, or the file is not Parquet.
        """
        parquet = _pyarrow("pyarrow.parquet")
        self.file = path.name
        try:
            file: Any = parquet.ParquetFile(path)
            texts = [field.name for field in file.schema_arrow if str(field.type) in TEXT_TYPES]
            # each text once, however many rows hold it
            self._file: Any = parquet.ParquetFile(path, metadata=file.metadata, read_dictionary=texts)
        except (OSError, ValueError) as error:  # covers pyarrow's own errors
            raise _broken(path.name, error) from None
        self.header: list[str] = list(file.schema_arrow.names)
        self.rows = int(file.metadata.num_rows)
        self.metadata: Mapping[bytes, bytes] = file.schema_arrow.metadata or {}

    def is_dated(self, name: str) -> bool:
        """Return True if a column holds instants."""
        return str(self._file.schema_arrow.field(name).type).startswith("timestamp")

    def column(self, name: str, *, may_be_empty: bool = False) -> np.ndarray:
        """Return one column of numbers; instants are nanoseconds since 1970, empty cells NaN.

        Raises:
            InterchangeError: it has empty cells, is too large, or the file is damaged.
        """
        try:
            values = self._column(name, may_be_empty=may_be_empty).to_numpy(zero_copy_only=False)
            return values.astype("datetime64[ns]").astype(np.int64) if values.dtype.kind == "M" else values
        except (OSError, ValueError) as error:
            raise _broken(self.file, error) from None

    def texts(self, name: str) -> tuple[list[tuple[str, int]], np.ndarray]:
        """Return one column of texts or whole numbers: each text with its first row (from 0), and per row the number of
        its text.

        Raises:
            InterchangeError: it is of another type, has empty cells, is too large, or the file is damaged.
        """
        try:
            column = self._column(name)
            column = column.dictionary_encode() if not str(column.type).startswith("dictionary") else column
            column = column.unify_dictionaries().combine_chunks()
            column = column.chunk(0) if hasattr(column, "chunks") else column
            self._refuse_other(str(column.dictionary.type), name)
            numbers = column.indices.to_numpy(zero_copy_only=False)
            used, first, places = np.unique(numbers, return_index=True, return_inverse=True)
            texts = [str(column.dictionary[number].as_py()) for number in used.tolist()]
        except (OSError, ValueError) as error:
            raise _broken(self.file, error) from None
        return list(zip(texts, first.tolist(), strict=True)), places

    def _refuse_other(self, kind: str, name: str) -> None:
        if kind not in TEXT_TYPES and not kind.startswith(("int", "uint", "float", "double")):
            place = f"{self.file}, column `{name}`"
            raise InterchangeError(f"it should hold texts, and holds {kind}", "convert the column", place)

    def _column(self, name: str, *, may_be_empty: bool = False) -> Any:
        place = f"{self.file}, column `{name}`"
        if (size := self._size(name)) > LARGEST_COLUMN:
            raise InterchangeError(f"it unpacks to {size / 1e6:,.0f} MB", "leave out actors or samples", place)
        column = self._file.read(columns=[name]).column(name)
        if column.null_count and not may_be_empty:
            message = f"{column.null_count:,} cells are empty"
            raise InterchangeError(message, "fill them, or leave their rows out", place)
        return column

    def _size(self, name: str) -> int:
        """Return the unpacked size of a column [bytes]."""
        groups = (self._file.metadata.row_group(number) for number in range(self._file.metadata.num_row_groups))
        columns = (group.column(number) for group in groups for number in range(group.num_columns))
        return sum(each.total_uncompressed_size for each in columns if each.path_in_schema.split(".")[0] == name)

    def names(self) -> Sequence[str]:
        """Return the names by idx; empty if the file has none.

        Raises:
            InterchangeError: two actors have the same name.
        """
        try:
            found: Any = json.loads(self.metadata.get(NAMES, b"[]")[:LONGEST_NAMES])
        except (ValueError, RecursionError):
            return ()
        if not isinstance(found, list):
            return ()
        listed = cast("list[Any]", found)
        if not all(isinstance(name, str) and name.strip() for name in listed):
            return ()
        if len(set(listed)) < len(listed):
            raise InterchangeError("two actors have the same name in its metadata", "rename one of them", self.file)
        return tuple(listed)

    def host(self) -> int | None:
        """Return the ego's idx; None where the file has none."""
        said = self.metadata.get(EGO, b"").strip()
        return int(said) if said.isdigit() and len(said) < LONGEST_IDX else None


def _broken(file: str, error: Exception) -> InterchangeError:
    reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
    return InterchangeError(f"this is not a readable Parquet file: {reason}", "write it again, or name another", file)


def _pyarrow(module: str) -> Any:
    try:
        return needed(module, "Parquet needs", "export")
    except MissingExtraError as missing:
        raise InterchangeError(missing.message, f"{missing.cure}, or take CSV") from None
