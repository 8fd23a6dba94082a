"""Readers of simulator and data set files that are not a table with a row per actor and time: one file per format, with
a function from a path to `Tracks`.
"""
