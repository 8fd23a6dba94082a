"""Searches over a scenario's genes: searchers that ask and are told, the campaign around them, and what it leaves.

Nothing is imported here; take what you need from its module (`engine.search.run.search` runs a whole campaign).
"""
