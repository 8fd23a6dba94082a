"""Explain a syntax error: `table` lists the likely mistakes, the other files of this folder contain their rules."""
