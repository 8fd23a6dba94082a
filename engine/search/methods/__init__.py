"""The ways to search: one file each, with a class that asks and tells (see `engine.search.protocol`)."""
