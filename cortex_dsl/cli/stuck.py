"""A behaviour that was caught looping without an action while it ran: the file's mistake, told like any other."""

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics.errors.chance import STUCK
from cortex_dsl.session import Scenario
from cortex_dsl.source import Source, Span


def never_acts(scenario: Scenario, row: int, time: float) -> Diagnostic:
    """The diagnostic for a run that got stuck at this row of step code, after `time` seconds."""
    source, budget = scenario.compiled.source, scenario.config.simulation.instruction_budget
    return STUCK.at(
        _line_span(source, int(scenario.program.step_lines[row])),
        label=f"still here after {budget:,} instructions, at {time:.2f} s",
    )


def _line_span(source: Source, line: int) -> Span:
    """A line without its indentation."""
    text, start = source.line(line), source.line_starts[line - 1]
    return Span(start + len(text) - len(text.lstrip()), start + len(text.rstrip()))
