"""What simulators and data sets write otherwise than as a table with a row for each actor and time: a file a format,
each a function from a path to `Tracks`.
"""
