"""Which genes can influence anything that is drawn, run or judged: those of all others a search varies for nothing.

A gene is alive if an object's property, a requirement, a rule, a monitor or an act that can be reached depends on it,
or a choice that it makes. An operation whose result lies in an interval of one number depends on nothing.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.algebra import folded
from cortex_dsl.semantics.quantities.intervals import Interval, part_interval
from engine.vocabulary import Op

NOTHING: frozenset[ir.Expr] = frozenset()
ENDLESS = (ir.Terminate, ir.Leave, ir.Abort, ir.HoldSpeed)
"""Acts after which the next of their block is never reached."""


def live_genes(scenario: ir.Scenario, bounds: Mapping[int, Interval]) -> set[int]:
    """Indices of the genes that matter; `bounds` are their SI bounds."""
    live: set[int] = set()
    for variant in scenario.variants:
        live.update(gene for gene, _ in variant.gene_options)
        if variant.rejection is None and len(live) < len(scenario.genes):
            live |= _Walk(bounds).over(variant)
    return live


@dataclass
class _Walk:
    """What is reached in one variant."""

    bounds: Mapping[int, Interval]
    genes: set[int] = field(default_factory=set)
    locals: set[int] = field(default_factory=set)
    assigned: dict[int, list[ir.Expr]] = field(default_factory=dict)
    """Values of locals that nothing is known to read yet."""
    seen: set[int] = field(default_factory=set)

    def over(self, variant: ir.Variant) -> set[int]:
        for root in (variant.actors, [r.condition for r in variant.requirements], variant.rules, variant.monitors):
            self.visit(root)
        return self.genes

    def visit(self, node: object) -> None:
        """Everything below a node of the IR."""
        match node:
            case ir.Expr():
                self._expression(node)
            case ir.SetLocal(index=index, value=value):
                self._assignment(index, value)
            case ir.Branch(condition=condition, then=then, otherwise=otherwise):
                self.visit(condition)
                for block in self._taken(condition, then, otherwise):
                    self._block(block)
            case ir.Loop(condition=condition, body=body):
                self.visit(condition)
                for block in self._taken(condition, body, ()):
                    self._block(block)
            case ir.TryInterrupt(body=body, handlers=handlers):
                self._block(body)
                for condition, block in handlers:
                    self.visit(ir.Branch(node.span, condition, block, ()))
            case tuple() | list():
                self._block(node)
            case _ if is_dataclass(node) and not isinstance(node, type):
                for part in fields(node):
                    self.visit(getattr(node, part.name))

    def _block(self, acts: Iterable[object]) -> None:
        for act in acts:
            self.visit(act)
            if isinstance(act, ENDLESS) or (isinstance(act, ir.Loop) and self._never_left(act)):
                return

    def _taken(self, condition: ir.Expr, then: ir.Block, otherwise: ir.Block) -> Iterator[ir.Block]:
        low, high = self._worth(condition)[0]
        if (low, high) != (0.0, 0.0):
            yield then
        if not (low > 0.0 or high < 0.0):
            yield otherwise

    def _never_left(self, loop: ir.Loop) -> bool:
        return self._worth(loop.condition)[0][0] > 0.0 and not _breaks(loop.body)

    # -- expressions -------------------------------------------------------------------------------------------------

    def _expression(self, expression: ir.Expr) -> None:
        if id(expression) in self.seen:
            return
        self.seen.add(id(expression))
        for leaf in self._worth(expression)[1]:
            if isinstance(leaf, ir.Gene):
                self.genes.add(leaf.index)
            elif isinstance(leaf, ir.Local) and leaf.index not in self.locals:
                self.locals.add(leaf.index)
                for value in self.assigned.pop(leaf.index, []):
                    self._expression(value)

    def _assignment(self, index: int, value: ir.Expr) -> None:
        if index in self.locals:
            self._expression(value)
        else:
            self.assigned.setdefault(index, []).append(value)

    def _worth(self, expression: ir.Expr) -> tuple[Interval, frozenset[ir.Expr]]:
        """Where the value lies, and the genes and locals that it depends on."""
        return folded(expression, self._part)

    def _part(
        self, part: ir.Expr, known: list[tuple[Interval, frozenset[ir.Expr]]]
    ) -> tuple[Interval, frozenset[ir.Expr]]:
        if isinstance(part, ir.Gene | ir.Local):
            return part_interval(part, (), self.bounds), frozenset({part})
        within = part_interval(part, [each for each, _ in known], self.bounds)
        if within[0] == within[1]:
            return within, NOTHING
        if isinstance(part, ir.Apply) and part.op == Op.SELECT and known[0][0] in ((0.0, 0.0), (1.0, 1.0)):
            return known[1] if known[0][0] == (1.0, 1.0) else known[2]
        return within, frozenset().union(*(leaves for _, leaves in known))


def _breaks(node: object) -> bool:
    """Whether a block leaves its loop; a `break` of an inner loop counts too, to be on the safe side."""
    if isinstance(node, ir.Leave):
        return node.kind == "break"
    if isinstance(node, tuple):
        return any(map(_breaks, node))
    return isinstance(node, ir.Act) and any(_breaks(getattr(node, part.name)) for part in fields(node))
