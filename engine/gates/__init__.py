"""Limits that the runs of a scenario must keep: bounds on results, and decisions on the rate of a failure."""
