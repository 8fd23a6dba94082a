"""Interval reasoning over a compiled program: what cannot hold, proved before anything is drawn. Plain numpy.

`explain` looks at a file as a whole: impossible variants, the part of each gene's range that can hold, or that nothing
can; `remembered` keeps the answer for the next time. `pruning` bounds the draws of single genomes. Nothing here is ever
wrong; all may know less than is true.

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
