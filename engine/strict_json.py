"""Strict JSON (RFC 8259): the writer of every JSON file, line and document.

JSON has no infinity and no NaN: both are null. Text is made from values, never from other text, so that every parser
reads it.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: dataclasses by field, enumerations by name, NaN and infinity as None."""
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Enum):
        return value.name.lower()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, np.ndarray):
        return _plain_array(cast("NDArray[Any]", value))
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in cast("Mapping[Any, Any]", value).items()}
    if (as_mapping := getattr(value, "_asdict", None)) is not None:
        return plain(as_mapping())
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Sequence | set | frozenset):
        return [plain(item) for item in cast("Sequence[Any]", value)]
    return str(value)


def _plain_array(array: NDArray[Any]) -> Any:
    """Return an array as nested lists; numbers are looked at all at once."""
    if array.dtype.kind in "biu":
        return array.tolist()
    if array.dtype.kind == "f":
        finite = np.isfinite(array)
        values = array if finite.all() else array.astype(object)
        if values is not array:
            values[~finite] = None
        return cast("Any", values).tolist()
    return plain(cast("Any", array).tolist())


def json_text(
    value: Any, *, indent: int | None = None, separators: tuple[str, str] | None = None, ascii_only: bool = False
) -> str:
    """Return any value as strict JSON, on one line unless `indent` is given."""
    return json.dumps(plain(value), indent=indent, separators=separators, ensure_ascii=ascii_only, allow_nan=False)


def json_lines(columns: Mapping[str, Sequence[Any]]) -> Iterator[str]:
    """Return a table, given by columns of equal length, as one JSON object per row."""
    encode = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode
    rows = zip(*(plain(column) for column in columns.values()), strict=True)
    return (encode(dict(zip(columns, row, strict=True))) for row in rows)
