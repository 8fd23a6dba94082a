"""What does all of this come to, at once? Texts that run to the end in both hosts, and processes that are killed."""
