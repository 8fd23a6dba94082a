"""Semantics: from the syntax tree to the checked IR; `elaboration.elaborate` is the stage."""
