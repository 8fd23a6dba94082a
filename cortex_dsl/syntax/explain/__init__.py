"""Explain a syntax error: `table` holds the likely mistakes, the files beside it the rules that know them."""
