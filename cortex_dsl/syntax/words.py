"""Words with a meaning of their own."""

RESERVED = frozenset({
    "False", "None", "True", "and", "as", "assert", "async", "at", "await", "break", "by", "class", "continue",
    "def", "del", "do", "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in",
    "is", "lambda", "new", "nonlocal", "not", "of", "on", "or", "pass", "raise", "require", "return", "to",
    "try", "until", "while", "with", "yield",
})  # fmt: skip
"""Words that are never names; the same as in the grammar's NAME (a test compares them)."""

BLOCK_WORDS = frozenset({
    "behavior", "if", "elif", "else", "while", "try", "interrupt", "for", "def", "class", "with", "except",
    "finally", "monitor", "scenario", "setup", "compose", "precondition", "invariant",
})  # fmt: skip
"""Words whose lines go on in deeper ones; a guard only by mistake."""

GUARDS = frozenset({"precondition", "invariant"})
TEMPORAL_PREFIXES = frozenset({"always", "eventually", "next"})
TEMPORAL = TEMPORAL_PREFIXES | {"until", "implies"}
SPECIFIER_WORDS = frozenset({
    "at", "in", "on", "with", "offset", "ahead", "behind", "left", "right", "following", "facing", "before",
    "after",
})  # fmt: skip
