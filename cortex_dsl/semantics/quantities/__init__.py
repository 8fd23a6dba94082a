"""Numbers with a dimension, arithmetic on expressions, and static bounds of numbers."""
