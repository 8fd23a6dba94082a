"""Variants arranged by what the genes decide."""

from itertools import product

import numpy as np

from cortex_dsl import ir
from engine.frozen import frozen
from engine.vocabulary import GeneKind


@frozen
class Grouping:
    """Variants arranged by what the genes decide: within a group, chance alone picks the variant."""

    genes: tuple[int, ...]
    sizes: tuple[int, ...]
    start: tuple[int, ...]
    variants: tuple[ir.Variant, ...]
    """Group after group; a variant that leaves a gene open stands in several groups."""
    cumulative: tuple[float, ...]


def group_variants(scenario: ir.Scenario) -> Grouping:
    genes = sorted({gene for variant in scenario.variants for gene, _ in variant.gene_options})
    sizes = [_option_count(scenario.genes[gene]) for gene in genes]
    start, arranged, cumulative = [0], [], []
    for options in product(*(range(size) for size in sizes)):
        decided = dict(zip(genes, options, strict=True))
        members = [v for v in scenario.variants if all(decided[g] == option for g, option in v.gene_options)]
        weights = np.array([v.probability for v in members])
        arranged += members
        cumulative += list(np.cumsum(weights) / weights.sum())
        start.append(len(arranged))
    return Grouping(tuple(genes), tuple(sizes), tuple(start), tuple(arranged), tuple(cumulative))


def _option_count(gene: ir.GeneInfo) -> int:
    return len(gene.options) if gene.kind == GeneKind.INDEX else int(gene.high - gene.low) + 1
