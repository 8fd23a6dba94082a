"""Names: what is called what, where a statement may stand, and what nobody reads."""
