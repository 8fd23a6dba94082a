"""MCAP for Foxglove, Lichtblick and rerun: the place of each actor at each sample, and its numbers."""

from engine.interchange.mcap.write import write_mcap

__all__ = ["write_mcap"]
