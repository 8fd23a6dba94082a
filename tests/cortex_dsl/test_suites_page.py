"""The reference page of the suites has a row for each group of each suite."""

import os
import re
from pathlib import Path

from cortex_dsl.api.suite_tables import NEEDS, Group, suite_names, suite_of

FILE = Path(__file__).parents[2] / "docs" / "reference" / "suites.md"
HEAD = "| group | cells | scenario, or why it is not run | status | source |\n|---|---|---|---|---|\n"
TABLE = re.compile(r"(<!-- suite: (\S+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def row(group: Group) -> str:
    """Return the line of a group."""
    cell = group.cells[0]
    what = cell.reason or f"`{group.file.name if group.file else ''}`, {cell.rule}"
    what += f"; needs {NEEDS[group.needs]}" if group.needs else ""
    sources = ", ".join(dict.fromkeys(each.source for each in group.cells))
    return f"| {group.name} | {len(group.cells)} | {what} | {cell.status} | {sources} |\n"


def table(name: str) -> str:
    """Return the edition, the notes and the table of a suite."""
    suite = suite_of(name)
    notes = "".join(f"- {note}\n" for note in suite.notes)
    return f"\nEdition: {suite.edition}.\n\n{notes}\n{HEAD}{''.join(row(group) for group in suite.groups)}\n"


def test_the_page_has_the_tables_of_the_suites() -> None:
    """`UPDATE_GOLDEN=1` writes them."""
    page = FILE.read_text(encoding="utf-8")
    expected = TABLE.sub(lambda found: f"{found[1]}{table(found[2])}{found[4]}", page)
    if os.environ.get("UPDATE_GOLDEN"):
        FILE.write_text(expected, encoding="utf-8")
        return
    assert page == expected
    assert {found[2] for found in TABLE.finditer(page)} == set(suite_names())
