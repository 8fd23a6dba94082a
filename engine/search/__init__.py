"""Searches over a scenario's genes: searchers (`ask`, `tell`), the campaign around them, and the files it leaves.

Nothing is imported here; take what you need from its module (`engine.search.run.search` runs a whole campaign).
"""
