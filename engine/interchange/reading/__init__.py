"""The way back: scenarios of timed polylines and the roads they play on, read as if strangers had written them.

xml, node (safe reading) -> parameters, catalogs -> planview, opendrive, positions -> entities, storyboard,
trajectories, tracks, motion, timeline -> openscenario. Whatever is wrong with a file is an `InterchangeError`.
"""
