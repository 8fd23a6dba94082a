"""Compilation of statements: top level to effects, behaviours to acts of the IR, conditions to values of a run."""
