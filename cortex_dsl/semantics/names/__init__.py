"""Names before values: definitions, inputs of a file, places of statements, and built-in names."""
