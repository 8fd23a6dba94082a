"""How large a file may be and how deep it may nest: hostile or generated input gets a message, never a hang."""

MAX_BYTES = 1 << 18
"""Size of a file [bytes]."""

MAX_DEPTH = 100
"""Brackets inside brackets, blocks inside blocks, and operators inside operators."""

MAX_ERRORS = 20
"""Errors reported in one run."""
