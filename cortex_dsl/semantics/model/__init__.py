"""Data of the stage: values, the state of a file and of a variant, and the place of an expression."""
