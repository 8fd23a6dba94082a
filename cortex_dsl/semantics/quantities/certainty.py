"""What is certain of a `require`, whatever a search chooses and however scenes are drawn."""

from collections.abc import Mapping

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.quantities.algebra import parts
from cortex_dsl.semantics.quantities.intervals import Interval
from engine.frozen import frozen


@frozen
class Weight:
    """Of one `require` over all variants in which it was met."""

    possible: bool
    """Whether it could hold in one of them."""
    certain: bool
    """Whether it holds in all of them."""
    genes: frozenset[int]
    """On which genes it depends."""

    def joined(self, other: "Weight | None") -> "Weight":
        """Of the variants of both."""
        if other is None:
            return self
        return Weight(self.possible or other.possible, self.certain and other.certain, self.genes | other.genes)

    def labels(self, genes: Mapping[str, ir.GeneInfo]) -> tuple[Label, ...]:
        """The declared ranges of its genes."""
        return _labels(self.genes, genes)


def weigh(condition: ir.Expr, truth: Interval, *, certain: bool) -> Weight:
    """A condition whose truth lies in an interval; without `certain` it is not tested in every scene."""
    return Weight(not certain or truth != (0.0, 0.0), truth[0] > 0.0, _genes(condition))


def range_labels(expression: ir.Expr, genes: Mapping[str, ir.GeneInfo]) -> tuple[Label, ...]:
    """The declared ranges of the genes that an expression depends on."""
    return _labels(_genes(expression), genes)


def _genes(expression: ir.Expr) -> frozenset[int]:
    return frozenset(part.index for part in parts(expression) if isinstance(part, ir.Gene))


def _labels(indices: frozenset[int], genes: Mapping[str, ir.GeneInfo]) -> tuple[Label, ...]:
    known = list(genes.values())
    return tuple(Label(known[i].span, _range(known[i])) for i in sorted(indices))


def _range(gene: ir.GeneInfo) -> str:
    if gene.options:
        return f"`{gene.name}` is one of {len(gene.options)} options"
    unit = f" {gene.unit}" if gene.unit else ""
    return f"`{gene.name}` lies between {gene.low:g} and {gene.high:g}{unit}"
