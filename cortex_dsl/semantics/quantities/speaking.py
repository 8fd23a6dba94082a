"""In which unit a file speaks of a dimension: messages about its requirements use the same one."""

from collections.abc import Iterator, Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.algebra import leaves
from cortex_dsl.semantics.quantities.units import UNITS
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.syntax import nodes


def spoken_unit(
    written: nodes.Expression, condition: ir.Expr, dimension: ir.Dimension, genes: Mapping[str, ir.GeneInfo]
) -> str:
    """The first unit of a dimension that a condition writes, else that of a param it reads; "" where there is none."""
    words = (*_written(written), *param_units(condition, genes))
    return next((word for word in words if word in UNITS and UNITS[word].dimension == dimension), "")


def _written(condition: nodes.Expression) -> Iterator[str]:
    for node in (condition, *everything_in(condition)):
        match node:
            case nodes.Number(unit=str(word)) | nodes.WithUnit(unit=word):
                yield word
            case nodes.Degrees():
                yield "deg"


def param_units(condition: ir.Expr, genes: Mapping[str, ir.GeneInfo]) -> Iterator[str]:
    """The units of the params that an expression reads, in the order of the file; "" of those without."""
    read = {leaf.index for leaf in leaves(condition) if isinstance(leaf, ir.Gene)}
    yield from (gene.unit for index, gene in enumerate(genes.values()) if index in read)
