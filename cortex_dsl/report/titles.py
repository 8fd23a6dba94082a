"""What a scenario is called at the top of its report."""

import re
from pathlib import PurePath

from rich.text import Text

from cortex_dsl.report.layout import heading
from engine.program import Program

CASE = re.compile(r"# case (\d+) of a search in (.+): risk ")
"""The first line of a case that a search has written; its file is called by its number alone."""


def title_of(program: Program) -> Text:
    """The name of a scenario and the first line of its docstring."""
    return heading(name_of(program), first_line(program.description))


def name_of(program: Program) -> str:
    """The stem of its file; of a case the stem of the file that was searched, and its number."""
    case = CASE.match(program.source_text)
    if case is None or not program.name.isdigit():
        return program.name
    return f"{PurePath(case[2]).stem}, case {int(case[1])}"


def first_line(description: str) -> str:
    """The first line of a docstring."""
    return description.strip().splitlines()[0] if description.strip() else ""
