"""The page of metrics says what the tables say: `UPDATE_GOLDEN=1 pytest tests/test_metrics_page.py` writes it."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

from engine.metrics.table import OF_ACTORS, OF_PAIRS
from engine.outcomes import PAIRS

PAGE = Path(__file__).parent.parent / "docs" / "reference" / "metrics.md"
TABLE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
HEAD = ("symbol", "", "unit", "what a report tells", "formula", "source")


def markdown(rows: Iterator[tuple[str, ...]]) -> str:
    lines = [HEAD, ("---",) * len(HEAD), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def deciding() -> Iterator[tuple[str, ...]]:
    """Those of a pair that every simulation yields."""
    for row in PAIRS:
        if row.symbol:
            yield f"`{row.symbol}`", "", row.unit, row.meaning, row.formula, row.source


def table(name: str) -> str:
    if name == "deciding":
        return markdown(deciding())
    rows = {"pairs": OF_PAIRS, "actors": OF_ACTORS}[name]
    cells = ((f"`{row.symbol}`", row.title, row.unit, row.meaning, row.formula, row.source) for row in rows)
    remarks = "".join(f"- `{row.symbol}`: {row.remark}\n" for row in rows if row.remark)
    return f"{markdown(cells)}\n{remarks}"


def test_the_page_has_every_metric_with_formula_and_source() -> None:
    """The tables are made from the rows; what stands around them is the author's."""
    text = PAGE.read_text(encoding="utf-8")
    made = TABLE.sub(lambda match: f"{match[1]}{table(match[2])}{match[3]}", text)
    if os.environ.get("UPDATE_GOLDEN"):
        PAGE.write_text(made, encoding="utf-8")
    assert text == made or os.environ.get("UPDATE_GOLDEN")
    assert {match[2] for match in TABLE.finditer(text)} == {"deciding", "pairs", "actors"}


def test_every_row_says_what_it_is() -> None:
    """Unit and remark may be left out, nothing else."""
    for row in (*OF_PAIRS, *OF_ACTORS):
        assert row.symbol
        assert row.title
        assert row.meaning
        assert row.formula
        assert row.source
    for result in PAIRS:
        assert not result.symbol or (result.formula and result.source)
    symbols = [row.symbol for row in (*OF_PAIRS, *OF_ACTORS)] + [row.symbol for row in PAIRS if row.symbol]
    assert len(symbols) == len(set(symbols))
