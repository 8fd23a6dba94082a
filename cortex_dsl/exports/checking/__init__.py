"""What was written, read back: `motion.py` holds it against the run, `documents.py` against each format's own rules."""
