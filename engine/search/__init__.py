"""Searches over a scenario's genes: searchers (`ask`, `tell`), the campaign around them, and the files that it writes.

Nothing is imported here; import from the modules (`engine.search.run.search` runs a whole campaign).
"""
