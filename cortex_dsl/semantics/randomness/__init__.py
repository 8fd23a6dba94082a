"""Random values: params that a search chooses, draws, and finite choices, which make variants."""
