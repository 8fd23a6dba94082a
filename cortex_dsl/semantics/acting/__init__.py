"""Behaviours as acts of the IR, those of the library among them."""
