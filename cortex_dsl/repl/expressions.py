"""A single expression, evaluated as if it were at the end of the draft: its kind, and its values in scenes."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from cortex_dsl.diagnostics import CompileError, Diagnostic, Label, Severity
from cortex_dsl.editor.analysis import described
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.repl.draft import keys
from cortex_dsl.repl.state import STAND_IN, STILL_TO_COME, State, refuse
from cortex_dsl.semantics.model.context import ObservedValues, ValueRecorder
from cortex_dsl.semantics.model.values import Truth
from cortex_dsl.semantics.names.builtins import OVER_RUN
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.syntax.words import TEMPORAL

# -- its kind, unit and range, as far as they are known before a run ---------------------------------------------------

PLACE = "it = "
"""The expression is looked at as the value of this assignment, at the end of the draft."""


def show_value(state: State, expression: str) -> None:
    """Print the kind and value of an expression; the draft does not change."""
    text = f"{state.draft.text}{PLACE}{expression}\n"
    start = len(state.draft.text) + len(PLACE)
    witness = ValueRecorder()
    source = Source(state.name, text)
    try:
        compile_source(source, state.overrides, observe=witness)
    except CompileError as error:
        if _refused(state, error, expression, start, len(PLACE)):
            return
    seen = witness.seen.get(Span(start, start + len(expression.rstrip()))) or _widest(witness, start)
    description = described(seen) if seen else ""
    if description:
        state.terminal.out.print(description, soft_wrap=True)
    else:
        state.terminal.out.print("it has a value in the simulation only", style="quiet")


def _refused(state: State, error: CompileError, typed: str, start: int, before: int) -> bool:
    """Return whether an error is about the typed text; show it if so.

    The typed text begins at an offset after `before` letters of ours. The error is shown as if the text were alone
    below the draft.
    """
    wrong = [d for d in error.diagnostics if _is_about(d, start - before)]
    if not wrong:
        return False
    top = len(state.draft.text)
    whole = Source(state.name, f"{state.draft.text}{typed}\n")
    refuse(state, whole, [_moved(each, start, Span(top, top + len(typed))) for each in wrong])
    return True


def _is_about(diagnostic: Diagnostic, start: int) -> bool:
    grave = diagnostic.severity is Severity.ERROR and diagnostic.code not in STILL_TO_COME
    return grave and diagnostic.label.span.end >= start


def _moved(diagnostic: Diagnostic, start: int, typed: Span) -> Diagnostic:
    """Return the diagnostic with places in the typed text, which was evaluated from `start` on."""

    def placed(offset: int) -> int:
        return offset if offset <= typed.start else min(max(offset - start + typed.start, typed.start), typed.end)

    def moved(label: Label) -> Label:
        return replace(label, span=Span(placed(label.span.start), placed(label.span.end)))

    return replace(diagnostic, label=moved(diagnostic.label), secondary=tuple(map(moved, diagnostic.secondary)))


def _widest(witness: ValueRecorder, start: int) -> ObservedValues:
    """Return the values of the whole expression; its span may leave out brackets around it."""
    fitting = [span for span in witness.seen if span.start >= start]
    return witness.seen[min(fitting, key=lambda span: (span.start, -span.end))] if fitting else ()


# -- several, each named in a statement that makes it a result of scenes or of runs ------------------------------------


class Over(Enum):
    """Domain of an expression; the value is the statement that evaluates it."""

    SCENE = "record initial"
    """The start of a run."""
    RUN = "maximize"
    """A number of the whole run."""
    FORMULA = "expect"
    """A condition on the whole run."""


@dataclass(frozen=True)
class Probe:
    """One expression, worked out under a name."""

    text: str
    over: Over
    name: str
    is_truth: bool = False


@dataclass(frozen=True)
class Probed:
    """The draft with some probes below it."""

    compiled: Compiled
    probes: tuple[Probe, ...]
    whole: bool
    """Whether it has an ego of its own, so that its runs mean something."""


def probed(state: State, expressions: Sequence[str]) -> Probed | None:
    """Compile the draft with a statement for each expression; None if one of them is wrong, which is reported.

    Raises:
        UsageError: the draft cannot be sampled.
    """
    probes: list[Probe] = []
    for number, text in enumerate(expressions, start=1):
        over = _over(state, text)
        if over is None:
            return None
        probes.append(Probe(text, over, f"expression {number} of :plot"))
    whole = not state.checked.missing
    if state.checked.errors or not (whole or all(_needs_nobody(each) for each in probes)):
        raise state.not_ready()
    return _compiled(state, probes, whole)


def _compiled(state: State, probes: Sequence[Probe], whole: bool) -> Probed | None:
    text = state.draft.text + ("" if whole else STAND_IN)
    starts: list[int] = []
    for probe in probes:
        starts.append(len(text) + len(probe.over.value) + 2)
        text += f'{probe.over.value} ({probe.text}) as "{probe.name}"\n'
    witness = ValueRecorder()
    try:
        compiled = compile_source(Source(state.name, text), state.overrides, observe=witness)
    except CompileError as error:
        for probe, start in reversed(list(zip(probes, starts, strict=True))):
            if _refused(state, error, probe.text, start, len(probe.over.value) + 2):
                return None
        refuse(state, error.source, error.diagnostics)
        return None
    truths = [_is_truth(_at(witness, start, probe.text)) for probe, start in zip(probes, starts, strict=True)]
    named = (replace(probe, is_truth=truth) for probe, truth in zip(probes, truths, strict=True))
    return Probed(compiled, tuple(named), whole)


def _over(state: State, text: str) -> Over | None:
    """Return the domain of an expression; None for invalid input, which is reported."""
    module = _parsed(state, f"{Over.FORMULA.value} ", text, or_else=PLACE)
    if module is None:
        return None
    inside = list(everything_in(module))
    if any(isinstance(node, nodes.Temporal) for node in inside):
        return Over.FORMULA
    own = {name for entry in state.draft.entries for _, name in keys(entry)}
    return Over.RUN if _names(inside) & (OVER_RUN.keys() - own) else Over.SCENE


def _parsed(state: State, before: str, text: str, or_else: str = "") -> nodes.Module | None:
    """Return the expression in a statement that permits conditions on the run.

    For a mistake, the diagnostic is that of the plainest statement.
    """
    blank = re.sub(r"[^\n]", " ", state.draft.text)
    try:
        return parse(Source(state.name, f"{blank}{before}{text}\n"))
    except CompileError as error:
        if or_else and not re.search(rf"\b({'|'.join(sorted(TEMPORAL))})\b", text):
            return _parsed(state, or_else, text)
        if not _refused(state, error, text, len(blank) + len(before), len(before)):
            refuse(state, error.source, error.diagnostics)
        return None


def _needs_nobody(probe: Probe) -> bool:
    """Return whether an expression has a meaning while there is no ego yet."""
    inside = everything_in(parse(Source("", f"{PLACE}{probe.text}\n"))) if probe.over is Over.SCENE else None
    return inside is not None and "ego" not in _names(inside)


def _names(inside: Iterable[nodes.Node]) -> set[str]:
    return {node.id for node in inside if isinstance(node, nodes.Name)}


def _at(witness: ValueRecorder, start: int, text: str) -> ObservedValues:
    within = {s: seen for s, seen in witness.seen.items() if start <= s.start and s.end <= start + len(text)}
    return within[max(within, key=lambda span: span.end - span.start)] if within else ()


def _is_truth(seen: ObservedValues) -> bool:
    return bool(seen) and isinstance(seen[0].value, Truth)
