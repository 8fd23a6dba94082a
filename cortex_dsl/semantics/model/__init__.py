"""What the stage works on: values, what it gathers of a file and of a variant, and the place of an expression."""
