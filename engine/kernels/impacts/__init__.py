"""Impacts between actors, and motion after them."""
