"""Inputs that might break a command: made at random, and each judged. One module for each kind of input."""
