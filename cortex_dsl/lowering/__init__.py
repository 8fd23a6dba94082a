"""Lowering: the checked scenario becomes a `Program`."""

from cortex_dsl.lowering.program import lower

__all__ = ["lower"]
