"""The ways to search: classes that ask and tell (see `engine.search.protocol`), and their table, one row a method."""
