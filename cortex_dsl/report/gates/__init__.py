"""Formats of the result of `cortexc test` for other programs, a file for each."""
