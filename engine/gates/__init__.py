"""Limits that runs must keep: bounds on results, decisions on the rate of a failure; pairs of runs of two drivers."""
