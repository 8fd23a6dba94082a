"""MCAP for Foxglove, Lichtblick and rerun: who is where at each sample, and with which numbers."""

from engine.interchange.mcap.write import write_mcap

__all__ = ["write_mcap"]
