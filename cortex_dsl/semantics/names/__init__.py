"""Names before values: what is called what, what a file is given, where a statement may stand, and what is built in."""
