"""What a search's failures are: how different, of what kinds, where, and what each gene does."""
