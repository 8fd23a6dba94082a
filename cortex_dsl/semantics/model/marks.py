"""Shared parts of variants are run once: the state before a statement is marked, and the next variant continues there.

Variants come depth first, so that the next variant repeats all but the last of the choices. Everything above the
statement of that choice has the same result. A mark copies the contents of lists and dictionaries, but no objects in
them: marks are made while there is no object of the scene, which later statements change, and no list of a function
that may outlive its call.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from cortex_dsl.semantics.model.choices import Oracle
from cortex_dsl.semantics.model.state import VariantState
from engine.frozen import frozen

_COPY: dict[type, Callable[[Any], Any]] = {each: each.copy for each in (list, dict, set, Counter)}
"""Copy function of each kind of container."""

Contents = dict[str, Any]


def _contents(holder: object) -> Contents:
    """The fields of a part of the state, containers copied."""
    return {name: _COPY[type(v)](v) if type(v) in _COPY else v for name, v in holder.__dict__.items()}


@frozen
class Mark:
    """The state of a variant before a statement."""

    statement: int
    decisions: int
    """How many choices had been made."""
    run: Contents
    made: Contents
    decided: Contents
    imported: dict[str, Contents]
    terms: tuple[int, ...]
    """`Algebra.sizes`"""


@dataclass
class Marks:
    """Marks of the last variant that the next variant may return to, in the order of the file."""

    run: VariantState | None = None
    marks: list[Mark] = field(default_factory=list)
    idle: set[int] = field(default_factory=set)
    """Statements without choices; a mark before them saves nothing."""

    def put(self, run: VariantState, statement: int) -> None:
        """Mark the state before a statement, where the next variant may go on."""
        self.run = run
        decisions = len(run.decisions.oracle.decisions)
        if self.marks and self.marks[-1].decisions == decisions:
            if self.marks[-1].statement == statement:
                return
            self.idle.add(self.marks.pop().statement)
        if statement in self.idle or run.built.actors or run.outlived:
            return
        imported = {name: dict(names) for name, names in run.imported.items()}
        whole, made, decided = map(_contents, (run, run.built, run.decisions))
        self.marks.append(Mark(statement, decisions, whole, made, decided, imported, run.algebra.sizes()))

    def back(self, oracle: Oracle) -> tuple[VariantState, int] | None:
        """Return the state for the next variant and the statement to continue at; None: start again."""
        same = len(oracle.script) - 1
        while self.marks and self.marks[-1].decisions > same:
            self.marks.pop()
        if self.run is None or self.run.outlived or not self.marks:
            self.close()
            return None
        run, mark = self.run, self.marks[-1]
        oracle.repeat(run.decisions.oracle, mark.decisions)
        for part, contents in ((run, mark.run), (run.built, mark.made), (run.decisions, mark.decided)):
            part.__dict__.update({name: _COPY[type(v)](v) if type(v) in _COPY else v for name, v in contents.items()})
        for name, names in mark.imported.items():
            run.imported[name].clear()
            run.imported[name].update(names)
        run.decisions.oracle = oracle
        run.algebra.forget_since(mark.terms)
        return run, mark.statement

    def close(self) -> None:
        """Discard the marks: no variant continues from the last one."""
        self.marks.clear()
        if self.run is not None:
            self.run.close()
        self.run = None


class Rewind:
    """The state of a variant, to which it is reset; the objects that were made since stay."""

    KEPT = ("actors", "actor_names", "numbered", "late")

    def __init__(self, run: VariantState) -> None:
        self.run, oracle = run, run.decisions.oracle
        self.built, self.decisions = _contents(run.built), _contents(run.decisions)
        self.oracle = list(oracle.decisions), oracle.ways

    def restore(self) -> None:
        """Reset the state. Callable once: the state then owns the stored containers."""
        run = self.run
        kept = {name: getattr(run.built, name) for name in self.KEPT}
        run.built.__dict__.update(self.built | kept)
        run.decisions.__dict__.update(self.decisions)
        run.decisions.oracle.decisions[:], run.decisions.oracle.ways = self.oracle
