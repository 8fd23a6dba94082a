"""Numbers and sentences of a run, a search, a study or a recording, worded once; no rich and no HTML."""
