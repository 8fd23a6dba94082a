"""Numbers with a dimension, arithmetic on expressions, and what is known of a number before the run knows it."""
