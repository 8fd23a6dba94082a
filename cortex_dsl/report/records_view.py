"""What the file asked to be recorded: one line a record, a curve where it was kept over time."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, quantity, right
from cortex_dsl.report.numbers import ABSENT, significant
from cortex_dsl.report.sparkline import sparkline
from engine.metrics import Recorded

WHEN = {"initial": "at the start", "final": "at the end"}
LONGEST_CURVE = 40
BESIDE_CURVE = 60
"""Columns that the rest of a line needs."""


def records_view(records: Sequence[Recorded], width: int) -> RenderableType:
    """Name, curve or moment, and the value or the range of the values."""
    room = max(8, min(LONGEST_CURVE, width - BESIDE_CURVE))
    rows = [
        (Text(record.name, "title"), _course(record, room), quantity(_extent(record), record.unit))
        for record in records
    ]
    return columns(left(wrap=True), left(), right(), rows=rows)


def _course(record: Recorded, width: int) -> Text:
    if record.when in WHEN:
        return Text(WHEN[record.when], "quiet")
    return Text(sparkline(record.values.tolist(), width), "bar")


def _extent(record: Recorded) -> str:
    """The value, or the range of the values that are numbers."""
    known = record.values[~np.isnan(record.values)]
    if len(known) == 0:
        return ABSENT
    low, high = significant(float(known.min())), significant(float(known.max()))
    return low if low == high else f"{low} .. {high}"
