"""Statements that the compiler runs: loops, branches, assertions and functions of the file. What is left is data."""
