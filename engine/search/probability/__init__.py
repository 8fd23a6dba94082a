"""Probability of a collision under a file's distributions: plain Monte Carlo; two methods for rare events."""
