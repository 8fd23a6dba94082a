"""The search methods: classes that ask and tell (see `engine.search.protocol`), and their table, one row per method."""
