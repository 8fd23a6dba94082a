"""The proof that no scene of a file exists, as a diagnostic."""

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics.errors.values import INFEASIBLE
from cortex_dsl.source import Source, Span
from engine.feasibility import Feasibility
from engine.program import Program


def no_scene_at_all(program: Program, source: Source, found: Feasibility) -> Diagnostic:
    """The diagnostic for an infeasible file."""
    named = [r for r in found.conflict if program.requirements[r].line] or list(found.conflict)
    spans = [line_span(source, program.requirements[r].line) for r in named if program.requirements[r].line]
    names = [f"`{program.requirements[r].name}`" for r in found.conflict]
    return INFEASIBLE.at(
        spans[0] if spans else Span(0, 0),
        label="cannot hold" if len(names) == 1 else "cannot hold together with the rest",
        secondary=tuple(Label(span, "and this") for span in spans[1:]),
        reason=_reason(names),
        cure=_cure(len(names), built_in=not spans),
    )


def _cure(requirements: int, *, built_in: bool) -> str:
    if built_in:
        return "place the objects elsewhere, or widen the range of a param that their places depend on"
    if requirements > 1:
        return "relax one of them, or widen the range of a param that it reads"
    return (
        "relax it; without `--check` the report says by how much. `require` alone is a condition on the start, "
        "`require always …` on the whole run, `require eventually …` on some moment of it"
    )


def _reason(names: list[str]) -> str:
    if not names:
        return "each way of making the file's choices is ruled out by some requirement"
    if len(names) == 1:
        return f"{names[0]} fails for everything that can be drawn"
    return f"{', '.join(names[:-1])} and {names[-1]} exclude each other for everything that can be drawn"


def line_span(source: Source, line: int) -> Span:
    """A line without its indentation."""
    text, start = source.line(line), source.line_starts[line - 1]
    return Span(start + len(text) - len(text.lstrip()), start + len(text.rstrip()))
