"""ASAM OpenDRIVE files as data: roads, lanes, links and junctions. Independent of `engine.road`."""
