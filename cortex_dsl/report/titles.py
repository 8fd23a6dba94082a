"""What a scenario is called at the top of its report."""

from rich.text import Text

from cortex_dsl.report.layout import heading
from cortex_dsl.report.run_document import first_line, name_of
from engine.program import Program


def title_of(program: Program) -> Text:
    """The name of a scenario and the first line of its docstring."""
    return heading(name_of(program), first_line(program.description))
