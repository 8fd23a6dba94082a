"""Interval reasoning over a compiled program: proofs of impossibility before any draw. Plain numpy.

`explain` analyses a file as a whole: impossible variants, the part of each gene's range that can hold, or that none
can; `remembered` caches the answer. `pruning` bounds the draws of single genomes. All results are sound, but may be
weaker than the truth.

tape -> slices (what holds for the program) -> narrowing (what holds in a box) -> explanation, pruning
"""

from engine.feasibility.explanation import Cut, Feasibility, conflicts, explain, remembered
from engine.feasibility.tape import genes_read

__all__ = [
    "Cut",
    "Feasibility",
    "conflicts",
    "explain",
    "genes_read",
    "remembered",
]
