"""Statements as what they do: those of the top level, behaviours as acts of the IR, and what is looked at in a run."""
