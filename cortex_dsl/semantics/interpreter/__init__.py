"""Statements that the compiler runs: loops, branches, assertions and functions of the file. The remainder is data."""
