"""Evaluation of expressions: a module for each family."""
